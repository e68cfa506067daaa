// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/scores.hpp"

#include <fmt/format.h>
#include <numeric>

#include <algorithm>
#include <cmath>

#include "estancia/core/fail.hpp"
#include "estancia/files/npy.hpp"

namespace estancia {
namespace {

template <class Values>
double lengthOf(const Values& values) {
  double squares = 0;
  for (const double v : values) squares += v * v;
  return std::sqrt(squares);
}

/// Numerically safe: the largest exponent is 0. NaN stays NaN.
void softmaxInPlace(LexicalDescriptor& values) {
  const float largest = *std::max_element(values.begin(), values.end());
  double sum = 0;
  for (float& v : values) {
    v = std::exp(v - largest);
    sum += v;
  }
  for (float& v : values) v = static_cast<float>(v / sum);
}

/// The highest value of each column. NaN stays NaN.
LexicalDescriptor highest(std::span<const float> output, const ModelSpec& spec, std::size_t columns) {
  LexicalDescriptor best, row;
  for (std::size_t start = 0; start < output.size(); start += columns) {
    row.assign(output.begin() + static_cast<std::ptrdiff_t>(start),
               output.begin() + static_cast<std::ptrdiff_t>(start + columns));
    if (spec.softmax) softmaxInPlace(row);
    if (best.empty()) best = row;
    for (std::size_t i = 0; i < columns; ++i)
      if (row[i] > best[i] || std::isnan(row[i])) best[i] = row[i];
  }
  return best;
}

/// Amounts as shares of their sum; where all are 0 they stay so.
void toShares(LexicalDescriptor& amounts, const std::string& model) {
  double sum = 0;
  for (const float amount : amounts) {
    if (amount < 0)
      fail(ErrorCode::mismatch,
           "model {} gave the value {} where `features` are 0 or more; name an `output` behind a ReLU", model,
           amount);
    sum += amount;
  }
  if (sum > 0)
    for (float& amount : amounts) amount = static_cast<float>(amount / sum);
}

}  // namespace

LexicalDescriptor toProbabilities(std::span<const float> output, const ModelSpec& spec, std::size_t labels) {
  const std::size_t columns = labels + spec.unused.size();
  const bool fits = spec.reduce == ModelSpec::Reduce::none ? output.size() == columns
                                                           : output.size() % columns == 0 && !output.empty();
  if (!fits) {
    const bool rows = output.size() > columns && output.size() % columns == 0;
    fail(ErrorCode::mismatch, "model {} gave {} values for {} labels{}; {}", spec.name, output.size(), labels,
         spec.unused.empty() ? "" : fmt::format(" and {} unused outputs", spec.unused.size()),
         rows ? "if these are rows of a detector, say `reduce = \"max\"` in model.toml"
              : "use the label file that belongs to the model");
  }
  LexicalDescriptor values = highest(output, spec, columns);
  if (spec.sigmoid)  // keeps the order, so that once is enough
    for (float& v : values) v = 1 / (1 + std::exp(-v));
  if (spec.features > 0) toShares(values, spec.name);
  for (auto i = spec.unused.rbegin(); i != spec.unused.rend(); ++i) {
    if (*i >= values.size())
      fail(ErrorCode::mismatch, "model {} has no output {}, which model.toml names as unused", spec.name, *i);
    values.erase(values.begin() + static_cast<std::ptrdiff_t>(*i));
  }
  requireProbabilities(values, labels, "model " + spec.name);
  return values;
}

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
