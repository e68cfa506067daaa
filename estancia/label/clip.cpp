#include "estancia/label/clip.hpp"

#include <cmath>
#include <numeric>

#include "estancia/core/fail.hpp"
#include "estancia/io/npy.hpp"

namespace estancia {
namespace {

template <class Values>
double lengthOf(const Values& values) {
  double squares = 0;
  for (const double v : values) squares += v * v;
  return std::sqrt(squares);
}

}  // namespace

TextEmbeddings::TextEmbeddings(const std::filesystem::path& path, std::size_t labels) {
  io::NpyFile file(path);
  if (file.rows() != labels)
    fail(ErrorCode::mismatch,
         "{} has {} rows for {} labels; make it of the words of the label file, in its order", path.string(),
         file.rows(), labels);
  dimensions_ = file.columns();
  for (std::size_t i = 0; i < labels; ++i) {
    const auto& row = file.next();
    const double length = lengthOf(row);
    if (!std::isfinite(length) || length <= 0)
      fail(ErrorCode::malformedFile, "{}: row {} has the length {}; it is no embedding", path.string(), i,
           length);
    for (const double v : row) rows_.push_back(static_cast<float>(v / length));
  }
}

std::vector<float> TextEmbeddings::logits(std::span<const float> image, double scale,
                                          const std::string& model) const {
  if (image.size() != dimensions_)
    fail(ErrorCode::mismatch,
         "model {} gives {} values where its text embeddings have {}; they must be made by "
         "the text encoder that belongs to it",
         model, image.size(), dimensions_);
  const double length = lengthOf(image);
  if (!std::isfinite(length) || length <= 0)
    fail(ErrorCode::labelerFailure, "model {} gives an embedding of the length {}", model, length);
  std::vector<float> logits;
  for (auto row = rows_.begin(); row != rows_.end(); row += static_cast<std::ptrdiff_t>(dimensions_))
    logits.push_back(
        static_cast<float>(scale * std::inner_product(image.begin(), image.end(), row, 0.0) / length));
  return logits;
}

}  // namespace estancia
