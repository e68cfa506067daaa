// Vocabulary: an ordered list of labels, identified by a digest.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace estancia {

/// One answer of a labeler without a fixed vocabulary: a program, a service, a person.
struct LabelProbability {
  std::string label;
  /// In [0, 1].
  float probability = 0;
};

/// The labels of one model within a vocabulary of several: a distribution of its own.
struct LabelPart {
  std::size_t size = 0;
  /// > 0; weight of the part when descriptors are compared.
  float weight = 1;
  bool operator==(const LabelPart&) const = default;
};

/// How the values of a descriptor are laid out: one part after the other. A number of labels is one part.
struct DescriptorLayout {
  std::vector<LabelPart> parts;

  DescriptorLayout(std::size_t labels) : parts{{labels, 1}} {}
  DescriptorLayout(std::vector<LabelPart> several) : parts(std::move(several)) {}
  std::size_t labels() const;
};

/// An ordered list of labels L = {l_1 … l_L}. A label line may hold synonyms: "cup, mug". A label may
/// occur more than once (ImageNet has two cranes; several models may know the kitchen).
/// Invariant: at least one label, none empty; position i belongs to value i of every descriptor.
class Vocabulary {
 public:
  /// `parts` are those of several models, in order; none: one model. Throws Error (invalidInput) on an empty
  /// list, an empty label, or parts whose sizes do not add up to the list's.
  explicit Vocabulary(std::vector<std::string> labels, std::vector<LabelPart> parts = {});

  std::size_t size() const { return labels_.size(); }
  const std::string& operator[](std::size_t i) const { return labels_[i]; }
  const std::vector<std::string>& labels() const { return labels_; }
  const DescriptorLayout& layout() const { return layout_; }

  /// SHA-256 (64 hex digits) over the labels in order and, where there are several, the parts: two
  /// vocabularies are the same iff their digests are.
  const std::string& digest() const { return digest_; }

  bool operator==(const Vocabulary& other) const { return digest_ == other.digest_; }

 private:
  std::vector<std::string> labels_;
  DescriptorLayout layout_;
  std::string digest_;
};

/// Reads one label a line (UTF-8; CR, trailing blanks and empty last lines are dropped). Throws Error
/// (fileUnreadable, malformedFile) with file and line.
Vocabulary readVocabulary(const std::filesystem::path& path);

/// Throws Error (mismatch) with the sizes and the first different label unless the two are equal.
void requireSameVocabulary(const Vocabulary& expected, const Vocabulary& actual, const std::string& context);

}  // namespace estancia
