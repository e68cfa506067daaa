#include "estancia/label/opencv_engine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <google/protobuf/stubs/logging.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <regex>
#include <set>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/label/tflite_reader.hpp"
#include "estancia/label/tflite_to_onnx.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// OpenCV and protobuf write complaints to stderr before they throw; ours say more.
class QuietOpencv {
 public:
  QuietOpencv() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~QuietOpencv() { cv::utils::logging::setLogLevel(before_); }
  QuietOpencv(const QuietOpencv&) = delete;
  QuietOpencv& operator=(const QuietOpencv&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
  google::protobuf::LogSilencer silencer_;
};

/// What an exception of OpenCV's importers says, in one line; the operator that they do not know by its name.
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

std::string readAll(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  if (!file) throw Error(fmt::format("cannot read {}", path.string()));
  return bytes;
}

/// `shape` is what the network says of its input, N×C×H×W; 0 = any size.
void requireInputShape(const ModelSpec& spec, const fs::path& path, const std::vector<std::int64_t>& shape) {
  const auto& pre = spec.preprocessing;
  const std::vector<std::int64_t> ours{1, 3, pre.height, pre.width};
  const auto fits = [](std::int64_t theirs, std::int64_t own) { return theirs <= 0 || theirs == own; };
  if (shape.size() == ours.size() && std::equal(shape.begin(), shape.end(), ours.begin(), fits)) return;
  throw Error(fmt::format("{} takes an input of [{}] where model.toml makes [{}]; correct `input`",
                          path.string(), fmt::join(shape, "×"), fmt::join(ours, "×")));
}

/// OpenCV runs an ONNX network on any size, whatever it was made for: the file's own word is asked first.
void checkOnnx(const ModelSpec& spec, const fs::path& path, const std::string& bytes) {
  onnx::ModelProto model;
  if (!model.ParseFromString(bytes) || !model.has_graph())
    throw Error(fmt::format("{} is no ONNX file, or cut short; fetch it again", path.string()));
  std::set<std::string> weights;  // older files list them among the inputs, too
  for (const auto& weight : model.graph().initializer()) weights.insert(weight.name());
  for (const auto& input : model.graph().input()) {
    if (weights.contains(input.name()) || !input.type().tensor_type().has_shape()) continue;
    std::vector<std::int64_t> shape;
    for (const auto& size : input.type().tensor_type().shape().dim()) shape.push_back(size.dim_value());
    requireInputShape(spec, path, shape);
  }
}

cv::dnn::Net readOnnx(const ModelSpec& spec, const fs::path& path) {
  const std::string bytes = readAll(path);
  checkOnnx(spec, path, bytes);
  return cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
}

cv::dnn::Net readTflite(const ModelSpec& spec, const fs::path& path) {
  std::string onnx;
  {
    const std::string bytes = readAll(path);
    const auto graph =
        tflite::readGraph({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, path.string());
    const auto& shape = graph.tensors[static_cast<std::size_t>(graph.input)].shape;
    if (shape.size() != 4) throw Error(fmt::format("{} takes no picture as its input", path.string()));
    requireInputShape(spec, path, {shape[0], shape[3], shape[1], shape[2]});
    onnx = tflite::toOnnx(graph, path.string());
  }
  return cv::dnn::readNetFromONNX(onnx.data(), onnx.size());
}

cv::dnn::Net readNetwork(const ModelSpec& spec) {
  const fs::path path = modelFile(spec, spec.file);
  const std::string config = spec.config.empty() ? "" : modelFile(spec, spec.config).string();
  const std::string extension = spec.file.extension().string();
  const QuietOpencv quiet;
  try {
    if (extension == ".onnx") return readOnnx(spec, path);
    if (extension == ".tflite" || extension == ".lite") return readTflite(spec, path);
    if (extension == ".pb") return cv::dnn::readNetFromTensorflow(path.string(), config);
    if (extension == ".caffemodel") {
      if (config.empty())
        throw Error(fmt::format(
            "model {}: a .caffemodel needs its .prototxt; name it as `config` in model.toml", spec.name));
      return cv::dnn::readNetFromCaffe(config, path.string());
    }
  } catch (const cv::Exception& e) {
    throw Error(fmt::format("cannot open the network {}: {}", path.string(), reasonOf(e)));
  }
  throw Error(fmt::format(
      "model {}: \"{}\" is no known kind of network; known are .onnx, .tflite, .lite, .caffemodel and .pb",
      spec.name, spec.file.string()));
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

class OpencvEngine final : public Labeler {
 public:
  explicit OpencvEngine(const ModelSpec& spec)
      : spec_(spec),
        vocabulary_(Vocabulary::fromFile(modelFile(spec, spec.labels))),
        identity_(fmt::format("{} {}", spec.name, modelDigest(spec))),
        network_(readNetwork(spec)) {
    network_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    chooseOutput();
    label(cv::Mat(spec.preprocessing.height, spec.preprocessing.width, CV_8UC3, cv::Scalar::all(128)));
  }

  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return identity_; }
  cv::Mat prepare(const cv::Mat& bgr) const override { return preprocess(bgr, spec_.preprocessing); }

  LexicalDescriptor infer(const cv::Mat& prepared) override {
    cv::Mat result;
    try {
      const QuietOpencv quiet;
      network_.setInput(prepared);
      result = network_.forward(spec_.output);
    } catch (const cv::Exception& e) {
      throw Error(
          fmt::format("model {} does not work on an input of {}×{}: {}; correct `input` in model.toml",
                      spec_.name, spec_.preprocessing.width, spec_.preprocessing.height, reasonOf(e)));
    }
    if (result.type() != CV_32F || !result.isContinuous())
      throw Error(fmt::format("model {} gives no real numbers", spec_.name));
    const auto* first = result.ptr<float>();
    LexicalDescriptor values(first, first + result.total());
    if (spec_.softmax && !values.empty()) softmaxInPlace(values);
    requireProbabilities(values, vocabulary_.size(), "model " + spec_.name);
    return values;
  }

 private:
  void chooseOutput() {
    const auto outputs = network_.getUnconnectedOutLayersNames();
    if (spec_.output.empty() && outputs.size() == 1) {
      spec_.output = outputs[0];
    } else if (std::find(outputs.begin(), outputs.end(), spec_.output) == outputs.end()) {
      throw Error(fmt::format("model {} has the outputs {}; name one of them as `output` in model.toml",
                              spec_.name, fmt::join(outputs, ", ")));
    }
  }

  ModelSpec spec_;
  Vocabulary vocabulary_;
  std::string identity_;
  cv::dnn::Net network_;
};

}  // namespace

std::unique_ptr<Labeler> openWithOpencv(const ModelSpec& spec) {
  return std::make_unique<OpencvEngine>(spec);
}

}  // namespace estancia
