// Model folders with TensorFlow networks, installed as ONNX models.
// SPDX-License-Identifier: Apache-2.0
#include "convert/model_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "convert/tfjs_builder.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/labelers/model.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia::convert {
namespace {
namespace fs = std::filesystem;

using test::FailsWith;
using test::readFile;
using test::writeFile;

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
