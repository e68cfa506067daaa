// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/features.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <unordered_map>
#include <utility>

#include "estancia/core/cores.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/describe/lexical.hpp"

namespace estancia {
namespace {

/// The numbers of one descriptor for the frames of a sequence.
struct Block {
  std::vector<DescriptorPart> parts;
  std::vector<std::vector<float>> rows;  // one a frame; empty without a descriptor
};

/// The first reason why each frame has no descriptor; "" for those that have one.
struct Problems {
  /// Safe to call from several threads for different frames.
  void add(std::size_t frame, const std::string& what) {
    if (sentences[frame].empty()) sentences[frame] = fmt::format("{}: {}", sequence.frame(frame).name, what);
  }

  const Sequence& sequence;
  std::vector<std::string> sentences = std::vector<std::string>(sequence.size());
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

/// Fills the blocks of all descriptors without a model at once, so that every image is decoded once.
void compute(const Sequence& sequence, const std::vector<NamedDescriptor>& sources, int threads,
             Progress& progress, Problems& problems, std::vector<Block>& blocks) {
  std::vector<std::size_t> direct;
  std::vector<std::string> names;
  bool image = false, depth = false;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (labelerIn(sources[i]) != nullptr) continue;
    const auto& [name, descriptor] = sources[i];
    blocks[i] = {descriptor->parts(), std::vector<std::vector<float>>(sequence.size())};
    direct.push_back(i);
    names.push_back(name);
    image = image || descriptor->needsImage();
    depth = depth || descriptor->needsDepth();
    if (!descriptor->needsDepth()) continue;
    if (!sequence.hasDepth())
      fail(ErrorCode::invalidInput, "{} has no depth, which {} needs; choose other descriptors",
           sequence.name(), name);
    if (!sequence.intrinsics())
      fail(ErrorCode::invalidInput, "{} has no depth camera, which {} needs; give its intrinsics",
           sequence.name(), name);
  }
  if (direct.empty()) return;
  progress.begin(fmt::format("{}: describing {}", fmt::join(names, "+"), sequence.name()), sequence.size());
  inParallel(sequence.size(), threads > 0 ? threads : freeCores(), progress,
             "stopped while describing; nothing was written", [&](std::size_t frame) {
               try {
                 const View view = viewOf(sequence, frame, image, depth);
                 for (const std::size_t i : direct)
                   blocks[i].rows[frame] = sources[i].descriptor->describe(view);
               } catch (...) {
                 problems.add(frame, frameFailure(sequence.frame(frame).name).what());
               }
             });
  progress.end();
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
  Problems skipped{sequence};
  std::vector<Block> blocks(sources.size());
  // Before labeling: it is fast, and refuses impossible tasks early.
  compute(sequence, sources, options.labeler.threads, progress, skipped, blocks);
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (labelerIn(sources[i]) != nullptr)
      blocks[i] = labeled(sequence, sources[i], options.cache, progress, skipped);

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
  std::vector<std::string>& sentences = skipped.sentences;
  std::erase(sentences, "");
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
  Features result{{}, features.frames, DescriptorMatrix(0)};
  std::vector<std::size_t> columns;
  for (const std::string& name : names) {
    std::size_t first = 0;
    auto part = features.parts.begin();
    for (; part != features.parts.end() && part->name != name; ++part) first += part->size();
    if (part == features.parts.end()) {
      std::vector<std::string> known;
      for (const DescriptorPart& each : features.parts) known.push_back(each.name);
      fail(ErrorCode::unknownName, "unknown part \"{}\"; known: {}", name, fmt::join(known, ", "));
    }
    result.parts.push_back(*part);
    for (std::size_t c = 0; c < part->size(); ++c) columns.push_back(first + c);
  }
  result.values = DescriptorMatrix(columns.size());
  result.values.reserve(features.frames.size());
  std::vector<float> row(columns.size());
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    std::ranges::transform(columns, row.begin(), [&](std::size_t c) { return features.values.row(i)[c]; });
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
