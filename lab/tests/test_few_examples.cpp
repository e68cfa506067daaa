// Rooms by a few images of each, by their names, and by both, on labels that a person gave.
// SPDX-License-Identifier: Apache-2.0
#include "words/few_examples.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::HasSubstr;

/// Ten images of each of two rooms, in which different things stand; every fifth shows the other room's.
class FewExamples : public testing::Test {
 protected:
  void SetUp() override {
    const std::vector<std::vector<std::string>> things{{"stove", "toaster"}, {"bathtub", "towel"}};
    std::string truth = "image,room\n", labels;
    fs::create_directory(scratch_ / "home");
    for (std::size_t i = 0; i < 20; ++i) {
      const std::string image = fmt::format("{:02}.png", i);
      cv::imwrite((scratch_ / "home" / image).string(), cv::Mat(8, 8, CV_8UC3, cv::Scalar(10.0 * i, 0, 0)));
      const std::size_t room = i / 10, shown = i % 5 == 0 ? 1 - room : room;
      truth += fmt::format("{},{}\n", image, room == 0 ? "kitchen" : "bath_room");
      labels += fmt::format("{},{}\n", image, things[shown][i % 2]);
    }
    writeFile(scratch_ / "home/rooms.csv", truth);
    writeFile(scratch_ / "person/labels.txt", "stove\ntoaster\nbathtub\ntowel\ntabby\n");
    writeFile(scratch_ / "person/h.csv", labels);
    writeFile(scratch_ / "person/model.toml",
              "name = \"person\"\ntype = \"human\"\nfile = \"h.csv\"\nlabels = \"labels.txt\"\n");
  }

  Findings run(const std::string& text) {
    writeFile(scratch_ / "few.toml", "type = \"few-examples\"\n" + text);
    return runExperiment({scratch_ / "few.toml"},
                         {scratch_ / "out", {(scratch_ / "person").string()}, {"", 1}, nullptr}, progress_);
  }

  /// Value in a row of results.csv, by its first cells.
  double resultOf(const std::string& row) {
    const std::string csv = readFile(scratch_ / "out/results.csv");
    const auto at = csv.find("\nperson,home," + row + ",");
    if (at == std::string::npos) throw std::runtime_error("no row " + row + " in " + csv);
    return std::stod(csv.substr(at + row.size() + 14));
  }

  const std::string rooms_ = "rooms = [\"kitchen\", \"bath_room\"]\n",
                    data_ = "[[data]]\nname = \"home\"\npath = \"home\"\n";
  test::ScratchFolder scratch_;
  Progress progress_;
};

TEST_F(FewExamples, AreTestedOnTheImagesThatWereNotDrawn) {
  const Findings findings = run(rooms_ + "train = \"home\"\nimages = [2, 8]\ndraws = 3\n" + data_);
  EXPECT_THAT(findings.summary, testing::StartsWith("2 images of each room name "));
  // Most images that are left show what stands in their room.
  EXPECT_GT(resultOf("2,names"), 0.7);
  EXPECT_GE(resultOf("2,both"), resultOf("2,examples")) << "two images cannot show all things";
  EXPECT_GE(resultOf("8,both"), 0.5);
}

TEST_F(FewExamples, TellWhatIsWrong) {
  EXPECT_THAT([&] { run(rooms_ + "train = \"away\"\n" + data_); },
              FailsWith(ErrorCode::malformedFile, "few.toml", "away"));
  EXPECT_THAT([&] { run(rooms_ + "train = \"home\"\nimages = [1]\n" + data_); },
              FailsWith(ErrorCode::malformedFile, "few.toml:4", "images"));
  EXPECT_THAT([&] { run(rooms_ + "train = \"home\"\nimages = [10]\n" + data_); },
              FailsWith(ErrorCode::insufficientData, "10 images of bath_room"));
  EXPECT_THAT([&] { run("train = \"home\"\nrooms = [\"kitchen\", \"attic\"]\n" + data_); },
              FailsWith(ErrorCode::insufficientData, "attic"));
}

}  // namespace
}  // namespace estancia::experiments
