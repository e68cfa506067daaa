// SPDX-License-Identifier: Apache-2.0
#include "estancia/label/network_labeler.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/label/model_files.hpp"
#include "estancia/label/scores.hpp"

namespace estancia {

NetworkLabeler::NetworkLabeler(const ModelSpec& spec, std::string engine)
    : spec_(spec),
      vocabulary_(readVocabulary(modelFile(spec, spec.labels))),
      identity_(fmt::format("{} {}", spec.name, modelDigest(spec))),
      engine_(std::move(engine)) {
  if (spec.embeddings.empty()) return;
  if (spec.sigmoid || spec.reduce != ModelSpec::Reduce::none || !spec.unused.empty())
    fail(ErrorCode::invalidInput,
         "model {}: `sigmoid`, `reduce` and `unused` do not go with `embeddings`, whose cosines become "
         "probabilities by softmax; leave them out of model.toml",
         spec.name);
  texts_.emplace(modelFile(spec, spec.embeddings), vocabulary_.size());
  spec_.softmax = true;
}

Prepared NetworkLabeler::prepare(const cv::Mat& bgr, const std::string& frame) const {
  return {preprocess(bgr, spec_.preprocessing), frame, {}};
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
