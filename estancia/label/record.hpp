// A whole sequence labeled into memory.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "estancia/core/progress.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/label/label_stream.hpp"

namespace estancia {

/// Labels every frame. Where the labeler discovers words, all descriptors get the words found by the end.
/// Frames without words are left out. `watch` sees each frame as it comes (for progress; throw to stop).
/// Throws Error when no frame at all has words, and what the stream throws.
DescriptorSequence record(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options = {},
                          const std::function<void(const LabeledFrame&)>& watch = {});

/// The same with a bar, called `what` for people. Throws Interrupted when the user asks to stop.
DescriptorSequence labelAll(const Sequence& sequence, Labeler& labeler, const std::string& what,
                            LabelCache* cache, Progress& progress,
                            const std::function<void(const LabeledFrame&)>& watch = {});

}  // namespace estancia
