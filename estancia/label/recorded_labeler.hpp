// Recorded labeler: labels known already, from a recording, found by the name of the frame.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <unordered_map>

#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/label/labeler.hpp"
#include "estancia/label/model_spec.hpp"

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

}  // namespace estancia
