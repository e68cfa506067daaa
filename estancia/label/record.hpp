// Recording: all frames of a sequence labeled into memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "estancia/core/progress.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia {

/// Labels every frame; frames without labels are left out. Where the labeler discovers its vocabulary, all
/// descriptors have the labels known at the end. `watch` sees each frame as it comes (for progress; throw to
/// stop). Throws Error when no frame at all has labels, and what the stream throws.
DescriptorSequence record(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options = {},
                          const std::function<void(const LabeledFrame&)>& watch = {});

/// record() with progress, shown as `what`. Throws Interrupted when the user asks to stop.
DescriptorSequence labelAll(const Sequence& sequence, Labeler& labeler, const std::string& what,
                            const LabelStreamOptions& options = {}, Progress& progress = Progress::none(),
                            const std::function<void(const LabeledFrame&)>& watch = {});

}  // namespace estancia
