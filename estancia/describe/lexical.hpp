// Labeler descriptor: the labels of an image as an image descriptor (thesis Eq. 4.1).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/describe/descriptor.hpp"
#include "estancia/labelers/labeler.hpp"

namespace estancia {

/// A labeler as a descriptor. Views are labeled one at a time.
class LabelerDescriptor final : public Descriptor {
 public:
  explicit LabelerDescriptor(std::unique_ptr<Labeler> labeler) : labeler_(std::move(labeler)) {}

  std::vector<DescriptorPart> parts() const override;
  bool needsImage() const override { return labeler_->needsImage(); }
  std::vector<float> describe(const View& view) const override;

  /// For label streams (label/label_stream.hpp); not safe during describe().
  Labeler& labeler() { return *labeler_; }

 private:
  std::unique_ptr<Labeler> labeler_;
  mutable std::mutex mutex_;
};

/// The parts of this vocabulary: one a model behind `identity`, a labeler's.
std::vector<DescriptorPart> partsOfLabels(const Vocabulary& vocabulary, const std::string& identity);

}  // namespace estancia
