// Labels paid for once: label files, the cache, several models, through the command.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

class Labeling : public testing::Test {
 protected:
  void SetUp() override {
    setenv("ESTANCIA_CACHE", (scratch_ / "cache").c_str(), 1);
    writeSmallModel(model_);
    fs::create_directories(images_);
    cv::RNG random(3);
    for (int i = 0; i < 24; ++i) {
      cv::Mat image(48, 64, CV_8UC3, cv::Scalar(i / 6 * 60, 230 - i / 6 * 60, 20 + i / 6 * 50));
      cv::Mat noise(image.size(), CV_8UC3);
      random.fill(noise, cv::RNG::UNIFORM, 0, 8);
      cv::imwrite(fs::path(images_) / ("frame" + std::to_string(10 + i) + ".png"), image + noise);
    }
  }
  void TearDown() override { unsetenv("ESTANCIA_CACHE"); }

  json label(const std::string& sequence, const std::string& file, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"label", sequence, "-o", file, "--json"};
    if (fs::is_directory(sequence)) arguments.insert(arguments.end(), {"--model", model_});
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const std::string model_ = scratch_ / "model";
  const std::string images_ = scratch_ / "images";
};

TEST_F(Labeling, PrintsTheBestWordsOfAnImage) {
  const std::string image = fs::path(images_) / "frame10.png";
  const auto text = run({"label", image, "--model", model_, "--words", "2"});
  EXPECT_EQ(text.exitCode, 0) << text.err;
  EXPECT_EQ(std::ranges::count(text.out, '\n'), 3) << text.out;
  EXPECT_TRUE(text.out.starts_with("frame10.png:\n  0.")) << text.out;
  const auto shown = json::parse(run({"label", image, "--model", model_, "--json"}).out);
  EXPECT_EQ(shown["image"], "frame10.png");
  EXPECT_GE(shown["labels"][0]["probability"], shown["labels"][1]["probability"]);
  const auto all = run({"label", images_, "--model", model_, "--words", "1"});
  EXPECT_EQ(std::ranges::count(all.out, '\n'), 24) << "a line an image";
  EXPECT_THAT(run({"label", image, "--words", "2", "-o", scratch_ / "a.labels"}),
              FailsWith(ErrorCode::invalidOption));
}

TEST_F(Labeling, ASecondRunLabelsNothing) {
  EXPECT_EQ(label(images_, scratch_ / "a.labels")["remembered"], 0);
  EXPECT_EQ(label(images_, scratch_ / "b.labels")["remembered"], 24);
  EXPECT_EQ(readFile(scratch_ / "a.labels"), readFile(scratch_ / "b.labels")) << "to the last bit";
  EXPECT_EQ(label(images_, scratch_ / "c.labels", {"--no-cache"})["remembered"], 0);

  const auto shown = json::parse(run({"cache", "show", "--json"}).out);
  EXPECT_EQ(shown["models"][0]["frames"], 24);
  EXPECT_GT(json::parse(run({"cache", "clear", "--json"}).out)["freed"], 24 * 4 * 4);
  EXPECT_EQ(label(images_, scratch_ / "d.labels")["remembered"], 0);
}

TEST_F(Labeling, ALabelFileStandsForItsImagesInEveryCommand) {
  const std::string words = scratch_ / "words.labels", fromWords = scratch_ / "w.estancia",
                    fromImages = scratch_ / "i.estancia";
  label(images_, words);
  ASSERT_EQ(run({"map", words, "-o", fromWords, "--distance", "l2"}).exitCode, 0);
  ASSERT_EQ(run({"map", images_, "-o", fromImages, "--model", model_, "--distance", "l2"}).exitCode, 0);
  EXPECT_EQ(run({"export", fromWords, "--format", "json"}).out,
            run({"export", fromImages, "--format", "json"}).out);
  const auto byWords = run({"localize", fromImages, words});
  const auto byImages = run({"localize", fromImages, images_, "--model", model_});
  EXPECT_EQ(byWords.exitCode, 0) << byWords.err;
  EXPECT_EQ(byWords.out, byImages.out);
  EXPECT_EQ(run({"evaluate", fromWords, words}).exitCode, 0);
  EXPECT_EQ(run({"report", fromWords, "-o", scratch_ / "w.html"}).exitCode, 0) << "without images";
  EXPECT_THAT(run({"map", words, "-o", scratch_ / "x.estancia", "--model", model_}),
              FailsWith(ErrorCode::invalidOption));
}

TEST_F(Labeling, CsvAndNpyGoOutAndComeBack) {
  label(images_, scratch_ / "words.labels");
  for (const std::string kind : {"csv", "npy"}) {
    const std::string out = scratch_ / ("words." + kind);
    const json written = label(scratch_ / "words.labels", out);
    EXPECT_EQ(written["frames"], 24);
    EXPECT_EQ(written["remembered"], 0) << "a recording is no memory of ours";
    ASSERT_EQ(run({"map", out, "-o", scratch_ / (kind + ".estancia"), "--distance", "l2"}).exitCode, 0);
    EXPECT_EQ(label(out, scratch_ / (kind + ".labels"))["words"], 4);
    // A second recording of the same words is found in the map of the first.
    EXPECT_EQ(run({"localize", scratch_ / (kind + ".estancia"), out}).exitCode, 0);
  }
  EXPECT_THAT(run({"label", images_, "-o", scratch_ / "words.txt", "--model", model_}),
              FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(run({"label", images_, "-o", scratch_ / "words.labels", "--model", model_}),
              FailsWith(ErrorCode::fileExists));
}

}  // namespace
}  // namespace estancia::test
