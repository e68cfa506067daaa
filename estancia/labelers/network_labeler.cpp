// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/network_labeler.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estancia/core/fail.hpp"
#include "estancia/files/npy.hpp"
#include "estancia/labelers/model_files.hpp"

namespace estancia {
namespace {

constexpr double smallestScale = 0.2, largestScale = 0.95;  // scales of the first and the last grid
constexpr double ofFirstGrid = 0.1;                         // scale of its square box
constexpr double wellOverlapped = 0.4, nearlyBest = 0.8;

struct BoxShape {
  double scale, aspect;
};

std::vector<BoxShape> shapesOf(std::size_t grid, std::size_t grids) {
  const auto scale = [grids](std::size_t k) {
    if (k >= grids) return 1.0;
    return grids < 2 ? smallestScale
                     : smallestScale + (largestScale - smallestScale) * static_cast<double>(k) /
                                           static_cast<double>(grids - 1);
  };
  const double here = scale(grid);
  if (grid == 0) return {{ofFirstGrid, 1}, {here, 2}, {here, 0.5}};
  return {{here, 1}, {here, 2},       {here, 0.5},
          {here, 3}, {here, 1.0 / 3}, {std::sqrt(here * scale(grid + 1)), 1}};
}

double overlapOf(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double both = (a & b).area(), all = a.area() + b.area() - both;
  return all > 0 ? both / all : 0;
}

/// Default boxes of the Single Shot MultiBox Detector (Liu et al., ECCV 2016, section 2.2), with the sizes of
/// TensorFlow's detectors: of each grid of n × n cells, row by row, three boxes of the first grid and six of
/// the others, in [0, 1] of the image's width and height, which they may leave.
std::vector<cv::Rect2d> defaultBoxes(std::span<const int> grids) {
  std::vector<cv::Rect2d> boxes;
  for (std::size_t k = 0; k < grids.size(); ++k) {
    const std::vector<BoxShape> shapes = shapesOf(k, grids.size());
    for (int row = 0; row < grids[k]; ++row)
      for (int column = 0; column < grids[k]; ++column)
        for (const BoxShape& shape : shapes) {
          const double width = shape.scale * std::sqrt(shape.aspect),
                       height = shape.scale / std::sqrt(shape.aspect);
          boxes.emplace_back((column + 0.5) / grids[k] - width / 2, (row + 0.5) / grids[k] - height / 2,
                             width, height);
        }
  }
  return boxes;
}

/// The boxes that overlap a region well (IoU of 0.4 or more), or else nearly as well as the best one does.
std::vector<std::size_t> boxesOf(const cv::Rect2d& region, std::span<const cv::Rect2d> boxes) {
  double best = 0;
  for (const cv::Rect2d& box : boxes) best = std::max(best, overlapOf(region, box));
  std::vector<std::size_t> found;
  const double enough = std::min(wellOverlapped, nearlyBest * best);
  for (std::size_t i = 0; i < boxes.size() && best > 0; ++i)
    if (overlapOf(region, boxes[i]) >= enough) found.push_back(i);
  return found;
}

Vocabulary vocabularyOf(const ModelSpec& spec) {
  if (spec.features == 0) return readVocabulary(modelFile(spec, spec.labels));
  if (!spec.labels.empty() || !spec.embeddings.empty() || spec.softmax || spec.sigmoid ||
      spec.reduce != ModelSpec::Reduce::none || !spec.unused.empty())
    fail(ErrorCode::invalidInput,
         "model {}: `labels`, `softmax`, `sigmoid`, `reduce`, `unused` and `embeddings` do not go with "
         "`features`, which are amounts without names; leave them out of model.toml",
         spec.name);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < spec.features; ++i) names.push_back(fmt::format("{} {}", spec.name, i));
  return Vocabulary(std::move(names));
}

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

NetworkLabeler::NetworkLabeler(const ModelSpec& spec, std::string engine)
    : spec_(spec),
      vocabulary_(vocabularyOf(spec)),
      // The name does not depend on the engine: other parts know the model's labels by it.
      identity_(fmt::format("{} {}{}{}", spec.name, isInt8(spec) ? "int8-" : "",
                            spec.reducedImages ? "reduced-" : "", modelDigest(spec))),
      engine_(std::move(engine)),
      boxes_(defaultBoxes(spec.anchors)) {
  const Preprocessing& how = spec.preprocessing;
  if (!boxes_.empty() && (spec.reduce == ModelSpec::Reduce::none || spec.softmax || how.crop < 1 ||
                          how.region != Preprocessing::Region::stretch))
    fail(ErrorCode::invalidInput,
         "model {}: `anchors` need `reduce = \"max\"`, `sigmoid`, `region = \"stretch\"` and `crop = 1.0`: "
         "its boxes are parts of the whole image; correct model.toml",
         spec.name);
  if (spec.embeddings.empty()) return;
  if (spec.sigmoid || spec.reduce != ModelSpec::Reduce::none || !spec.unused.empty())
    fail(ErrorCode::invalidInput,
         "model {}: `sigmoid`, `reduce` and `unused` do not go with `embeddings`, whose cosines become "
         "probabilities by softmax; leave them out of model.toml",
         spec.name);
  texts_.emplace(modelFile(spec, spec.embeddings), vocabulary_.size());
  spec_.softmax = true;
}

int NetworkLabeler::imageSide() const {
  const Preprocessing& how = spec_.preprocessing;
  return spec_.reducedImages ? static_cast<int>(std::lround(std::max(how.width, how.height) / how.crop)) : 0;
}

Prepared NetworkLabeler::prepare(const cv::Mat& bgr, const std::string& frame) const {
  return {preprocess(bgr, spec_.preprocessing), frame, {}};
}

std::vector<std::size_t> NetworkLabeler::regionLabels() const {
  std::vector<std::size_t> all(boxes_.empty() ? 0 : vocabulary_.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

std::vector<LexicalDescriptor> NetworkLabeler::toWordsOfRegions(std::span<const float> output,
                                                                std::span<const cv::Rect2d> regions) const {
  if (boxes_.empty())
    fail(ErrorCode::invalidInput,
         "model {} says nothing of regions of an image; only detectors whose model.toml has `anchors` do",
         spec_.name);
  const std::size_t columns = vocabulary_.size() + spec_.unused.size();
  if (output.size() != boxes_.size() * columns)
    fail(ErrorCode::mismatch,
         "model {} gave {} values for {} default boxes of {} outputs; correct `anchors` in model.toml",
         spec_.name, output.size(), boxes_.size(), columns);
  std::vector<LexicalDescriptor> found;
  std::vector<float> rows;
  for (const cv::Rect2d& region : regions) {
    rows.clear();
    for (const std::size_t box : boxesOf(region, boxes_)) {
      const auto row = output.begin() + static_cast<std::ptrdiff_t>(box * columns);
      rows.insert(rows.end(), row, row + static_cast<std::ptrdiff_t>(columns));
    }
    found.push_back(rows.empty() ? LexicalDescriptor(vocabulary_.size(), 0.0F)
                                 : toProbabilities(rows, spec_, vocabulary_.size()));
  }
  return found;
}

std::string NetworkLabeler::chooseOutput(const std::vector<std::string>& outputs) const {
  if (spec_.output.empty() && outputs.size() == 1) return outputs[0];
  if (std::find(outputs.begin(), outputs.end(), spec_.output) != outputs.end()) return spec_.output;
  fail(ErrorCode::mismatch, "model {} has the outputs {}; name one of them as `output` in model.toml",
       spec_.name, fmt::join(outputs, ", "));
}

void NetworkLabeler::tryOut() {
  const auto& pre = spec_.preprocessing;
  label(cv::Mat(pre.height, pre.width, CV_8UC3, cv::Scalar::all(128)));
}

LexicalDescriptor NetworkLabeler::toWords(std::span<const float> output) const {
  if (!texts_) return toProbabilities(output, spec_, vocabulary_.size());
  return toProbabilities(texts_->logits(output, spec_.logitScale, spec_.name), spec_, vocabulary_.size());
}

void NetworkLabeler::failOnInput(const std::string& reason) const {
  fail(ErrorCode::mismatch, "model {} does not work on an input of {}×{}: {}; correct `input` in model.toml",
       spec_.name, spec_.preprocessing.width, spec_.preprocessing.height, reason);
}

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
         "model {} gives {} values where its text embeddings have {}; they must be made by the text encoder "
         "that belongs to it",
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
