// Color searches: models of color cases looked for in their scenes, and neural gases beside the true surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recognition/color_recognition.hpp"

namespace estancia::experiments {

/// Counts of all searches, by part: "choose" and "report", which are the even and the odd searches, and
/// "report, GROUP".
CellResults searchWith(const ColorCases& cases, const ColorRecognitionOptions::Condition& condition,
                       const ColorRecognitionOptions& options);

/// A gas with this weight of color over five frames of a drive with noise, beside those without it: the
/// distance of neurons from the true surface (root mean square [m]) and the difference of each true point's
/// color to that of the nearest neuron (root mean square, CIELAB).
CellResults gasErrors(const DriveCasesOptions& drive, double weight, std::size_t neurons);

}  // namespace estancia::experiments
