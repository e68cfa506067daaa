// TensorFlow networks written as ONNX files, with margins folded, and installed as models.
// SPDX-License-Identifier: Apache-2.0
#include "convert/fold_pads.hpp"
#include "convert/model_folder.hpp"
#include "convert/to_onnx.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <onnx/onnx_pb.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "convert/network_builders.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/model_spec.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia::convert {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;

class Convert : public testing::Test {
 protected:
  test::Caught refusal(const std::string& name, const std::string& bytes) {
    writeFile(scratch_ / name, bytes);
    return test::caught([&] { writeOnnx({.file = scratch_ / name}, target_); });
  }

  test::ScratchFolder scratch_;
  const fs::path target_ = scratch_ / "out.onnx";
};

TEST_F(Convert, TheDefaultNetworkIsTheOneThatBootstrapMakes) {
  const auto folder = test::findFetched("models/inception-v3");
  ESTANCIA_NEEDS(folder, "the default network is missing; run script/bootstrap");
  const OnnxSummary summary = writeOnnx({.file = *folder / "graph.lite"}, target_);
  ASSERT_EQ(summary.inputs.size(), 1U);
  EXPECT_THAT(summary.inputs[0].second, ElementsAre(1, 3, 299, 299));
  ASSERT_EQ(summary.outputs.size(), 1U);
  EXPECT_THAT(summary.outputs[0].second, ElementsAre(1, 1001));
  EXPECT_EQ(summary.operatorSet, 10);

  EXPECT_EQ(sha256OfFile(target_), readModelSpec(*folder).sha256.at("inception-v3.onnx"));
}

TEST_F(Convert, SoIsTheDetector) {
  const auto folder = test::findFetched("models/coco-ssd");
  ESTANCIA_NEEDS(folder, "the detector is missing; run script/bootstrap");
  writeOnnx({*folder / "model.json", "Preprocessor/sub", "concat_1", 300, 300}, target_);
  EXPECT_EQ(sha256OfFile(target_), readModelSpec(*folder).sha256.at("coco-ssd.onnx"));
}

TEST_F(Convert, AnOnnxFileIsOnlyChecked) {
  const std::string good = test::smallOnnx(8, 4);
  EXPECT_FALSE(refusal("small.onnx", good).code);
  EXPECT_EQ(test::readFile(target_), good);
}

TEST_F(Convert, WritesNothingThatIsNotSound) {
  const auto unknown = [](onnx::GraphProto& g) { g.mutable_node(0)->set_op_type("FancyPool"); };
  const auto contradiction = [](onnx::GraphProto& g) {
    g.mutable_output(0)
        ->mutable_type()
        ->mutable_tensor_type()
        ->mutable_shape()
        ->mutable_dim(1)
        ->set_dim_value(7);
  };
  const auto dangling = [](onnx::GraphProto& g) { g.mutable_node(1)->set_input(0, "nowhere"); };
  EXPECT_THAT(refusal("unknown.onnx", test::smallOnnx(8, 4, unknown)), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal("shapes.onnx", test::smallOnnx(8, 4, contradiction)),
              FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal("dangling.onnx", test::smallOnnx(8, 4, dangling)), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal("cut.onnx", test::smallOnnx(8, 4).substr(0, 50)), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal("net.tflite", "not one"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal("net.caffemodel", "x"), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_FALSE(fs::exists(target_));
}

/// image → Pad → two convolutions, of which the second pads by itself, too.
onnx::GraphProto padded(const std::vector<std::int64_t>& widths = {0, 0, 1, 2, 0, 0, 3, 4}, float value = 0) {
  const std::string nodes = R"(
    node { op_type: "Pad" input: "image" input: "widths" input: "value" output: "wide" }
    node { op_type: "Conv" input: "wide" input: "w1" output: "a" }
    node { op_type: "Conv" input: "wide" input: "w2" output: "b"
           attribute { name: "pads" type: INTS ints: [5, 6, 7, 8] } }
    output { name: "a" } output { name: "b" })";
  const std::string constants = fmt::format(
      "initializer {{ name: 'widths' data_type: 7 dims: {} int64_data: [{}] }} "
      "initializer {{ name: 'value' data_type: 1 float_data: {} }}",
      widths.size(), fmt::join(widths, ", "), value);
  onnx::GraphProto graph;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(nodes + constants, &graph));
  return graph;
}

bool isFolded(onnx::GraphProto graph) {
  const int before = graph.node_size();
  foldPads(graph);
  return graph.node_size() < before;
}

TEST(FoldPads, AddsTheWidthsToTheConvolutions) {
  onnx::GraphProto graph = padded();
  foldPads(graph);
  ASSERT_EQ(graph.node_size(), 2);
  for (const auto& node : graph.node()) EXPECT_EQ(node.input(0), "image");
  EXPECT_THAT(graph.node(0).attribute(0).ints(), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(graph.node(1).attribute(0).ints(), ElementsAre(6, 8, 10, 12));
}

TEST(FoldPads, LeavesWhatIsNoMarginOfZeros) {
  EXPECT_TRUE(isFolded(padded()));
  EXPECT_FALSE(isFolded(padded({0, 0, 1, 2, 0, 0, 3, 4}, 0.5F)));
  EXPECT_FALSE(isFolded(padded({0, 1, 1, 2, 0, 0, 3, 4})));   // channels
  EXPECT_FALSE(isFolded(padded({0, 0, -1, 2, 0, 0, 3, 4})));  // cuts
  EXPECT_FALSE(isFolded(padded({1, 2, 3, 4})));               // no images
  onnx::GraphProto reflecting = padded();
  onnx::AttributeProto& mode = *reflecting.mutable_node(0)->add_attribute();
  mode.set_name("mode");
  mode.set_type(onnx::AttributeProto::STRING);
  mode.set_s("reflect");
  EXPECT_FALSE(isFolded(reflecting));
  onnx::GraphProto computed = padded();
  computed.mutable_node(0)->set_input(1, "elsewhere");
  EXPECT_FALSE(isFolded(computed));
}

class ModelFolder : public testing::Test {
 protected:
  void SetUp() override { setenv("ESTANCIA_HOME", (scratch_ / "home").c_str(), 1); }
  void TearDown() override { unsetenv("ESTANCIA_HOME"); }

  /// A detector of 4 classes at 16 anchors in an image of 8×8, and nodes on both sides that are not wanted.
  void writeDetector(const std::string& more = "") const {
    test::TfjsBuilder network;
    network.node("ResizeBilinear", "resized", {"image"});
    network.weight("weights", {3, 3, 3, 4}, std::vector<float>(108, 0.01F));
    network.integers("shape", {3}, {1, 16, 4});
    network.node("Conv2D", "conv", {"resized", "weights"}, test::TfjsBuilder::windowAttributes(2, true));
    network.node("Reshape", "scores", {"conv", "shape"});
    network.node("NonMaxSuppressionV3", "boxes", {"scores"});
    fs::create_directories(folder_);
    network.write(folder_);
    writeFile(folder_ / "labels.txt", test::labelLines(3));
    writeFile(folder_ / "model.toml",
              test::modelToml("model.json", 8,
                              "sigmoid = true\nreduce = \"max\"\nunused = [0]\ninput_node = \"resized\"\n"
                              "output = \"scores\"\n" +
                                  more));
  }

  const test::ScratchFolder scratch_;
  const fs::path folder_ = scratch_ / "detector";
};

TEST_F(ModelFolder, WithATensorflowNetworkIsNotOpened) {
  writeDetector();
  EXPECT_THAT([&] { loadModel(folder_.string()); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(ModelFolder, IsConvertedAndInstalled) {
  writeDetector();
  fs::path copy;
  {
    const ConvertedModel model(folder_);
    copy = model.folder();
    EXPECT_EQ(addModel(copy).labels, 3U);
  }
  EXPECT_FALSE(fs::exists(copy));
  fs::remove_all(folder_);
  const auto labeler = loadModel("small");
  // In the middle 27 values of 0.01 · 100; at the edges the padding adds nothing.
  for (const float p : labeler->label(cv::Mat(8, 8, CV_8UC3, cv::Scalar::all(100))))
    EXPECT_NEAR(p, 1 / (1 + std::exp(-27.0F)), 1e-6);
}

TEST_F(ModelFolder, SaysWhatIsMissingAndLeavesNothingBehind) {
  writeDetector();
  fs::remove(folder_ / "shard1");
  EXPECT_THAT([&] { ConvertedModel(folder_).folder(); }, FailsWith(ErrorCode::fileNotFound));
  EXPECT_FALSE(fs::exists(fs::temp_directory_path() / ("estancia-convert-" + std::to_string(getpid()))));
  writeFile(folder_ / "model.toml", test::modelToml("../model.json", 8));
  EXPECT_THROW(ConvertedModel(folder_).folder(), Error);
}

}  // namespace
}  // namespace estancia::convert
