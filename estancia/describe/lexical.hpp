// A labeler's words as a descriptor (thesis Eq. 4.1).
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/describe/descriptor.hpp"
#include "estancia/label/labeler.hpp"

namespace estancia {

/// Any labeler behind the interface of all descriptors. Views are labeled one after the other, whoever asks.
class Words final : public Descriptor {
 public:
  explicit Words(std::unique_ptr<Labeler> labeler);

  std::vector<DescriptorPart> parts() const override;
  bool needsImage() const override { return labeler_->needsImage(); }
  std::vector<float> describe(const View& view) const override;

  /// For whoever labels many images at once (label/label_stream.hpp); not beside describe().
  Labeler& labeler() { return *labeler_; }

 private:
  std::unique_ptr<Labeler> labeler_;
  mutable std::mutex mutex_;
};

/// The parts of words over this vocabulary: one a model behind `identity`, a labeler's.
std::vector<DescriptorPart> partsOfWords(const Vocabulary& vocabulary, const std::string& identity);

}  // namespace estancia
