// Poses and rooms that lie beside the images.
#pragma once

#include <filesystem>

#include "estancia/io/formats.hpp"
#include "estancia/io/trajectory.hpp"

namespace estancia::io {

/// Gives every frame the pose nearest in time, at most `maxGap` [s] away; not interpolated, because a pose
/// that was measured is worth more here than one in between. Where frames or poses have no time stamps, or no
/// stamp fits at all (two clocks), equally long lists are matched by order. Throws Error naming `file` when
/// neither is possible.
void attachPoses(ListedSequence& sequence, const Trajectory& trajectory, const std::filesystem::path& file,
                 double maxGap);

/// Sets the rooms of the frames that the CSV `image,room` names (by frame name or its last component), and
/// their splits where it has a third column; a header line is optional. Names without a frame are counted in
/// a warning. Throws Error naming the line that is wrong.
void attachRooms(ListedSequence& sequence, const std::filesystem::path& file);

}  // namespace estancia::io
