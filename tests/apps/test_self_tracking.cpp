// `estancia map` of drives with depth and without poses, as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/readers/open_sequence.hpp"
#include "estancia/stats/trajectory_error.hpp"
#include "estancia/world_file/world_map.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The first frames of a rendered drive, without its poses.
class UnposedDrive : public testing::Test {
 protected:
  void SetUp() override {
    data_ = findData("home_a");
    ESTANCIA_NEEDS(data_, "the rendered home is not here");
    writeSmallModel(scratch_ / "model");
    fs::create_directories(drive_);
    fs::create_symlink(*data_ / "slow/camera-intrinsics.txt", drive_ / "camera-intrinsics.txt");
    for (const char* folder : {"rgb", "depth"}) fs::create_directories(drive_ / folder);
  }
  void showFramesUpTo(int end) {
    for (int i = 0; i < end; ++i)
      for (const auto& [folder, ending] : {std::pair("rgb", "jpg"), std::pair("depth", "png")}) {
        const std::string name = fmt::format("{}/{:06}.{}", folder, i, ending);
        ASSERT_TRUE(fs::exists(*data_ / "slow" / name)) << name;
        if (!fs::exists(drive_ / name)) fs::create_symlink(*data_ / "slow" / name, drive_ / name);
      }
  }
  CommandResult map(const std::string& file, std::vector<std::string> more = {}) const {
    more.insert(more.begin(),
                {"map", drive_, "-o", scratch_ / file, "--model", scratch_ / "model", "--json"});
    return run(more);
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const fs::path drive_ = scratch_ / "drive";
  std::optional<fs::path> data_;
};

TEST_F(UnposedDrive, IsTrackedInThePassThatMapsItAndGoesOnAsIfItHadNotStopped) {
  for (const int end : {1, 13, 60}) {
    showFramesUpTo(end);
    const auto part = end == 1 ? map("broken.estancia") : map("broken.estancia", {"--continue"});
    ASSERT_EQ(part.exitCode, 0) << part.err;
  }
  const auto mapped = map("whole.estancia");
  ASSERT_EQ(mapped.exitCode, 0) << mapped.err;
  const json odometry = json::parse(mapped.out)["odometry"];
  EXPECT_EQ(odometry["placed"], 60);
  EXPECT_GT(odometry["keyframes"], 2);
  EXPECT_FALSE(odometry.contains("lost"));
  for (const char* format : {"json", "rooms", "spark-dsg"})
    EXPECT_EQ(run({"export", scratch_ / "broken.estancia", "--format", format}).out,
              run({"export", scratch_ / "whole.estancia", "--format", format}).out)
        << format;
  const WorldMap world = readWorld(scratch_ / "whole.estancia");
  EXPECT_FALSE(world.areas.empty());
  EXPECT_FALSE(world.objects.empty());
  const auto truth = openSequence(*data_ / "slow");
  std::vector<Pose> found, true_;
  for (std::size_t i = 0; i < world.places.frames.size(); ++i) {
    found.push_back(world.places.frames[i].pose.value());
    true_.push_back(truth->frame(i).pose.value());
  }
  EXPECT_LT(absoluteTrajectoryError(found, true_).rmse, 0.01);
}

}  // namespace
}  // namespace estancia::test
