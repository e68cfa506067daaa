// Numbers of several kinds → coordinates that are worth comparing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/describe/features.hpp"

namespace estancia {

/// What the probabilities of words add up to; numbered as in files.
enum class WordSums : std::uint8_t {
  whole,        ///< 1: shares of one whole, as of a softmax
  independent,  ///< to more than 1 in some images, as a detector's
  selection     ///< to less than 1: some words of a whole
};

/// What was learned of one part. A number v of the descriptor becomes (e(v) − mean) · scale, with e after the
/// part's kind: probabilities of words → centered log-ratio (stats/distance.hpp), of a selection centered
/// over its words and the rest that they leave of 1; log-odds where they are independent; histogram and
/// energies → square root.
struct PartEmbedding {
  DescriptorPart part;
  WordSums sums = WordSums::whole;  ///< of probabilities
  std::vector<float> mean, scale;   ///< one a column; scale is 0 where training saw one value only
};

/// Puts parts side by side, balanced: however many columns a part has, its share of the squared distances is
/// 1 for words and 0.2 for others, which tell less of rooms. Words are centered; the columns of other parts
/// have variance 1, too. The mean squared norm of all is 1 on the training data, where parts that are the
/// same in all images have no share. Recipe measured on NYU's rooms.
class FeatureEmbedding {
 public:
  /// Learns from training data. Throws Error naming frame and column when a value is not finite, or is
  /// negative or above 1 in a part that cannot be, and when all images have the same numbers.
  static FeatureEmbedding learn(const Features& features);

  const std::vector<PartEmbedding>& parts() const { return parts_; }
  std::size_t columns() const;
  /// False where all training images had the same numbers, so that nothing can be told from them.
  bool tells() const;

  /// N × columns(). Parts are found by name and may stand in any order; of a source that has discovered more
  /// words since, the new ones are ignored, and words that it did not know yet are 0. Throws Error saying
  /// what differs and what to do when a part is missing or another.
  DescriptorMatrix apply(const Features& features) const;

  void write(ByteWriter& out) const;
  static FeatureEmbedding read(ByteReader& in);

 private:
  std::vector<PartEmbedding> parts_;
};

}  // namespace estancia
