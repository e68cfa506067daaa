// Words of one's own: an encoder of images and the embeddings of texts.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <cmath>
#include <limits>

#include "estancia/files/npy.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/network_labeler.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::writeFile;

std::string npy(const std::vector<std::vector<float>>& rows) {
  DescriptorMatrix matrix(rows.at(0).size());
  for (const auto& row : rows) matrix.append(row);
  return io::npyBytes(matrix);
}

/// An encoder whose embedding of an image is its mean blue, green and red.
std::string colorEncoder() {
  return test::smallOnnx(8, 3, [](onnx::GraphProto& g) {
    g.mutable_node()->RemoveLast();
    g.mutable_output(0)->set_name("row");
    for (int i = 0; i < 9; ++i) g.mutable_initializer(0)->set_float_data(i, i % 4 == 0 ? 1.0F : 0.0F);
  });
}

class Clip : public testing::Test {
 protected:
  Clip() {
    writeFile(scratch_ / "small.onnx", colorEncoder());
    writeFile(scratch_ / "labels.txt", "blue\ngreen\n");
    writeFile(scratch_ / "words.npy", npy({{7, 0, 0}, {0, 0.5F, 0}}));  // lengths do not matter
    settings("logit_scale = 10");
  }
  void settings(const std::string& more) {
    writeFile(scratch_ / "model.toml",
              test::modelToml("small.onnx", 8, "embeddings = \"words.npy\"\n" + more));
  }
  std::unique_ptr<Labeler> open() const { return loadModel(scratch_.path().string()); }
  test::Caught refusal() const {
    return test::caught([this] { open(); });
  }

  test::ScratchFolder scratch_;
};

TEST_F(Clip, GivesTheSoftmaxOfTheScaledCosinesInEveryEngine) {
  for (const std::string& engine : engines()) {
    SCOPED_TRACE(engine);
    LabelerOptions options;
    options.engine = engine;
    const auto labeler = loadModel(scratch_.path().string(), options);
    const auto words = labeler->label(cv::Mat(8, 8, CV_8UC3, cv::Scalar(30, 40, 0)));
    ASSERT_EQ(words.size(), 2U);
    const double blue = std::exp(10 * 0.6), green = std::exp(10 * 0.8);  // cosines 30/50 and 40/50
    EXPECT_NEAR(words[0], blue / (blue + green), 1e-5);
    EXPECT_NEAR(words[1], green / (blue + green), 1e-5);
    EXPECT_EQ(labeler->vocabulary()[1], "green");
  }
}

TEST_F(Clip, HasTheScaleOfClipUnlessToldOtherwise) {
  settings("");
  EXPECT_EQ(readModelSpec(scratch_.path()).logitScale, 100);
  const auto words = open()->label(cv::Mat(8, 8, CV_8UC3, cv::Scalar(30, 40, 0)));
  EXPECT_NEAR(words[0], 1 / (1 + std::exp(20.0)), 1e-8);
}

TEST_F(Clip, IsAnotherModelWithOtherWordsOrAnotherScale) {
  const std::string first = open()->identity();
  settings("logit_scale = 11");
  const std::string scaled = open()->identity();
  EXPECT_NE(scaled, first);
  writeFile(scratch_ / "words.npy", npy({{7, 0, 0}, {0, 0, 1}}));
  EXPECT_NE(open()->identity(), scaled);
}

TEST_F(Clip, IsAddedWithItsEmbeddings) {
  setenv("ESTANCIA_HOME", (scratch_ / "home").c_str(), 1);
  const auto check = addModel(scratch_.path());
  EXPECT_EQ(loadModel("small")->identity(), check.identity);
  unsetenv("ESTANCIA_HOME");
}

TEST_F(Clip, RefusesEmbeddingsThatItCannotUse) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::pair<std::string, ErrorCode> cases[] = {
      {npy({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), ErrorCode::mismatch},
      {npy({{1, 0, 0, 0}, {0, 1, 0, 0}}), ErrorCode::mismatch},
      {npy({{1, 0, 0}, {0, 0, 0}}), ErrorCode::malformedFile},
      {npy({{1, nan, 0}, {0, 1, 0}}), ErrorCode::malformedFile},
      {npy({{1, 0, 0}, {0, 1, 0}}).substr(0, 100), ErrorCode::truncatedFile}};
  for (const auto& [words, code] : cases) {
    writeFile(scratch_ / "words.npy", words);
    EXPECT_THAT(refusal(), FailsWith(code));
  }
  settings("logit_scale = 0");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile));
  settings("reduce = \"max\"");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::invalidInput));
}

TEST_F(Clip, SaysWhenAnImageHasNoEmbedding) {
  const auto labeler = open();
  EXPECT_THAT([&] { labeler->label(cv::Mat(8, 8, CV_8UC3, cv::Scalar::all(0))); },
              FailsWith(ErrorCode::labelerFailure));
}

}  // namespace
}  // namespace estancia
