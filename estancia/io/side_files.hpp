// Side files: poses and rooms from files beside the images.
#pragma once

#include <filesystem>

#include "estancia/io/formats.hpp"
#include "estancia/io/trajectory.hpp"

namespace estancia::io {

/// Gives every frame the pose nearest in time, at most `maxGap` [s] away; not interpolated, so that every
/// pose is a measured one. Where frames or poses have no time stamps, or no time stamp matches at all (two
/// clocks), lists of equal length are matched by order. Throws Error when neither is possible.
void attachPoses(ListedSequence& sequence, const Trajectory& trajectory, const std::filesystem::path& file,
                 double maxGap);

/// Sets the rooms of frames from the CSV `image,room` (by frame name or its last component), and their splits
/// from a third column; a header line is optional. A warning counts names without a frame. Throws Error
/// `FILE:LINE: …`.
void attachRooms(ListedSequence& sequence, const std::filesystem::path& file);

}  // namespace estancia::io
