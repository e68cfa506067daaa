// Descriptor figures: how an image's PHOG, GIST and ESF come about (thesis Fig. 3.3 to 3.5).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "estancia/describe/features.hpp"
#include "estancia/findings/findings.hpp"

namespace estancia::experiments {

/// Drawn from the numbers of the first frame of `features`, whose image this is. Absent where it has none of
/// the three.
std::optional<Images> descriptorFigures(const cv::Mat& image, const Features& features);

}  // namespace estancia::experiments
