// Writes small networks of TensorFlow, right or wrong, for the tests, and runs what they become.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <onnx/checker.h>
#include <onnx/onnx_pb.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/dnn.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "support/support.hpp"
#include "tflite_generated.h"

namespace estancia::test {

inline std::vector<float> randomValues(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<float> values(static_cast<std::size_t>(count));
  for (float& v : values) v = uniform(random);
  return values;
}

/// What an ONNX network answers to an image H×W×C; images as N×C×H×W.
inline cv::Mat answerOf(const std::string& bytes, const std::vector<float>& image, int height, int width,
                        int channels) {
  onnx::ModelProto model;
  EXPECT_TRUE(model.ParseFromString(bytes));
  EXPECT_NO_THROW(onnx::checker::check_model(model));
  cv::Mat blob({1, channels, height, width}, CV_32F);
  for (int i = 0; i < height * width * channels; ++i)
    *(blob.ptr<float>(0, i % channels) + i / channels) = image[static_cast<std::size_t>(i)];
  auto network = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
  network.setInput(blob);
  return network.forward().clone();
}

/// A graph of nodes and one group of weights. `model` may be altered before it is written.
class TfjsBuilder {
 public:
  using Json = nlohmann::json;

  TfjsBuilder() {
    model["modelTopology"]["node"] = Json::array();
    model["weightsManifest"] = Json::array({{{"paths", {"shard1", "shard2"}}, {"weights", Json::array()}}});
    node("Placeholder", "image", {});
  }

  Json& node(const std::string& op, const std::string& name, const std::vector<std::string>& inputs,
             const Json& attributes = Json::object()) {
    auto& nodes = model["modelTopology"]["node"];
    nodes.push_back({{"name", name}, {"op", op}, {"input", inputs}, {"attr", attributes}});
    return nodes.back();
  }

  Json& weight(const std::string& name, const std::vector<int>& shape, const std::vector<float>& values) {
    return constant(name, shape, "float32", values);
  }
  Json& integers(const std::string& name, const std::vector<int>& shape,
                 const std::vector<std::int32_t>& values) {
    return constant(name, shape, "int32", values);
  }
  /// Values in a type of their own, `quantization` defines how to read them.
  template <class Stored>
  void quantized(const std::string& name, const std::vector<int>& shape, const std::vector<Stored>& values,
                 const Json& quantization) {
    constant(name, shape, "float32", values)["quantization"] = quantization;
  }

  static Json windowAttributes(int stride, bool same, int dilation = 1) {
    const auto list = [](int value) {
      return Json{{"list", {{"i", {"1", std::to_string(value), std::to_string(value), "1"}}}}};
    };
    // one text as base64, one as bytes: both occur
    return {{"strides", list(stride)},
            {"dilations", list(dilation)},
            {"padding", {{"s", same ? "U0FNRQ==" : "VkFMSUQ="}}},
            {"data_format", {{"s", {78, 72, 87, 67}}}}};
  }

  /// Writes model.json and its two shards into `folder`.
  std::filesystem::path write(const std::filesystem::path& folder) const {
    const std::size_t half = bytes_.size() / 2 - bytes_.size() / 2 % 3;  // in the middle of a number
    writeFile(folder / "shard1", bytes_.substr(0, half));
    writeFile(folder / "shard2", bytes_.substr(half));
    writeFile(folder / "model.json", model.dump());
    return folder / "model.json";
  }

  Json model;

 private:
  template <class Value>
  Json& constant(const std::string& name, const std::vector<int>& shape, const char* type,
                 const std::vector<Value>& values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
    node("Const", name, {});
    auto& weights = model["weightsManifest"][0]["weights"];
    weights.push_back({{"name", name}, {"shape", shape}, {"dtype", type}});
    return weights.back();
  }

  std::string bytes_;
};

namespace format = tflite::format;

/// One graph of an image input. Tensors are added first; they are numbered from 0 in the order of adding.
class TfliteBuilder {
 public:
  /// A computed tensor, or the input. `scale` 0 = not quantized.
  int tensor(const std::vector<int>& shape, format::ElementType type = format::ElementType::FLOAT32,
             float scale = 0, std::int64_t zeroPoint = 0) {
    return add(shape, type, scale == 0 ? std::vector<float>{} : std::vector<float>{scale},
               scale == 0 ? std::vector<std::int64_t>{} : std::vector<std::int64_t>{zeroPoint}, 0, 0);
  }

  template <class Value>
  int constant(const std::vector<int>& shape, format::ElementType type, const std::vector<Value>& values,
               const std::vector<float>& scales = {}, const std::vector<std::int64_t>& zeroPoints = {},
               int axis = 0) {
    std::vector<std::uint8_t> bytes(values.size() * sizeof(Value));
    if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    buffers_.push_back(format::CreateBufferDirect(out_, &bytes));
    return add(shape, type, scales, zeroPoints, axis, static_cast<std::uint32_t>(buffers_.size() - 1));
  }
  int constant(const std::vector<int>& shape, const std::vector<float>& values) {
    return constant(shape, format::ElementType::FLOAT32, values);
  }

  void conv(int input, int weights, int bias, int output, format::Padding padding, int strideX, int strideY,
            int dilation = 1, format::Activation activation = format::Activation::NONE) {
    op(3, {input, weights, bias}, output, format::Options::Conv2D,
       format::CreateConv2D(out_, padding, strideX, strideY, activation, dilation, dilation).Union());
  }
  void depthwise(int input, int weights, int output, format::Padding padding, int strideX, int strideY,
                 int dilation) {
    op(4, {input, weights}, output, format::Options::DepthwiseConv2D,
       format::CreateDepthwiseConv2D(out_, padding, strideX, strideY, 1, format::Activation::NONE, dilation,
                                     dilation)
           .Union());
  }
  void pool(bool average, int input, int output, format::Padding padding, int strideX, int strideY,
            int filterX, int filterY) {
    op(average ? 1 : 17, {input}, output, format::Options::Pool2D,
       format::CreatePool2D(out_, padding, strideX, strideY, filterX, filterY).Union());
  }
  void add(int a, int b, int output, format::Activation activation = format::Activation::NONE) {
    op(0, {a, b}, output, format::Options::Add, format::CreateAdd(out_, activation).Union());
  }
  void concatenation(const std::vector<int>& inputs, int output, int axis) {
    op(2, inputs, output, format::Options::Concatenation, format::CreateConcatenation(out_, axis).Union());
  }
  void fullyConnected(int input, int weights, int bias, int output) {
    op(9, {input, weights, bias}, output, format::Options::FullyConnected,
       format::CreateFullyConnected(out_).Union());
  }
  void softmax(int input, int output) {
    op(25, {input}, output, format::Options::Softmax, format::CreateSoftmax(out_, 1.0F).Union());
  }
  void plain(int code, const std::vector<int>& inputs, int output) {
    op(code, inputs, output, format::Options::NONE, 0);
  }

  std::string file(int input, int output) {
    const std::vector<int> inputs{input}, outputs{output};
    const std::vector<flatbuffers::Offset<format::SubGraph>> graphs{
        format::CreateSubGraphDirect(out_, &tensors_, &inputs, &outputs, &operators_)};
    format::FinishModelBuffer(out_, format::CreateModelDirect(out_, 3, &codes_, &graphs, "test", &buffers_));
    return {reinterpret_cast<const char*>(out_.GetBufferPointer()), out_.GetSize()};
  }

 private:
  int add(const std::vector<int>& shape, format::ElementType type, const std::vector<float>& scales,
          const std::vector<std::int64_t>& zeroPoints, int axis, std::uint32_t buffer) {
    flatbuffers::Offset<format::Quantization> quantization;
    if (!scales.empty()) quantization = format::CreateQuantizationDirect(out_, &scales, &zeroPoints, axis);
    const std::string name = "tensor " + std::to_string(tensors_.size());
    tensors_.push_back(format::CreateTensorDirect(out_, &shape, type, buffer, name.c_str(), quantization));
    return static_cast<int>(tensors_.size()) - 1;
  }

  void op(int code, const std::vector<int>& inputs, int output, format::Options type,
          flatbuffers::Offset<void> options) {
    const std::vector<int> outputs{output};
    codes_.push_back(
        format::CreateOperatorCodeDirect(out_, static_cast<std::int8_t>(code), nullptr, 1, code));
    operators_.push_back(format::CreateOperatorDirect(out_, static_cast<std::uint32_t>(codes_.size() - 1),
                                                      &inputs, &outputs, type, options));
  }

  flatbuffers::FlatBufferBuilder out_;
  std::vector<flatbuffers::Offset<format::Buffer>> buffers_{format::CreateBufferDirect(out_)};
  std::vector<flatbuffers::Offset<format::Tensor>> tensors_;
  std::vector<flatbuffers::Offset<format::OperatorCode>> codes_;
  std::vector<flatbuffers::Offset<format::Operator>> operators_;
};

}  // namespace estancia::test
