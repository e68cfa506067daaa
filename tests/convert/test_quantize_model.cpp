// `models quantize`: the network of a folder gets one of 8 bits beside it, or all stays as it was.
// SPDX-License-Identifier: Apache-2.0
#include "convert/quantize_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "convert/quantization_plan.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia::convert {
namespace {
namespace fs = std::filesystem;

using test::FailsWith;
using test::readFile;
using test::writeFile;

/// The small network behind convolutions that change nothing: those that stay float, and one of 8 bits.
void deepen(onnx::GraphProto& graph) {
  auto* identity = graph.add_initializer();
  identity->set_name("identity");
  identity->set_data_type(onnx::TensorProto::FLOAT);
  for (const int size : {3, 3, 1, 1}) identity->add_dims(size);
  for (int i = 0; i < 9; ++i) identity->add_float_data(i % 4 == 0 ? 1 : 0);
  const google::protobuf::RepeatedPtrField<onnx::NodeProto> small = graph.node();
  graph.clear_node();
  std::string last = "input";
  for (int k = 0; k <= floatLayers; ++k) {
    auto* node = graph.add_node();
    node->set_op_type("Conv");
    node->add_input(last);
    node->add_input("identity");
    node->add_output(last = "same" + std::to_string(k));
  }
  for (const auto& node : small) *graph.add_node() = node;
  graph.mutable_node(floatLayers + 1)->set_input(0, last);
}

class QuantizeModel : public testing::Test {
 protected:
  void SetUp() override {
    ESTANCIA_NEEDS(test::findOnnxruntime(), "ONNX Runtime is missing; run script/bootstrap and build again");
    test::writeSmallModel(model());
    writeFile(model() / "small.onnx", test::smallOnnx(8, 4, deepen));
    for (int i = 0; i < 5; ++i) {
      cv::Mat image(20, 30, CV_8UC3);
      cv::RNG(static_cast<std::uint64_t>(i) + 1).fill(image, cv::RNG::UNIFORM, 0, 255);
      fs::create_directories(photos());
      cv::imwrite((photos() / (std::to_string(i) + ".png")).string(), image);
    }
  }
  fs::path model() const { return scratch_ / "model"; }
  fs::path photos() const { return scratch_ / "photos"; }
  QuantizedModel quantize(const QuantizeOptions& options = {}) {
    return quantizeModel(model(), *openSequence(photos()), options);
  }
  LexicalDescriptor label(Precision precision) {
    LabelerOptions options;
    options.precision = precision;
    return loadModel(model().string(), options)->label(openSequence(photos())->image(3));
  }

  test::ScratchFolder scratch_;
};

TEST_F(QuantizeModel, PutsANetworkOf8BitsBesideTheOther) {
  const LexicalDescriptor before = label(Precision::float32);
  const QuantizedModel made = quantize();
  EXPECT_EQ(made.file, model() / "small-int8.onnx");
  EXPECT_EQ(made.sha256, sha256OfFile(made.file));
  EXPECT_EQ(made.images, 5U);
  EXPECT_GT(made.values, 1U);
  EXPECT_TRUE(made.problems.empty());
  const ModelSpec spec = readModelSpec(model());
  EXPECT_EQ(spec.int8, "small-int8.onnx");
  EXPECT_EQ(spec.sha256.at("small-int8.onnx"), made.sha256);
  EXPECT_EQ(label(Precision::float32), before);
  const LexicalDescriptor bytes = label(Precision::int8);
  EXPECT_NE(bytes, before);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(bytes[i], before[i], 0.02);
}

TEST_F(QuantizeModel, RangesMakeTheSameNetworkAgain) {
  QuantizeOptions options;
  options.ranges = scratch_ / "ranges.txt";
  const QuantizedModel made = quantize(options);
  writeQuantized(model() / "small.onnx", options.ranges, scratch_ / "again.onnx");
  EXPECT_EQ(sha256OfFile(scratch_ / "again.onnx"), made.sha256);
  options.overwrite = true;
  options.threads = 2;
  EXPECT_EQ(quantize(options).sha256, made.sha256);
  options.calibration.light = 0;
  EXPECT_NE(quantize(options).sha256, made.sha256);
  EXPECT_EQ(readModelSpec(model()).sha256.size(), 1U);  // the old digest went
}

TEST_F(QuantizeModel, ChangesNothingWhenItFails) {
  const std::string toml = readFile(model() / "model.toml");
  for (int i = 0; i < 5; ++i) writeFile(photos() / (std::to_string(i) + ".png"), "no image");
  EXPECT_THROW(quantize(), Error);
  EXPECT_EQ(readFile(model() / "model.toml"), toml);
  writeFile(model() / "small.onnx", test::smallOnnx(8, 4));
  EXPECT_THAT([&] { quantize(); }, FailsWith(ErrorCode::unsupportedFile));  // not deep enough
  writeFile(model() / "small.onnx", "no network");
  EXPECT_THAT([&] { quantize(); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_FALSE(fs::exists(model() / "small-int8.onnx"));
  EXPECT_FALSE(fs::exists(model() / "small-int8.new.onnx"));
}

TEST_F(QuantizeModel, ReplacesOnlyWhenTold) {
  QuantizeOptions kept;
  kept.ranges = scratch_ / "ranges.txt";
  writeFile(kept.ranges, "precious");
  EXPECT_THAT([&] { quantize(kept); }, FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(readFile(kept.ranges), "precious");
  quantize();
  EXPECT_THAT([&] { quantize(); }, FailsWith(ErrorCode::fileExists));
  QuantizeOptions options;
  options.overwrite = true;
  EXPECT_NO_THROW(quantize(options));
}

TEST(WithInt8, KeepsTheRestOfTheFile) {
  const std::string digest(64, 'a'), old(64, 'b');
  const std::string toml = "# mine\nname = \"n\"\nfile = \"n.onnx\"  # the network\nlabels = \"l.txt\"\n";
  EXPECT_EQ(withInt8(toml, "n-int8.onnx", digest, "model.toml"),
            "# mine\nname = \"n\"\nfile = \"n.onnx\"  # the network\nint8 = \"n-int8.onnx\"\nlabels = "
            "\"l.txt\"\n\n[sha256]\n\"n-int8.onnx\" = \"" +
                digest + "\"\n");
  const std::string twice =
      withInt8(withInt8(toml, "n-int8.onnx", old, "model.toml"), "n-int8.onnx", digest, "m");
  EXPECT_EQ(twice, withInt8(toml, "n-int8.onnx", digest, "model.toml"));
  EXPECT_THAT([&] { withInt8("name = \"n\"\n", "n-int8.onnx", digest, "model.toml"); },
              FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia::convert
