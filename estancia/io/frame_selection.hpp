// Frame selection: one split of a data set, or some of its rooms.
#pragma once

#include <memory>

#include "estancia/io/formats.hpp"

namespace estancia::io {

/// The frames of options.split and options.only, in order; all frames when both are empty. Throws Error on an
/// unknown split or room (naming the known ones), and when no frame is in both.
std::unique_ptr<Sequence> selectFrames(Opened sequence, const SequenceOptions& options);

}  // namespace estancia::io
