// Depth images: meters out of a file, and which file belongs to which image.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estancia/io/formats.hpp"

namespace estancia::io {

/// Reads a depth image (one channel, or several equal ones; 8 or 16 bits, or float: PNG, TIFF, OpenEXR,
/// PFM, PGM; PCD: z of an organized cloud) as meters, CV_32F. `unitsPerMeter` is what a meter is in its
/// numbers; 0 takes what is usual for its kind (see SequenceOptions::depthScale). 0, what is not finite or
/// negative, and 65535 in 16 bits become 0: no depth. Throws Error when the file cannot be read or holds
/// colors.
cv::Mat readDepth(const std::filesystem::path& file, double unitsPerMeter);

/// Suffixes of the files that readDepth takes from folders, lower case; JPEG would blur depth.
const std::vector<std::string>& depthSuffixes();

/// A depth image and when it was taken.
struct TimedFile {
  double timestamp;
  std::filesystem::path file;
};

/// The depth of an image taken at `time`: the nearest of `files` (sorted by time), if at most 0.02 s away,
/// as the TUM benchmark's own tool has it. The time stamp is that of the nearest either way.
DepthFile nearestDepth(const std::vector<TimedFile>& files, double time);

}  // namespace estancia::io
