// Networks written as ONNX files.
// SPDX-License-Identifier: Apache-2.0
#include "convert/to_onnx.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include "estancia/core/digest.hpp"
#include "estancia/labelers/model_spec.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia::convert {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::ElementsAre;
namespace fs = std::filesystem;

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
  EXPECT_EQ(readFile(target_), good);
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

}  // namespace
}  // namespace estancia::convert
