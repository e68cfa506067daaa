// Depth images: read as meters, and association of depth with color images by time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <iterator>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

namespace estancia::io {

/// Reads a depth image (one channel, or several equal ones; 8 or 16 bits, or float: PNG, TIFF, OpenEXR, PFM,
/// PGM; PCD: z of an organized cloud) as meters, CV_32F. `unitsPerMeter` 0 takes the default of the image
/// type (see SequenceOptions::depthScale). 0, values that are not finite or negative, and 65535 in 16 bits
/// become 0: no depth. Throws Error when the file cannot be read or holds colors.
cv::Mat readDepth(const std::filesystem::path& file, double unitsPerMeter);

/// Converts a decoded depth image of one channel. `name` stands in errors. Throws Error (unsupportedFile).
cv::Mat metersOf(const cv::Mat& raw, double unitsPerMeter, const std::string& name);

/// Extensions of the depth images in folders, lower case; no JPEG, which would blur depth.
const std::vector<std::string>& depthSuffixes();

/// A frame's depth image: "" where it has none.
struct DepthFile {
  std::filesystem::path file;
  /// Time of the nearest depth image, even where that is not this frame's.
  std::optional<double> timestamp;
};

/// A depth image and its time stamp.
struct TimedFile {
  double timestamp;
  std::filesystem::path file;
};

/// The element of `sorted` (by time, not empty) that is nearest to `time`.
template <class Elements, class Time, class TimeOf>
auto nearestInTime(const Elements& sorted, Time time, const TimeOf& timeOf) {
  auto nearest = std::ranges::lower_bound(sorted, time, {}, timeOf);
  if (nearest == sorted.end() ||
      (nearest != sorted.begin() &&
       time - std::invoke(timeOf, *std::prev(nearest)) < std::invoke(timeOf, *nearest) - time))
    --nearest;
  return nearest;
}

/// The depth of an image taken at `time`: the nearest of `files` (sorted by time) if it is at most 0.02 s
/// away, as in the TUM benchmark's associate.py. The time stamp is that of the nearest either way.
DepthFile nearestDepth(const std::vector<TimedFile>& files, double time);

}  // namespace estancia::io
