// SPDX-License-Identifier: Apache-2.0
#include "estancia/label/label_stream.hpp"

#include <utility>
#include <vector>

#include "estancia/core/fail.hpp"

namespace estancia {

DescriptorSequence record(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options,
                          const std::function<void(const LabeledFrame&)>& watch) {
  std::vector<Frame> frames;
  std::vector<LexicalDescriptor> words;
  std::string problem;  // the first
  LabelStream stream(sequence, labeler, options);
  while (auto frame = stream.next()) {
    if (watch) watch(*frame);
    if (problem.empty()) problem = frame->problem;
    if (!frame->labeled()) continue;
    frames.push_back(sequence.frame(frame->index));
    words.push_back(std::move(frame->descriptor));
  }
  if (frames.empty())
    fail(ErrorCode::labelerFailure, "{}: not one of its frames could be labeled{}", sequence.name(),
         problem.empty() ? "" : "; " + problem);
  DescriptorSequence recording{labeler.vocabulary(), labeler.identity(), std::move(frames),
                               DescriptorMatrix(labeler.vocabulary().size())};
  recording.descriptors.reserve(words.size());
  for (LexicalDescriptor& row : words) {
    row.resize(recording.vocabulary.size());  // words that were found later
    recording.descriptors.append(row);
    LexicalDescriptor().swap(row);
  }
  return recording;
}

DescriptorSequence labelAll(const Sequence& sequence, Labeler& labeler, const std::string& what,
                            const LabelStreamOptions& options, Progress& progress,
                            const std::function<void(const LabeledFrame&)>& watch) {
  progress.begin(what, sequence.size());
  DescriptorSequence recording = record(sequence, labeler, options, [&](const LabeledFrame& frame) {
    if (watch) watch(frame);
    progress.advance();
    if (interrupted())
      throw Interrupted(options.cache != nullptr
                            ? "stopped; what is labeled is kept, the same command goes on from there"
                            : "stopped; without the cache nothing is kept, the same command begins anew");
  });
  progress.end();
  return recording;
}

}  // namespace estancia
