// CLIP text embeddings: an image embedding compared with those of any words (zero-shot classification).
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace estancia {

/// Where words stand in the space that an image encoder shares with a text encoder. Radford et al., Learning
/// transferable visual models from natural language supervision (CLIP), ICML 2021.
class TextEmbeddings {
 public:
  /// Reads a .npy file, `labels`×D, row i for label i, and brings the rows to length 1. Throws Error when it
  /// is damaged, has another number of rows, or a row that is not finite or nothing but 0.
  TextEmbeddings(const std::filesystem::path& file, std::size_t labels);

  /// `scale` times the cosine of the angle between the image and each text: one logit a label. Throws Error
  /// naming `model` unless the image has D values, finite and not all 0.
  std::vector<float> logits(std::span<const float> image, double scale, const std::string& model) const;

 private:
  std::size_t dimensions_ = 0;
  std::vector<float> rows_;
};

}  // namespace estancia
