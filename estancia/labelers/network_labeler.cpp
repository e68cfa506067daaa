// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/network_labeler.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/labelers/default_boxes.hpp"
#include "estancia/labelers/model_files.hpp"
#include "estancia/labelers/scores.hpp"

namespace estancia {
namespace {

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
         "its "
         "boxes are parts of the whole image; correct model.toml",
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

}  // namespace estancia
