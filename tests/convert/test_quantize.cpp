// Quantized networks: what comes out beside a slow emulation in real numbers, what is quantized, what is
// refused. SPDX-License-Identifier: Apache-2.0
#include "convert/quantize.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <random>
#include <set>

#include "convert/quantization_plan.hpp"
#include "convert/to_onnx.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/labelers/engines.hpp"
#include "estancia/labelers/model_spec.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia::convert {
namespace {

using test::FailsWith;
using testing::Contains;
using testing::ElementsAre;
using testing::Not;

constexpr int side = 6, filters = 4, outputs = 5;

void addTensor(onnx::GraphProto& graph, const std::string& name, const std::vector<int>& shape,
               const std::vector<float>& values) {
  auto* tensor = graph.add_initializer();
  tensor->set_name(name);
  tensor->set_data_type(onnx::TensorProto::FLOAT);
  for (const int size : shape) tensor->add_dims(size);
  for (const float value : values) tensor->add_float_data(value);
}

onnx::NodeProto& addNode(onnx::GraphProto& graph, const char* type, const std::vector<std::string>& inputs,
                         const std::string& output) {
  auto* node = graph.add_node();
  node->set_op_type(type);
  for (const auto& input : inputs) node->add_input(input);
  node->add_output(output);
  return *node;
}

void describe(onnx::ValueInfoProto* value, const std::string& name, const std::vector<int>& shape) {
  value->set_name(name);
  auto* type = value->mutable_type()->mutable_tensor_type();
  type->set_elem_type(onnx::TensorProto::FLOAT);
  for (const int size : shape) type->mutable_shape()->add_dim()->set_dim_value(size);
}

/// input → as many convolutions as stay float, which change nothing → image → conv 1×1 → ReLU → concatenation
/// with itself → mean → conv 1×1 → scores.
struct SmallNetwork {
  std::vector<float> first, bias, last;

  explicit SmallNetwork(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    const auto fill = [&](std::vector<float>& values, int count) {
      for (int i = 0; i < count; ++i) values.push_back(normal(random));
    };
    fill(first, filters * 3);
    fill(bias, filters);
    fill(last, outputs * filters * 2);
  }

  std::string onnx() const {
    onnx::ModelProto model;
    model.set_ir_version(5);
    model.add_opset_import()->set_version(10);
    auto& graph = *model.mutable_graph();
    graph.set_name("small");
    describe(graph.add_input(), "input", {1, 3, side, side});
    addTensor(graph, "identity", {3, 3, 1, 1}, {1, 0, 0, 0, 1, 0, 0, 0, 1});
    std::string before = "input";
    for (int k = 0; k < floatLayers; ++k) {
      const std::string next = k + 1 < floatLayers ? "kept" + std::to_string(k) : "image";
      addNode(graph, "Conv", {before, "identity"}, next);
      before = next;
    }
    addTensor(graph, "w1", {filters, 3, 1, 1}, first);
    addTensor(graph, "b1", {filters}, bias);
    addTensor(graph, "w2", {outputs, filters * 2, 1, 1}, last);
    addNode(graph, "Conv", {"image", "w1", "b1"}, "sums");
    addNode(graph, "Relu", {"sums"}, "positive");
    auto& concat = addNode(graph, "Concat", {"positive", "positive"}, "both");
    auto* axis = concat.add_attribute();
    axis->set_name("axis");
    axis->set_type(onnx::AttributeProto::INT);
    axis->set_i(1);
    addNode(graph, "GlobalAveragePool", {"both"}, "mean");
    addNode(graph, "Conv", {"mean", "w2"}, "scores");
    describe(graph.add_output(), "scores", {1, outputs, 1, 1});
    return model.SerializeAsString();
  }
};

const ActivationRanges ranges{{"image", {-1, 1}}, {"positive", {0, 4}}, {"both", {0, 4}}, {"mean", {0, 3}}};

/// A number as quantized to 8 bits.
double stored(double number, ActivationRange range) {
  const double step = (range.high - range.low) / 255, zero = std::nearbyint(-range.low / step);
  return (std::clamp(std::nearbyint(number / step) + zero, 0.0, 255.0) - zero) * step;
}

/// The network in real numbers, each value rounded to its 8 bits.
std::vector<double> emulated(const SmallNetwork& network, const cv::Mat& image) {
  std::vector<double> mean(filters);
  for (int f = 0; f < filters; ++f) {
    const auto weights = std::vector<float>(network.first.begin() + f * 3, network.first.begin() + f * 3 + 3);
    const double scale = weightScale(weights, 0);
    for (int p = 0; p < side * side; ++p) {
      const double biasStep = scale * 2 / 255;
      double sum = std::nearbyint(network.bias[static_cast<std::size_t>(f)] / biasStep) * biasStep;
      for (int c = 0; c < 3; ++c)
        sum += std::clamp(std::nearbyint(weights[static_cast<std::size_t>(c)] / scale), -127.0, 127.0) *
               scale * stored(image.ptr<float>(0, c)[p], ranges.at("image"));
      mean[static_cast<std::size_t>(f)] += stored(std::max(sum, 0.0), ranges.at("both")) / (side * side);
    }
  }
  std::vector<double> scores(outputs);
  for (int o = 0; o < outputs; ++o)
    for (int f = 0; f < filters * 2; ++f)
      scores[static_cast<std::size_t>(o)] +=
          network.last[static_cast<std::size_t>(o * filters * 2 + f)] *
          stored(mean[static_cast<std::size_t>(f % filters)], ranges.at("mean"));
  return scores;
}

onnx::ModelProto parsed(const std::string& bytes) {
  onnx::ModelProto model;
  EXPECT_TRUE(model.ParseFromString(bytes));
  return model;
}

TEST(Quantize, ComputesWhatASlowEmulationComputes) {
  ESTANCIA_NEEDS(test::findOnnxruntime(), "ONNX Runtime is missing; run script/bootstrap and build again");
  for (unsigned seed = 0; seed < 8; ++seed) {
    const SmallNetwork network(seed);
    const auto labeler = openNetworkValues(quantizedOnnx(network.onnx(), ranges, "small"), "small", 1);
    cv::Mat image({1, 3, side, side}, CV_32F);
    cv::RNG(seed).fill(image, cv::RNG::UNIFORM, -1.2, 1.2);  // some saturate
    const std::vector<double> expected = emulated(network, image);
    labeler->run(image, [&](std::size_t, std::span<const float> scores) {
      ASSERT_EQ(scores.size(), expected.size());
      // One number on the edge between two steps may fall to the other side.
      for (std::size_t i = 0; i < scores.size(); ++i) EXPECT_NEAR(scores[i], expected[i], 0.06) << seed;
    });
  }
}

TEST(Quantize, KeepsTheFirstLayersAndTheLastFloat) {
  const SmallNetwork network(1);
  EXPECT_THAT(valuesToQuantize(network.onnx(), "small"), ElementsAre("image", "positive", "both", "mean"));
  const onnx::ModelProto model = parsed(quantizedOnnx(network.onnx(), ranges, "small"));
  std::set<std::string> constants;
  for (const auto& constant : model.graph().initializer()) constants.insert(constant.name());
  EXPECT_THAT(constants, Contains("identity"));
  EXPECT_THAT(constants, Contains("w2"));
  EXPECT_THAT(constants, Not(Contains("w1")));
  EXPECT_EQ(model.opset_import(0).version(), 13);
  // A concatenation moves bytes: all that it reads and writes has one scale.
  std::map<std::string, std::string> scaleOf;
  for (const auto& node : model.graph().node())
    if (node.op_type() == "QuantizeLinear") scaleOf[node.input(0)] = node.input(1);
  EXPECT_EQ(scaleOf["positive"], scaleOf["both"]);
  EXPECT_NE(scaleOf["both"], scaleOf["mean"]);
}

TEST(Quantize, WeightsOnAGridKeepIt) {
  std::vector<float> weights;
  for (int i = -100; i <= 90; ++i) weights.push_back(0.013F * static_cast<float>(i));
  EXPECT_EQ(weightStep(weights), 0.013F);
  EXPECT_EQ(weightScale(weights, 0.013F), 0.013F);
  weights.push_back(0.0055F);
  EXPECT_EQ(weightStep(weights), 0);
  EXPECT_EQ(weightStep({}), 0);
  EXPECT_EQ(weightStep({0, 0}), 0);
}

TEST(Quantize, AFilterOfZerosHasAScale) {
  EXPECT_GT(weightScale({0, 0, 0}, 0), 0);
  SmallNetwork network(1);
  std::fill(network.first.begin(), network.first.begin() + 3, 0.0F);
  EXPECT_NO_THROW(quantizedOnnx(network.onnx(), ranges, "small"));
}

TEST(Quantize, RefusesWhatItCannotQuantize) {
  const std::string good = SmallNetwork(1).onnx();
  EXPECT_THAT([&] { quantizedOnnx("no network", ranges, "net.onnx"); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { quantizedOnnx(good.substr(0, good.size() / 2), ranges, "net.onnx"); },
              FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { quantizedOnnx(quantizedOnnx(good, ranges, "x"), ranges, "net.onnx"); },
              FailsWith(ErrorCode::unsupportedFile));
  ActivationRanges lacking = ranges;
  lacking.erase("mean");
  EXPECT_THAT([&] { quantizedOnnx(good, lacking, "net.onnx"); }, FailsWith(ErrorCode::mismatch));
  SmallNetwork infinite(1);
  infinite.first[2] = INFINITY;
  EXPECT_THAT([&] { quantizedOnnx(infinite.onnx(), ranges, "net.onnx"); },
              FailsWith(ErrorCode::malformedFile));
  SmallNetwork cut(1);
  cut.bias.pop_back();
  EXPECT_THAT([&] { quantizedOnnx(cut.onnx(), ranges, "net.onnx"); }, FailsWith(ErrorCode::malformedFile));
}

TEST(Quantize, TheDefaultNetworkIsTheOneThatBootstrapMakes) {
  const auto folder = test::findFetched("models/inception-v3");
  ESTANCIA_NEEDS(folder, "the default network is missing; run script/bootstrap");
  const test::ScratchFolder scratch;
  const auto ranges = std::filesystem::path(ESTANCIA_SOURCE_DIR) / "models/inception-v3/int8-ranges.txt";
  writeQuantized(*folder / "inception-v3.onnx", ranges, scratch / "out.onnx");
  EXPECT_EQ(sha256OfFile(scratch / "out.onnx"), readModelSpec(*folder).sha256.at("inception-v3-int8.onnx"));
}

}  // namespace
}  // namespace estancia::convert
