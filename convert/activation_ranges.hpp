// Activation ranges: between which numbers the values inside of a network lie, as a table of text.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace estancia::convert {

/// Range of one value that 8 bits must represent; low ≤ 0 ≤ high, so that 0 is one of the 256 steps.
struct ActivationRange {
  float low = 0, high = 0;
  bool operator==(const ActivationRange&) const = default;
};

/// By the value's name in the network.
using ActivationRanges = std::map<std::string, ActivationRange>;

/// Reads lines `LOW HIGH NAME`; those that begin with # are comments. Throws Error `FILE:LINE: …` on
/// anything else, and on a value that is named twice.
ActivationRanges readRanges(const std::filesystem::path& file);

/// The text of such a file after a comment of one line; reading it gives the same numbers to the bit.
std::string rangesText(const ActivationRanges& ranges, const std::string& comment);

}  // namespace estancia::convert
