// Recorded labeler: labels known already, from a recording or from people, found by the name of the frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "estancia/core/vocabulary.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model_spec.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia {

/// Gives every frame the words that a recording has for it, without a look at the image.
///
/// A frame finds its record by its whole name, else by the last part of its path, else by that without its
/// extension ("rgb/0017.png" finds "0017.jpg"), unless several records would do. FrameError when none does.
class RecordedLabeler : public Labeler {
 public:
  explicit RecordedLabeler(DescriptorSequence recording);

  const Vocabulary& vocabulary() const override { return recording_.vocabulary; }
  std::string identity() const override { return recording_.model; }
  bool needsImage() const override { return false; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override;
  LexicalDescriptor infer(const Prepared& prepared) override;

 private:
  std::size_t find(const std::string& frame) const;

  DescriptorSequence recording_;
  std::unordered_map<std::string, std::size_t> byName_, byLastPart_, byStem_;
};

/// Type "recorded": `file` is the recording, `labels` and `frames` what may lie beside it
/// (DescriptorFileOptions). Throws Error as readDescriptors() does.
std::unique_ptr<Labeler> openRecorded(const ModelSpec& spec);

/// Reads `image,label` or `image,label;label2;…` (the labels of an image share its probability), or
/// `image,label,confidence`, with or without such a header; an image may have several lines. The vocabulary
/// is `given`, or the labels in the file, sorted. What people leave unsaid is not impossible, and a hard zero
/// outweighs everything else in the distances of log-ratios; so a descriptor is
///     certainty · (labels of the person) + (1 − certainty) / L,
/// the label smoothing of Szegedy et al. 2016 (section 7) with ε = 1 − certainty, in [0, 1]. Throws Error
/// `FILE:LINE: …`, also on labels that are not in `given`.
DescriptorSequence readHumanLabels(const std::filesystem::path& file,
                                   const std::optional<Vocabulary>& given = {}, double certainty = 0.95);

/// Type "human": `file`, `labels`, `certainty`. Throws Error as readHumanLabels() does.
std::unique_ptr<Labeler> openHuman(const ModelSpec& spec);

}  // namespace estancia
