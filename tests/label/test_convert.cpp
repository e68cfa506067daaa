// Networks written as ONNX files.
#include "estancia/label/convert.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include "estancia/label/model.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::errorOf;
using test::readFile;
using test::writeFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
namespace fs = std::filesystem;

class Convert : public testing::Test {
 protected:
  std::string refusal(const std::string& name, const std::string& bytes) {
    writeFile(scratch_ / name, bytes);
    return errorOf([&] { convertToOnnx(specOfFile(scratch_ / name), target_); });
  }

  test::ScratchFolder scratch_;
  const fs::path target_ = scratch_ / "out.onnx";
};

TEST_F(Convert, TheDefaultNetworkRunsInBothEnginesAsItDidBefore) {
  ESTANCIA_NEEDS(test::findOnnxruntime(), "ONNX Runtime is missing; run script/bootstrap and build again");
  const auto folder = test::findFetched("models/inception-v3");
  ESTANCIA_NEEDS(folder, "the default network is missing; run script/bootstrap");
  const auto photos = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(photos, "the data set nyuv2_half is missing (ESTANCIA_DATA)");
  const OnnxSummary summary = convertToOnnx(specOfFile(*folder / "graph.lite"), target_);
  ASSERT_EQ(summary.inputs.size(), 1U);
  EXPECT_THAT(summary.inputs[0].second, ElementsAre(1, 3, 299, 299));
  ASSERT_EQ(summary.outputs.size(), 1U);
  EXPECT_THAT(summary.outputs[0].second, ElementsAre(1, 1001));
  EXPECT_EQ(summary.operatorSet, 10);

  ModelSpec spec = readModelSpec(*folder);
  const auto before = loadModel(spec, {"onnxruntime", 1});
  fs::copy_file(*folder / spec.labels, scratch_ / spec.labels);
  spec.folder = scratch_.path();
  spec.file = target_.filename();
  spec.sha256.clear();
  const cv::Mat image = test::photographs(*photos, 1)[0];
  const auto words = before->label(image);
  EXPECT_EQ(loadModel(spec, {"onnxruntime", 1})->label(image), words);
  const auto others = loadModel(spec, {"opencv", 1})->label(image);
  for (std::size_t i = 0; i < words.size(); ++i) ASSERT_NEAR(others[i], words[i], 1e-4);
}

TEST_F(Convert, AnOnnxFileIsOnlyChecked) {
  const std::string good = test::smallOnnx(8, 4);
  EXPECT_EQ(refusal("small.onnx", good), "");
  EXPECT_EQ(readFile(target_), good);
}

TEST_F(Convert, ReplacesNoFileUnlessTold) {
  writeFile(target_, "precious");
  const std::string good = test::smallOnnx(8, 4);
  EXPECT_THAT(refusal("small.onnx", good), HasSubstr("--overwrite"));
  EXPECT_EQ(readFile(target_), "precious");
  convertToOnnx(specOfFile(scratch_ / "small.onnx"), target_, true);
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
  EXPECT_THAT(refusal("unknown.onnx", test::smallOnnx(8, 4, unknown)), HasSubstr("FancyPool"));
  EXPECT_THAT(refusal("shapes.onnx", test::smallOnnx(8, 4, contradiction)), HasSubstr("no sound ONNX"));
  EXPECT_THAT(refusal("dangling.onnx", test::smallOnnx(8, 4, dangling)), HasSubstr("nowhere"));
  EXPECT_THAT(refusal("cut.onnx", test::smallOnnx(8, 4).substr(0, 50)), HasSubstr("cut.onnx"));
  EXPECT_THAT(refusal("net.tflite", "not one"), HasSubstr("TFL3"));
  EXPECT_THAT(refusal("net.caffemodel", "x"), AllOf(HasSubstr("net.caffemodel"), HasSubstr(".tflite")));
  EXPECT_FALSE(fs::exists(target_));
}

TEST_F(Convert, SaysWhenAFileIsMissingOrCannotBeWritten) {
  EXPECT_THAT(errorOf([&] { convertToOnnx(specOfFile(scratch_ / "none.tflite"), target_); }),
              HasSubstr("none.tflite is missing"));
  writeFile(scratch_ / "small.onnx", test::smallOnnx(8, 4));
  EXPECT_THAT(
      errorOf([&] { convertToOnnx(specOfFile(scratch_ / "small.onnx"), scratch_ / "no folder/x.onnx"); }),
      HasSubstr("no folder/x.onnx"));
}

}  // namespace
}  // namespace estancia
