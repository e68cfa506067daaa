// Feature embedding: transforms and scales descriptors of several kinds so that they can be compared.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/describe/features.hpp"

namespace estancia {

/// The sum of the probabilities of labels; numbered as in files.
enum class LabelSums : std::uint8_t {
  /// 1: a distribution, as of a softmax.
  whole,
  /// More than 1 in some images: a detector.
  independent,
  /// Less than 1: some labels of a distribution.
  selection
};

/// The learned embedding of one part. A number v of the descriptor becomes (e(v) − mean) · scale, with e
/// after the part's kind: labels → centered log-ratio (distances/distance.hpp), of a selection centered over
/// its labels and the rest to 1; log-odds where they are independent; histogram and energies → square root.
struct PartEmbedding {
  DescriptorPart part;
  /// How probabilities are summed over the labels.
  LabelSums sums = LabelSums::whole;
  /// One a column; scale is 0 where all training values are equal.
  std::vector<float> mean, scale;
};

/// Puts parts side by side, balanced: whatever its number of columns, a part contributes 1 to the squared
/// distances if it has labels and 0.2 otherwise, as it carries less information about rooms. Labels are
/// centered; the columns of other parts also have variance 1. The mean squared norm is 1 on the training
/// data; constant parts contribute nothing. Measured on NYU's rooms.
class FeatureEmbedding {
 public:
  /// Learns from training data. Throws Error (invalidInput) with frame and column when a value is not finite,
  /// or outside the range of its kind; (insufficientData) without images.
  static FeatureEmbedding learn(const Features& features);

  const std::vector<PartEmbedding>& parts() const { return parts_; }
  std::size_t columns() const;
  /// False when all training images had the same numbers, so that classes cannot be distinguished.
  bool isInformative() const;

  /// N × columns(). Parts are found by name, in any order; labels discovered since training are ignored, and
  /// labels not yet discovered are 0. Throws Error (mismatch) when a part is missing or another.
  DescriptorMatrix apply(const Features& features) const;

  void write(ByteWriter& out) const;
  static FeatureEmbedding read(ByteReader& in);

 private:
  std::vector<PartEmbedding> parts_;
};

}  // namespace estancia
