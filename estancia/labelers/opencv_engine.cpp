// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/engines.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <regex>

#include "estancia/core/cores.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/labelers/model_files.hpp"
#include "estancia/labelers/network_labeler.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// OpenCV and its protobuf print to stderr before they throw; our Error is more specific. We do not link
/// protobuf: its LogSilencer is looked for where OpenCV has loaded it.
class QuietOpencv {
 public:
  QuietOpencv() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {
    callProtobuf("_ZN6google8protobuf11LogSilencerC1Ev");
  }
  ~QuietOpencv() {
    callProtobuf("_ZN6google8protobuf11LogSilencerD1Ev");
    cv::utils::logging::setLogLevel(before_);
  }
  QuietOpencv(const QuietOpencv&) = delete;
  QuietOpencv& operator=(const QuietOpencv&) = delete;

 private:
  void callProtobuf(const char* member) {
    if (void* const function = dlsym(RTLD_DEFAULT, member)) reinterpret_cast<void (*)(void*)>(function)(this);
  }

  cv::utils::logging::LogLevel before_;
};

/// Message of an OpenCV importer's exception in one line; an unknown operator is given by name.
std::string reasonOf(const cv::Exception& e) {
  const std::string text = e.what();
  std::smatch match;
  if (std::regex_search(text, match, std::regex(R"(Node \[(\w+)@)")) ||      // ONNX
      std::regex_search(text, match, std::regex(R"~(of type "(\w+)")~")) ||  // Caffe, and layers without code
      std::regex_search(text, match, std::regex(R"(Unknown layer type (\w+))")))  // TensorFlow
    return fmt::format("OpenCV cannot run its operator {}", match[1].str());
  std::string line = e.err.empty() ? text : e.err;
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line.substr(0, 200);
}

cv::dnn::Net readNetwork(const ModelSpec& spec) {
  const fs::path path = modelFile(spec, spec.file);
  const std::string config = spec.config.empty() ? "" : modelFile(spec, spec.config).string();
  const std::string extension = spec.file.extension().string();
  requireKnownFormat(spec);
  const QuietOpencv quiet;
  try {
    if (isOnnx(spec)) {
      const std::string onnx = readOnnx(spec);
      return cv::dnn::readNetFromONNX(onnx.data(), onnx.size());
    }
    if (extension == ".pb") return cv::dnn::readNetFromTensorflow(path.string(), config);
    if (config.empty())
      fail(ErrorCode::invalidInput,
           "model {}: a .caffemodel needs its .prototxt; name it as `config` in model.toml", spec.name);
    return cv::dnn::readNetFromCaffe(config, path.string());
  } catch (const cv::Exception& e) {
    fail(ErrorCode::unsupportedFile, "cannot open the network {}: {}", path.string(), reasonOf(e));
  }
}

class OpencvEngine final : public NetworkLabeler {
 public:
  explicit OpencvEngine(const ModelSpec& spec)
      : NetworkLabeler(spec, opencvVersion()), network_(readNetwork(spec)) {
    network_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    output_ = chooseOutput(network_.getUnconnectedOutLayersNames());
    tryOut();
  }

  LexicalDescriptor infer(const Prepared& prepared) override {
    const cv::Mat result = forward(prepared);
    return toWords({result.ptr<float>(), result.total()});
  }

  std::vector<LexicalDescriptor> labelRegions(const cv::Mat& bgr,
                                              std::span<const cv::Rect2d> regions) override {
    const cv::Mat result = forward(prepare(bgr, ""));
    return toWordsOfRegions({result.ptr<float>(), result.total()}, regions);
  }

 private:
  cv::Mat forward(const Prepared& prepared) {
    cv::Mat result;
    try {
      const QuietOpencv quiet;
      network_.setInput(prepared.input);
      result = network_.forward(output_);
    } catch (const cv::Exception& e) {
      failOnInput(reasonOf(e));
    }
    if (result.type() != CV_32F || !result.isContinuous())
      fail(ErrorCode::unsupportedFile, "model {} gives no real numbers", spec().name);
    return result;
  }

  cv::dnn::Net network_;
  std::string output_;
};

}  // namespace

std::string opencvVersion() {
  return "opencv " CV_VERSION;
}

std::unique_ptr<Labeler> openWithOpencv(const ModelSpec& spec, int threads) {
  // The engine needs the shape of every output, which is not declared for a value inside of a network.
  if (spec.features > 0)
    fail(ErrorCode::unsupportedFile, "model {}: OpenCV gives no `features`; take the engine onnxruntime",
         spec.name);
  cv::setNumThreads(threads > 0 ? threads : freeCores());
  return std::make_unique<OpencvEngine>(spec);
}

}  // namespace estancia
