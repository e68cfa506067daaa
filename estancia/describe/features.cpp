// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/features.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <mutex>
#include <set>
#include <unordered_map>
#include <utility>

#include "estancia/core/cores.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/describe/lexical.hpp"
#include "estancia/label/label_stream.hpp"

namespace estancia {
namespace {

/// The numbers of one descriptor for the frames of a sequence.
struct Block {
  std::vector<DescriptorPart> parts;
  std::vector<std::vector<float>> rows;  // one a frame; empty without a descriptor
};

/// The first reason why each frame has no descriptor.
class Problems {
 public:
  explicit Problems(const Sequence& sequence) : sequence_(sequence), sentences_(sequence.size()) {}

  /// Safe to call from several threads for different frames.
  void add(std::size_t frame, const std::string& what) {
    std::string& sentence = sentences_[frame];
    if (sentence.empty()) sentence = fmt::format("{}: {}", sequence_.frame(frame).name, what);
  }
  std::vector<std::string> sentences() const {
    std::vector<std::string> all;
    std::ranges::copy_if(sentences_, std::back_inserter(all), [](auto& s) { return !s.empty(); });
    return all;
  }

 private:
  const Sequence& sequence_;
  std::vector<std::string> sentences_;
};

/// Labels go through the label stream, in batches and with the cache; null: the descriptor is computed.
LabelerDescriptor* labelerIn(const NamedDescriptor& source) {
  return dynamic_cast<LabelerDescriptor*>(source.descriptor.get());
}

Block labeled(const Sequence& sequence, const NamedDescriptor& source, LabelCache* cache, Progress& progress,
              Problems& problems) {
  std::vector<std::size_t> frames;
  const DescriptorSequence words = labelAll(
      sequence, labelerIn(source)->labeler(), fmt::format("{}: labeling {}", source.name, sequence.name()),
      {.cache = cache}, progress, [&](const LabeledFrame& frame) {
        if (frame.labeled())
          frames.push_back(frame.index);
        else
          problems.add(frame.index, fmt::format("{}: {}", source.name, frame.problem));
      });
  Block block{partsOfLabels(words.vocabulary, words.model), {}};
  block.rows.resize(sequence.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const DescriptorView row = words.descriptors.row(i);
    block.rows[frames[i]].assign(row.begin(), row.end());
  }
  return block;
}

View viewOf(const Sequence& sequence, std::size_t frame, bool image, bool depth) {
  View view;
  view.frame = sequence.frame(frame).name;
  if (image) view.image = sequence.image(frame);
  if (depth) {
    view.depth = sequence.depth(frame);
    view.camera = sequence.intrinsics()->scaledTo(view.depth.cols, view.depth.rows);
  }
  return view;
}

/// All descriptors without a model, so that every image is decoded once.
std::vector<Block> computed(const Sequence& sequence, const std::vector<const NamedDescriptor*>& sources,
                            int threads, Progress& progress, Problems& problems) {
  std::vector<Block> blocks;
  std::vector<std::string> names;
  bool image = false, depth = false;
  for (const NamedDescriptor* source : sources) {
    blocks.push_back({source->descriptor->parts(), {}});
    blocks.back().rows.resize(sequence.size());
    names.push_back(source->name);
    image = image || source->descriptor->needsImage();
    depth = depth || source->descriptor->needsDepth();
    if (!source->descriptor->needsDepth()) continue;
    if (!sequence.hasDepth())
      fail(ErrorCode::invalidInput, "{} has no depth, which {} needs; choose other descriptors",
           sequence.name(), source->name);
    if (!sequence.intrinsics())
      fail(ErrorCode::invalidInput, "{} has no depth camera, which {} needs; give its intrinsics",
           sequence.name(), source->name);
  }
  std::mutex mutex;
  progress.begin(fmt::format("{}: describing {}", fmt::join(names, "+"), sequence.name()), sequence.size());
  inParallel(sequence.size(), static_cast<std::size_t>(threads > 0 ? threads : freeCores()),
             [&](std::size_t frame) {
               if (interrupted()) throw Interrupted("stopped while describing; nothing was written");
               try {
                 const View view = viewOf(sequence, frame, image, depth);
                 for (std::size_t i = 0; i < sources.size(); ++i)
                   blocks[i].rows[frame] = sources[i]->descriptor->describe(view);
               } catch (...) {
                 problems.add(frame, frameFailure(sequence.frame(frame).name).what());
               }
               const std::lock_guard lock(mutex);
               progress.advance();
             });
  progress.end();
  return blocks;
}

}  // namespace

std::string Features::name() const {
  std::string all;
  for (const DescriptorPart& part : parts) all += (all.empty() ? "" : "+") + part.name;
  return all;
}

Features describeSequence(const Sequence& sequence, const std::string& descriptors,
                          const DescribeOptions& options, Progress& progress,
                          std::vector<std::string>* problems) {
  LabelerOptions labeling = options.labeler;
  labeling.onDemand = labeling.onDemand || options.cache != nullptr;
  const std::vector<NamedDescriptor> sources = loadDescriptors(descriptors, labeling);
  Problems skipped(sequence);
  std::vector<const NamedDescriptor*> direct;
  for (const NamedDescriptor& source : sources)
    if (!labelerIn(source)) direct.push_back(&source);
  // Before labeling: it is fast, and refuses impossible tasks early.
  std::vector<Block> computedBlocks =
      direct.empty() ? std::vector<Block>{}
                     : computed(sequence, direct, options.labeler.threads, progress, skipped);
  std::vector<Block> blocks;
  auto next = computedBlocks.begin();
  for (const NamedDescriptor& source : sources)
    blocks.push_back(labelerIn(source) ? labeled(sequence, source, options.cache, progress, skipped)
                                       : std::move(*next++));

  Features features{{}, {}, DescriptorMatrix(0)};
  std::set<std::string> names;
  std::size_t size = 0;
  for (Block& block : blocks)
    for (DescriptorPart& part : block.parts) {
      if (!names.insert(part.name).second)
        fail(ErrorCode::invalidOption, "two descriptors of \"{}\" are called {}; give one", descriptors,
             part.name);
      size += part.size();
      features.parts.push_back(std::move(part));
    }
  features.values = DescriptorMatrix(size);
  std::vector<float> row;
  for (std::size_t frame = 0; frame < sequence.size(); ++frame) {
    if (std::ranges::any_of(blocks, [&](const Block& b) { return b.rows[frame].empty(); })) continue;
    row.clear();
    for (Block& block : blocks) {
      row.insert(row.end(), block.rows[frame].begin(), block.rows[frame].end());
      std::vector<float>().swap(block.rows[frame]);
    }
    features.values.append(row);
    features.frames.push_back(sequence.frame(frame));
  }
  const std::vector<std::string> sentences = skipped.sentences();
  if (problems != nullptr) problems->insert(problems->end(), sentences.begin(), sentences.end());
  if (features.frames.empty())
    fail(ErrorCode::insufficientData, "{}: none of its frames can be described{}", sequence.name(),
         sentences.empty() ? "" : "; " + sentences.front());
  return features;
}

Features featuresOf(const Descriptor& descriptor, const View& view) {
  const std::vector<float> numbers = descriptor.describe(view);
  Features features{descriptor.parts(), {}, DescriptorMatrix(numbers.size())};
  features.frames.emplace_back().name = view.frame;
  features.values.append(numbers);
  return features;
}

Features featuresOf(const DescriptorSequence& recording) {
  return {partsOfLabels(recording.vocabulary, recording.model), recording.frames, recording.descriptors};
}

Features withParts(const Features& features, const std::vector<std::string>& names) {
  std::vector<std::size_t> begins(1, 0);
  std::vector<std::string> known;
  for (const DescriptorPart& part : features.parts) {
    begins.push_back(begins.back() + part.size());
    known.push_back(part.name);
  }
  Features result{{}, features.frames, DescriptorMatrix(0)};
  std::vector<std::size_t> chosen;
  std::size_t size = 0;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(known, name);
    if (found == known.end())
      fail(ErrorCode::unknownName, "unknown part \"{}\"; known: {}", name, fmt::join(known, ", "));
    chosen.push_back(static_cast<std::size_t>(found - known.begin()));
    result.parts.push_back(features.parts[chosen.back()]);
    size += result.parts.back().size();
  }
  result.values = DescriptorMatrix(size);
  result.values.reserve(features.frames.size());
  std::vector<float> row;
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    row.clear();
    const DescriptorView all = features.values.row(i);
    for (const std::size_t c : chosen) {
      const DescriptorView part = all.subspan(begins[c], features.parts[c].size());
      row.insert(row.end(), part.begin(), part.end());
    }
    result.values.append(row);
  }
  return result;
}

Features withRows(const Features& features, const std::vector<std::size_t>& rows) {
  Features result{features.parts, {}, DescriptorMatrix(features.values.labels())};
  result.values.reserve(rows.size());
  for (const std::size_t i : rows) {
    if (i >= features.frames.size())
      fail(ErrorCode::invalidInput, "row {} does not exist; there are {}", i, features.frames.size());
    result.frames.push_back(features.frames[i]);
    result.values.append(features.values.row(i));
  }
  return result;
}

Features withRooms(const Features& features, const std::vector<std::string>& rooms) {
  if (rooms.empty()) return features;
  Choices known;
  for (const auto& [room, count] : framesPerRoom(features)) known.push_back({room, ""});
  for (const std::string& room : rooms) requireChoice("room", room, known);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < features.frames.size(); ++i)
    if (std::ranges::find(rooms, features.frames[i].room) != rooms.end()) rows.push_back(i);
  return withRows(features, rows);
}

Features withFramesOf(const Features& features, const Sequence& sequence) {
  std::unordered_map<std::string, std::size_t> rowOf;
  for (std::size_t i = 0; i < features.frames.size(); ++i) rowOf.emplace(features.frames[i].name, i);
  std::vector<std::size_t> rows;
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (const auto row = rowOf.find(sequence.frame(i).name); row != rowOf.end()) {
      rows.push_back(row->second);
      frames.push_back(sequence.frame(i));
    }
  Features listed = withRows(features, rows);
  listed.frames = std::move(frames);
  return listed;
}

std::map<std::string, std::size_t> framesPerRoom(const Features& features) {
  std::map<std::string, std::size_t> frames;
  for (const Frame& frame : features.frames)
    if (!frame.room.empty()) ++frames[frame.room];
  return frames;
}

}  // namespace estancia
