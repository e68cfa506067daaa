// `estancia filter` as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/files/cloud_file.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;

class Filter : public testing::Test {
 protected:
  void SetUp() override {
    PointCloud cloud;
    cloud.points.reserve(10000);
    for (int i = 0; i < 10000; ++i) {
      const int row = i / 100;
      cloud.points.emplace_back(0.01F * static_cast<float>(i % 100), 0.01F * static_cast<float>(row), 1.F);
    }
    cloud.width = 10000;
    cloud.height = 1;
    writeCloud(cloud, plane_);
  }
  std::string at(const std::string& name) const { return scratch_ / name; }
  json filter(std::vector<std::string> more) const {
    more.insert(more.begin(), "filter");
    more.emplace_back("--json");
    const CommandResult result = run(more);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return result.exitCode == 0 ? json::parse(result.out) : json();
  }
  void refuses(std::vector<std::string> more, ErrorCode code) const {
    more.insert(more.begin(), "filter");
    EXPECT_THAT(run(more), FailsWith(code));
  }

  ScratchFolder scratch_;
  const std::string plane_ = scratch_ / "plane.pcd";
};

TEST_F(Filter, NeuronsTheirGraphAndNormals) {
  const json told = filter({plane_, "-o", at("out.ply"), "--points", "200", "--graph", at("graph.ply"),
                            "--normals", "--noise", "0.003", "--render", at("out.png")});
  EXPECT_EQ(cv::imread(at("out.png")).cols, 1280);
  EXPECT_EQ(told["points_in"], 10000);
  EXPECT_EQ(told["points_out"], 200);
  EXPECT_EQ(told["stopped_by"], "neurons");
  EXPECT_NEAR(told["noise"].get<double>(), 0.003, 0.0004);
  const PointCloud out = readCloud(at("out.ply")), graph = readCloud(at("graph.ply"));
  EXPECT_EQ(out.points.size(), 200U);
  EXPECT_EQ(graph.points, out.points);
  std::size_t facing = 0;
  for (const cv::Point3f& n : out.normals) facing += n.z < -0.95F ? 1 : 0;
  EXPECT_GT(facing, 195U);
  EXPECT_NE(readFile(at("graph.ply")).find(fmt::format("element edge {}\n", told["edges"].get<int>())),
            std::string::npos);
}

TEST_F(Filter, ADepthImageBecomesACloud) {
  cv::imwrite(at("depth.png"), cv::Mat(60, 80, CV_16U, cv::Scalar(1500)));
  refuses({at("depth.png"), "-o", at("a.ply"), "--filter", "none"}, ErrorCode::insufficientData);
  writeFile(at("mine.txt"), "100 100 39.5 29.5");
  const json told =
      filter({at("depth.png"), "-o", at("a.pcd"), "--filter", "none", "--intrinsics", at("mine.txt")});
  EXPECT_EQ(told["points_out"], 4800);
  EXPECT_TRUE(readCloud(at("a.pcd")).organized());
}

TEST_F(Filter, ReplacesCloudsAloneAndOnlyWithOverwrite) {
  const auto voxels = [](std::vector<std::string> words) {
    words.insert(words.end(), {"--filter", "voxel", "--leaf", "0.2"});
    return words;
  };
  writeFile(at("notes.pcd"), "not a cloud");
  filter(voxels({plane_, "-o", at("out.pcd")}));
  const std::string before = readFile(plane_), photo = "\x89PNG\r\n a photograph";
  refuses(voxels({plane_, "-o", at("out.pcd")}), ErrorCode::fileExists);
  filter(voxels({plane_, "-o", at("out.pcd"), "--overwrite"}));
  refuses(voxels({plane_, "-o", plane_, "--overwrite"}), ErrorCode::fileExists);
  refuses(voxels({plane_, "-o", at("notes.pcd"), "--overwrite"}), ErrorCode::fileExists);
  writeFile(at("photo.png"), photo);
  refuses({plane_, "-o", at("new.ply"), "--render", at("photo.png")}, ErrorCode::fileExists);
  EXPECT_EQ(readFile(at("photo.png")), photo);
  refuses({plane_, "-o", at("new.ply"), "--render", plane_}, ErrorCode::fileExists);
  EXPECT_EQ(readFile(plane_), before) << "inputs are not replaced";
  EXPECT_FALSE(std::filesystem::exists(at("new.ply")));
}

TEST_F(Filter, RefusesWhatItCannotUse) {
  writeFile(at("holes.ply"),
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
            "property float z\nend_header\nnan nan nan\nnan 1 1\n");
  const std::string out = at("out.ply"), again = at("../" + scratch_.path().filename().string() + "/out.ply");
  const std::vector<std::pair<std::vector<std::string>, ErrorCode>> refused{
      {{plane_, "-o", at("none/out.pcd")}, ErrorCode::fileNotFound},
      {{plane_, "-o", at("out.xyz")}, ErrorCode::unsupportedFile},
      {{plane_, "-o", out, "--graph", out}, ErrorCode::invalidOption},
      {{plane_, "-o", out, "--graph", again}, ErrorCode::invalidOption},
      {{plane_, "-o", out, "--graph", at("g.pcd")}, ErrorCode::unsupportedFile},
      {{plane_, "-o", out, "--filter", "gng", "--leaf", "9"}, ErrorCode::invalidOption},
      {{plane_, "-o", out, "--filter", "voxel", "--leaf", "0.2", "--points", "9"}, ErrorCode::invalidOption},
      {{plane_, "-o", out, "--normal-radius", "0.1"}, ErrorCode::invalidOption},
      {{plane_, "-o", out, "--filter", "sieve"}, ErrorCode::unknownName},
      {{plane_, "-o", out, "--normals", "--normal-radius", "1e-9"}, ErrorCode::invalidOption},
      {{at("holes.ply"), "-o", out}, ErrorCode::invalidInput},
      {{at("holes.ply"), "-o", out, "--filter", "none"}, ErrorCode::invalidInput}};
  for (const auto& [arguments, code] : refused) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    refuses(arguments, code);
  }
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace estancia::test
