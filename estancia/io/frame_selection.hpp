// A part of a sequence: one split of a data set, or some of its rooms.
#pragma once

#include <memory>

#include "estancia/io/formats.hpp"

namespace estancia::io {

/// The frames that options.split and options.only ask for, in their order; all of them where nothing is
/// asked. Throws Error, listing the known ones, when a split or a room is not there, and when no frame is in
/// both.
std::unique_ptr<Sequence> selectFrames(Opened sequence, const SequenceOptions& options);

}  // namespace estancia::io
