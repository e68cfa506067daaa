// TensorFlow.js networks: each operator against a plain implementation, and files that cannot be read.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>

#include "convert/network_builders.hpp"
#include "convert/tfjs_reader.hpp"
#include "convert/tfjs_weights.hpp"
#include "convert/tflite_to_onnx.hpp"
#include "estancia/core/error.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::randomValues;
using test::TfjsBuilder;
using Values = std::vector<float>;

constexpr int height = 6, width = 7, channels = 3;

/// The image that all networks here are given, H×W×C.
Values image() {
  return randomValues(height * width * channels, 7);
}

class TfjsReader : public testing::Test {
 protected:
  std::string convert(const std::string& input, const std::string& output) {
    const fs::path file = network_.write(scratch_.path());
    const auto network = tfjs::readGraph(file, {input, output, width, height});
    return tflite::toOnnx(network.graph, file.string());
  }

  /// What the network answers to image(); images as N×H×W×C, as TensorFlow has them.
  Values answer(const std::string& output = "", const std::string& input = "") {
    const cv::Mat out = test::answerOf(convert(input, output), image(), height, width, channels);
    Values result;
    if (out.dims != 4) return {out.ptr<float>(), out.ptr<float>() + out.total()};
    const int pixels = out.size[2] * out.size[3];
    for (int pixel = 0; pixel < pixels; ++pixel)
      for (int c = 0; c < out.size[1]; ++c) result.push_back(*(out.ptr<float>(0, c) + pixel));
    return result;
  }

  test::Caught refusal(const std::string& output = "", const std::string& input = "") {
    return test::caught([&] { convert(input, output); });
  }

  /// A good network: convolution, bias, ReLU6, one row of numbers.
  void writeGoodNetwork() {
    network_.weight("weights", {3, 3, 3, 4}, randomValues(108, 1));
    network_.weight("bias", {4}, randomValues(4, 2));
    network_.integers("shape", {2}, {1, -1});
    network_.node("Conv2D", "conv", {"image", "weights"}, TfjsBuilder::windowAttributes(2, true));
    network_.node("BiasAdd", "biased", {"conv", "bias"});
    network_.node("Relu6", "relu", {"biased"});
    network_.node("Reshape", "row", {"relu", "shape"});
  }

  test::ScratchFolder scratch_;
  TfjsBuilder network_;
};

void expectNear(const Values& actual, const Values& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) ASSERT_NEAR(actual[i], expected[i], 1e-5) << i;
}

float pixel(const Values& values, int y, int x, int c) {
  if (y < 0 || y >= height || x < 0 || x >= width) return 0;
  return values[static_cast<std::size_t>((y * width + x) * channels + c)];
}

TEST_F(TfjsReader, ConvolvesWithFiltersInTheLastDimension) {
  const Values in = image(), weights = randomValues(3 * 2 * channels * 5, 1);
  network_.weight("weights", {3, 2, channels, 5}, weights);
  network_.node("Conv2D", "conv", {"image", "weights"}, TfjsBuilder::windowAttributes(2, true));
  Values expected;  // SAME: 6 rows by 2 need one row of padding, behind; 7 columns one column, behind
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      for (int filter = 0; filter < 5; ++filter) {
        float sum = 0;
        for (int y = 0; y < 3; ++y)
          for (int x = 0; x < 2; ++x)
            for (int c = 0; c < channels; ++c)
              sum += pixel(in, 2 * row + y, 2 * column + x, c) *
                     weights[static_cast<std::size_t>(((y * 2 + x) * channels + c) * 5 + filter)];
        expected.push_back(sum);
      }
  expectNear(answer(), expected);
}

TEST_F(TfjsReader, ConvolvesEachChannelAlone) {
  const Values in = image(), weights = randomValues(3 * 3 * channels * 2, 1);
  network_.weight("weights", {3, 3, channels, 2}, weights);  // two filters a channel
  network_.node("DepthwiseConv2dNative", "conv", {"image", "weights"},
                TfjsBuilder::windowAttributes(1, false, 2));
  Values expected;  // dilated by 2, nine pixels span 5×5
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 3; ++column)
      for (int filter = 0; filter < 2 * channels; ++filter) {
        float sum = 0;
        for (int y = 0; y < 3; ++y)
          for (int x = 0; x < 3; ++x)
            sum += pixel(in, row + 2 * y, column + 2 * x, filter / 2) *
                   weights[static_cast<std::size_t>((y * 3 + x) * 2 * channels + filter)];
        expected.push_back(sum);
      }
  expectNear(answer(), expected);
}

TEST_F(TfjsReader, AddsAndMultipliesByChannel) {
  network_.weight("factor", {channels}, {2, -1, 0.5F});
  network_.weight("offset", {1, 1, 1, channels}, {0.1F, 0.2F, 0.3F});
  network_.weight("half", {}, {0.5F});
  network_.node("Mul", "scaled", {"factor", "image"});  // in either order
  network_.node("Add", "moved", {"scaled", "offset"});
  network_.node("AddV2", "sum", {"moved", "image"});
  network_.node("Mul", "product", {"sum", "image:0"});
  network_.node("Identity", "same", {"product", "^moved"});
  network_.node("Mul", "halved", {"same", "half"});
  const float factor[] = {2, -1, 0.5F}, offset[] = {0.1F, 0.2F, 0.3F};
  Values expected = image();
  for (std::size_t i = 0; i < expected.size(); ++i)
    expected[i] *= 0.5F * (expected[i] * factor[i % 3] + offset[i % 3] + expected[i]);
  expectNear(answer(), expected);
}

TEST_F(TfjsReader, NormalizesBatches) {
  const Values gamma{1, 2, 3}, beta{0.1F, 0.2F, 0.3F}, mean{0.5F, 0, -0.5F}, variance{0.25F, 1, 4};
  network_.weight("gamma", {3}, gamma);
  network_.weight("beta", {3}, beta);
  network_.weight("mean", {3}, mean);
  network_.weight("variance", {3}, variance);
  network_.node("FusedBatchNorm", "normal", {"image", "gamma", "beta", "mean", "variance"},
                {{"epsilon", {{"f", 0.01}}}});
  Values expected = image();
  for (std::size_t i = 0; i < expected.size(); ++i)
    expected[i] =
        (expected[i] - mean[i % 3]) * gamma[i % 3] / std::sqrt(variance[i % 3] + 0.01F) + beta[i % 3];
  expectNear(answer(), expected);
}

TEST_F(TfjsReader, CutsOffBelowAndAbove) {
  network_.weight("ten", {}, {10});
  network_.node("Mul", "large", {"image", "ten"});
  network_.node("Relu6", "six", {"large"});
  network_.node("Relu", "any", {"large"});
  network_.node("Sigmoid", "sure", {"large"});
  Values six = image(), any = image(), sure = image();
  for (float& v : sure) v = 1 / (1 + std::exp(-10 * v));
  for (float& v : six) v = std::clamp(10 * v, 0.0F, 6.0F);
  for (float& v : any) v = std::max(10 * v, 0.0F);
  expectNear(answer("six"), six);
  expectNear(answer("any"), any);
  expectNear(answer("sure"), sure);
}

TEST_F(TfjsReader, ReadsWhatIsFusedIntoAConvolution) {
  const Values in = image();
  network_.weight("weights", {1, 1, channels, channels}, {9, 0, 0, 0, 9, 0, 0, 0, 9});
  network_.weight("each", {1, 1, channels, 1}, {9, 9, 9});
  network_.weight("bias", {channels}, {1, 2, -3});
  const auto fused = [](const std::vector<std::string>& names) {
    auto attributes = TfjsBuilder::windowAttributes(1, true);
    attributes["fused_ops"]["list"]["s"] = names;
    return attributes;
  };
  const std::string bias = "Qmlhc0FkZA==", relu = "UmVsdQ==", relu6 = "UmVsdTY=", elu = "RWx1";
  network_.node("_FusedConv2D", "a", {"image", "weights", "bias"}, fused({bias}));
  network_.node("FusedDepthwiseConv2dNative", "b", {"image", "each", "bias"}, fused({bias, relu}));
  network_.node("_FusedConv2D", "c", {"image", "weights", "bias"}, fused({bias, relu6}));
  network_.node("_FusedConv2D", "d", {"image", "weights", "bias"}, fused({bias, elu}));
  network_.node("_FusedConv2D", "e", {"image", "weights", "each"}, fused({}));
  const float offset[] = {1, 2, -3};
  Values plain = in;
  for (std::size_t i = 0; i < plain.size(); ++i) plain[i] = 9 * plain[i] + offset[i % 3];
  expectNear(answer("a"), plain);
  for (float& v : plain) v = std::max(v, 0.0F);
  expectNear(answer("b"), plain);
  for (float& v : plain) v = std::min(v, 6.0F);
  expectNear(answer("c"), plain);
  EXPECT_THAT(refusal("d"), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(refusal("e"), FailsWith(ErrorCode::malformedFile));
}

TEST_F(TfjsReader, EndsAsAClassifier) {
  // mean of all pixels, flattened in two ways, a matrix, softmax
  const Values in = image(), weights = randomValues(6, 3);
  network_.integers("sides", {2}, {-2, 1});
  network_.weight("weights", {3, 2}, weights);
  network_.weight("bias", {2}, {0.5F, -0.5F});
  network_.node("Mean", "mean", {"image", "sides"}, {{"keep_dims", {{"b", true}}}});
  network_.node("Squeeze", "squeezed", {"mean"}, {{"squeeze_dims", {{"list", {{"i", {"1", "-2"}}}}}}});
  network_.node("Mean", "flat", {"image", "sides"});
  network_.node("Add", "twice", {"squeezed", "flat"});
  network_.node("MatMul", "logits", {"twice", "weights"});
  network_.node("BiasAdd", "biased", {"logits", "bias"});
  network_.node("Softmax", "out", {"biased"});
  Values logits{0.5F, -0.5F};
  for (std::size_t i = 0; i < in.size(); ++i)
    for (std::size_t j = 0; j < 2; ++j)
      logits[j] += 2 * in[i] / (height * width) * weights[i % channels * 2 + j];
  const float p = 1 / (1 + std::exp(logits[1] - logits[0]));
  expectNear(answer("biased"), logits);
  expectNear(answer(), {p, 1 - p});
  EXPECT_THAT(refusal("out", "twice"), FailsWith(ErrorCode::malformedFile));
}

TEST_F(TfjsReader, ReadsQuantizedWeights) {
  network_.quantized<std::uint8_t>("bytes", {3}, {0, 1, 255},
                                   {{"dtype", "uint8"}, {"scale", 0.5}, {"min", -1}});
  network_.quantized<std::uint16_t>("words", {3}, {0, 1000, 65535},
                                    {{"dtype", "uint16"}, {"scale", 0.001}, {"min", 2}});
  network_.quantized<std::uint16_t>("halves", {3}, {0x3C00, 0xC000, 0x3800}, {{"dtype", "float16"}});
  const auto file = network_.write(scratch_.path());
  const tfjs::Weights weights(network_.model["weightsManifest"], scratch_.path());
  expectNear(weights.reals("bytes"), {-1, -0.5F, 126.5F});
  expectNear(weights.reals("words"), {2, 3, 67.535F});
  expectNear(weights.reals("halves"), {1, -2, 0.5F});
  EXPECT_THAT(tfjs::weightFiles(file), testing::ElementsAre("shard1", "shard2"));
}

TEST_F(TfjsReader, TakesTheSizeFromThePlaceholderAndRefusesAnother) {
  network_.node("Relu", "positive", {"image"});
  const auto take = [this](const std::vector<std::string>& sizes) {
    auto& takes = network_.model["modelTopology"]["node"][0]["attr"]["shape"]["shape"]["dim"];
    takes = TfjsBuilder::Json::array();
    for (const auto& size : sizes) takes.push_back({{"size", size}});
  };
  take({"-1", "6", "-1", "3"});
  EXPECT_FALSE(refusal().code);
  for (const std::vector<std::string>& other :
       {std::vector<std::string>{"-1", "6", "-1", "1"}, {"1", "7", "6", "3"}, {"1", "18"}}) {
    take(other);
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::mismatch)) << other.back();
  }
  const auto shape = [&] {
    const auto network = tfjs::readGraph(network_.write(scratch_.path()), {});
    return network.graph.tensors[static_cast<std::size_t>(network.graph.input)].shape;
  };
  take({"-1", "20", "30", "3"});
  EXPECT_THAT(shape(), testing::ElementsAre(1, 20, 30, 3));
  for (const char* side : {"-1", "0", "5000", "99999999999"}) {
    take({"1", "20", side, "3"});
    EXPECT_THAT(shape, FailsWith(ErrorCode::invalidInput)) << side;
  }
}

TEST_F(TfjsReader, RefusesOtherFiles) {
  const fs::path file = scratch_ / "model.json";
  const auto read = [&] { tfjs::readGraph(file, {"", "", 8, 8}); };
  EXPECT_THAT(read, FailsWith(ErrorCode::fileUnreadable));
  for (const std::string text : {"", "{", "7", "{\"modelTopology\": 3}", "\xff\xfe"}) {
    test::writeFile(file, text);
    EXPECT_THAT(read, FailsWith(ErrorCode::malformedFile)) << text;
  }
  network_.model["modelTopology"].erase("node");
  network_.model["modelTopology"]["model_config"] = "of Keras";
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(TfjsReader, KeepsWeightsInItsFolder) {
  writeGoodNetwork();
  for (const std::string path : {"../shard1", "/etc/passwd", "a/../../b", ""}) {
    network_.model["weightsManifest"][0]["paths"][0] = path;
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::unsafePath)) << path;
    EXPECT_THAT([&] { tfjs::weightFiles(scratch_ / "model.json"); }, FailsWith(ErrorCode::unsafePath));
  }
  network_.model["weightsManifest"][0]["paths"][0] = "shard2";
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile));
  const test::ScratchFolder outside;
  test::writeFile(outside / "secret", "x");
  fs::create_symlink(outside / "secret", scratch_ / "link");
  network_.model["weightsManifest"][0]["paths"][0] = "link";
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::unsafePath));
}

TEST_F(TfjsReader, SaysWhichWeightsAreMissingOrCut) {
  writeGoodNetwork();
  const fs::path file = network_.write(scratch_.path());
  const auto read = [&] { tfjs::readGraph(file, {"", "", width, height}); };
  EXPECT_NO_THROW(read());
  test::writeFile(scratch_ / "shard2", test::readFile(scratch_ / "shard2").substr(1));
  EXPECT_THAT(read, FailsWith(ErrorCode::truncatedFile));
  fs::remove(scratch_ / "shard2");
  EXPECT_THAT(read, FailsWith(ErrorCode::fileNotFound));
  fs::create_directory(scratch_ / "shard2");
  EXPECT_THAT(read, FailsWith(ErrorCode::fileNotFound));
}

TEST_F(TfjsReader, RefusesAbsurdWeights) {
  using Json = TfjsBuilder::Json;
  const std::vector<std::tuple<const char*, Json, ErrorCode>> cases{
      {"shape", {3, -3, 3, 4}, ErrorCode::malformedFile},
      {"shape", std::vector<int>(9, 1), ErrorCode::malformedFile},
      {"shape", {1 << 14, 1 << 14}, ErrorCode::truncatedFile},  // 1 GiB is not allocated
      {"shape", "3", ErrorCode::malformedFile},
      {"dtype", "string", ErrorCode::unsupportedFile},
      {"quantization", {{"dtype", "uint4"}}, ErrorCode::unsupportedFile},
      {"dtype", "int32", ErrorCode::malformedFile},
      {"name", "others", ErrorCode::malformedFile}};
  for (const auto& [key, value, code] : cases) {
    network_ = TfjsBuilder();
    writeGoodNetwork();
    network_.model["weightsManifest"][0]["weights"][0][key] = value;
    EXPECT_THAT(refusal(), FailsWith(code)) << key << value;
  }
}

TEST_F(TfjsReader, RefusesGraphsThatDoNotFit) {
  using Json = TfjsBuilder::Json;
  const auto altered = [this](std::size_t node, const char* key, const Json& value) {
    network_ = TfjsBuilder();
    writeGoodNetwork();
    network_.model["modelTopology"]["node"][node][key] = value;
    return refusal("row", "image");
  };
  constexpr std::size_t conv = 4, biased = 5, relu = 6, row = 7;
  EXPECT_FALSE(altered(relu, "op", "Relu").code);
  auto channelsFirst = TfjsBuilder::windowAttributes(2, true);
  channelsFirst["data_format"]["s"] = "TkNIVw==";
  const std::vector<std::tuple<std::size_t, const char*, Json, ErrorCode>> cases{
      {relu, "op", "ResizeBilinear", ErrorCode::unsupportedFile},
      {relu, "input", {"nowhere"}, ErrorCode::malformedFile},
      {relu, "input", {"row"}, ErrorCode::malformedFile},
      {relu, "name", "conv", ErrorCode::malformedFile},
      {relu, "input", Json::array(), ErrorCode::malformedFile},
      {relu, "input", {"biased:1"}, ErrorCode::malformedFile},
      {relu, "input", {"bias"}, ErrorCode::malformedFile},
      {biased, "input", {"conv", "image"}, ErrorCode::malformedFile},
      {conv, "input", {"image", "image"}, ErrorCode::malformedFile},
      {conv, "input", {"image", "weights", "bias"}, ErrorCode::malformedFile},
      {conv, "attr", nullptr, ErrorCode::unsupportedFile},
      {conv, "attr", channelsFirst, ErrorCode::unsupportedFile},
      {conv, "attr", TfjsBuilder::windowAttributes(1, false, 4), ErrorCode::malformedFile},
      {row, "input", {"relu", "bias"}, ErrorCode::malformedFile}};
  for (const auto& [node, key, value, code] : cases)
    EXPECT_THAT(altered(node, key, value), FailsWith(code)) << node << key << value;
  for (const char* strides : {"0", "-1", "5000", "9999999999999999999999", "x", ""}) {
    auto attributes = TfjsBuilder::windowAttributes(2, true);
    attributes["strides"]["list"]["i"][1] = strides;
    EXPECT_THAT(altered(conv, "attr", attributes), FailsWith(ErrorCode::malformedFile)) << strides;
  }
  using Shape = std::vector<std::int32_t>;
  for (const Shape& shape : {Shape{-1, -1}, {5, -1}, {0, -1}, {-2, 3}, {1 << 30, 1 << 30}, {125}, {-7}}) {
    network_ = TfjsBuilder();
    network_.integers("shape", {static_cast<int>(shape.size())}, shape);
    network_.node("Reshape", "row", {"image", "shape"});
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile));
  }
}

TEST_F(TfjsReader, StartsAndEndsAtAnyNodeAndAsksWhereThereAreSeveral) {
  network_.node("ResizeBilinear", "resized", {"image"});
  network_.node("Relu", "positive", {"resized"});
  network_.node("Relu", "other", {"resized"});
  Values expected = image();
  for (float& v : expected) v = std::max(v, 0.0F);
  expectNear(answer("positive", "resized"), expected);
  onnx::ModelProto model;
  model.ParseFromString(convert("resized", "positive"));
  EXPECT_EQ(model.graph().output(0).name(), "positive");
  EXPECT_THAT(refusal("", "resized"), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(refusal("c", "resized"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal("image", "image"), FailsWith(ErrorCode::invalidInput));
  network_.node("Placeholder", "second", {});
  EXPECT_THAT(refusal("positive"), FailsWith(ErrorCode::invalidInput));
}

TEST_F(TfjsReader, RefusesToWriteAWeightTooOften) {
  network_.weight("values", {1 << 16}, Values(1 << 16));
  std::string last = "image";
  for (int i = 0; i < 4200; ++i) {  // 256 KiB in the file would become more than 1 GiB
    const std::string name = "sum" + std::to_string(i);
    network_.node("Add", name, {last, "values"});
    last = name;
  }
  const auto file = network_.write(scratch_.path());
  EXPECT_THAT([&] { tfjs::readGraph(file, {"", "", 1, 1}); }, FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia
