// SPDX-License-Identifier: Apache-2.0
#include "places/posed_descriptors.hpp"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/label/label_stream.hpp"

namespace estancia::experiments {
namespace {

template <class T>
std::string digestOf(const std::vector<T>& values) {
  return sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

}  // namespace

std::string PosedDescriptors::digest() const {
  std::string layout;
  for (const LabelPart& part : parts) layout += fmt::format("{} {}\n", part.size, part.weight);
  return sha256(digestOf(frames) + digestOf(positions) + digestOf(descriptors.values()) + layout);
}

void PosedDescriptors::widen(const Vocabulary& vocabulary) {
  if (vocabulary.size() == descriptors.labels()) return;
  parts = vocabulary.layout().parts;
  DescriptorMatrix wider(vocabulary.size());
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    LexicalDescriptor row(descriptors.row(i).begin(), descriptors.row(i).end());
    row.resize(vocabulary.size(), 0.0F);
    wider.append(row);
  }
  descriptors = std::move(wider);
}

PosedDescriptors labelPosed(const Sequence& sequence, Labeler& labeler, LabelCache* cache, Progress& progress,
                            const std::string& what) {
  std::vector<std::size_t> labeled;
  const DescriptorSequence recording =
      labelAll(sequence, labeler, what, {.cache = cache}, progress, [&labeled](const LabeledFrame& frame) {
        if (frame.labeled()) labeled.push_back(frame.index);
      });
  PosedDescriptors result(recording.vocabulary);
  result.unreadable = sequence.size() - labeled.size();
  for (std::size_t i = 0; i < labeled.size(); ++i) {
    const auto& pose = recording.frames[i].pose;
    if (!pose) continue;
    result.frames.push_back(labeled[i]);
    result.positions.push_back({pose->x, pose->y, pose->z});
    result.descriptors.append(recording.descriptors.row(i));
  }
  if (result.frames.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: none of the frames with a pose can be read", sequence.name()));
  return result;
}

}  // namespace estancia::experiments
