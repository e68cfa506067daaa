#include "estancia/label/network_labeler.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/label/model_files.hpp"
#include "estancia/label/preprocess.hpp"

namespace estancia {

NetworkLabeler::NetworkLabeler(const ModelSpec& spec, std::string engine)
    : spec_(spec),
      vocabulary_(readVocabulary(modelFile(spec, spec.labels))),
      identity_(fmt::format("{} {}", spec.name, modelDigest(spec))),
      engine_(std::move(engine)),
      scores_(spec, vocabulary_.size()) {}

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
  return scores_(output);
}

void NetworkLabeler::failOnInput(const std::string& reason) const {
  fail(ErrorCode::mismatch, "model {} does not work on an input of {}×{}: {}; correct `input` in model.toml",
       spec_.name, spec_.preprocessing.width, spec_.preprocessing.height, reason);
}

}  // namespace estancia
