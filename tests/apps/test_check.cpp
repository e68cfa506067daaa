// estancia check on a recording of a made-up room, as files.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "check/recorded_room.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::IsEmpty;

class CheckCommand : public testing::Test {
 protected:
  void SetUp() override {
    for (std::size_t i = 0; i < room_.size(); ++i) {
      cv::Mat millimeters;
      room_.depth(i).convertTo(millimeters, CV_16U, 1000);
      const std::string name = fmt::format("{:.6f}.png", *room_.frame(i).timestamp);
      writeFile(folder_ / ("rgb/" + name), encoded(".png", room_.image(i)));
      writeFile(folder_ / ("depth/" + name), encoded(".png", millimeters));
    }
    writeFile(folder_ / "intrinsics.txt", "140 140 79.5 59.5\n");
    writePoses([](const cv::Affine3d& t) { return t; });
  }

  void writePoses(const std::function<cv::Affine3d(cv::Affine3d)>& change) {
    std::vector<TrajectoryPoint> points;
    for (std::size_t i = 0; i < room_.size(); ++i)
      points.push_back({room_.frame(i).timestamp, poseOf(change(rigidOf(*room_.frame(i).pose)))});
    writeTrajectory(points, folder_ / "poses.txt");
  }

  CommandResult check(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"check", folder_.path().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  /// The names of what is not fine.
  static std::vector<std::string> faults(const CommandResult& result) {
    std::vector<std::string> names;
    const json report = json::parse(result.out);
    for (const json& finding : report["findings"])
      if (finding["severity"] != "fine") names.push_back(finding["name"]);
    EXPECT_EQ(report["problems"].get<std::size_t>() + report["warnings"].get<std::size_t>(), names.size());
    EXPECT_EQ(result.exitCode, report["problems"] > 0 ? 1 : 0) << result.out;
    return names;
  }

  const RecordedRoom room_{40};
  ScratchFolder folder_;
};

TEST_F(CheckCommand, IsContentWithASoundRecordingAndTellsOfInvertedPoses) {
  const auto result = check({"--json"});
  EXPECT_THAT(faults(result), IsEmpty());
  EXPECT_EQ(json::parse(result.out)["frames"], 40);
  writePoses([](const cv::Affine3d& t) { return t.inv(); });
  EXPECT_THAT(faults(check({"--json"})), ElementsAre("pose-inverted"));
}

TEST_F(CheckCommand, TakesOptionsOfDepthAndCamera) {
  EXPECT_THAT(faults(check({"--json", "--depth-scale", "200"})), ElementsAre("depth-scale"));
  writeFile(folder_ / "large.yaml",
            "image_width: 320\nimage_height: 240\nK: [280, 0, 159.5, 0, 280, 119.5, 0, 0, 1]\n");
  EXPECT_THAT(faults(check({"--json", "--intrinsics", folder_ / "large.yaml"})), IsEmpty());
  writeFile(folder_ / "large.txt", "280 280 159.5 119.5\n");
  EXPECT_THAT(faults(check({"--json", "--intrinsics", folder_ / "large.txt"})), ElementsAre("camera-center"));
}

TEST_F(CheckCommand, RefusesWhatItCannotCheck) {
  writeFile(folder_ / "words.csv", "image,cat\na.png,1\n");
  EXPECT_THAT(run({"check", folder_ / "words.csv"}), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(run({"check", folder_ / "nowhere"}), FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT(check({"--depth-scale", "-1"}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(check({"--max-frames", "0"}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(check({"--intrinsics", folder_ / "nowhere.txt"}), FailsWith(ErrorCode::fileNotFound));
}

}  // namespace
}  // namespace estancia::test
