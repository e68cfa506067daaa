// `estancia filter` as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/files/cloud_file.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

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
  template <class... Facts>
  void refuses(std::vector<std::string> more, ErrorCode code, Facts&&... facts) const {
    more.insert(more.begin(), "filter");
    EXPECT_THAT(run(more), FailsWith(code, std::forward<Facts>(facts)...));
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

TEST_F(Filter, VoxelsOfASizeOrForANumber) {
  EXPECT_EQ(filter({plane_, "-o", at("a.pcd"), "--filter", "voxel", "--leaf", "0.2"})["points_out"], 25);
  const json told = filter({plane_, "-o", at("b.pcd"), "--filter", "voxel", "--points", "400"});
  EXPECT_NEAR(told["points_out"].get<double>(), 400, 20);  // a grid over a grid: leaves come in steps
  EXPECT_GT(told["leaf"].get<double>(), 0.04);
  EXPECT_NEAR(told["resolution"].get<double>(), 0.01, 1e-6);
  EXPECT_EQ(readCloud(at("b.pcd")).points.size(), told["points_out"]);
}

TEST_F(Filter, NoiseIsSeeded) {
  filter({plane_, "-o", at("a.pcd"), "--filter", "none", "--noise", "0.01", "--seed", "4"});
  filter({plane_, "-o", at("b.pcd"), "--filter", "none", "--noise", "0.01", "--seed", "4"});
  filter({plane_, "-o", at("c.pcd"), "--filter", "none", "--noise", "0.01", "--seed", "5"});
  EXPECT_EQ(readFile(at("a.pcd")), readFile(at("b.pcd")));
  EXPECT_NE(readFile(at("a.pcd")), readFile(at("c.pcd")));
}

TEST_F(Filter, NoiseDropsTheNormalsThatItMakesWrong) {
  const auto none = [&](const std::string& in, const std::string& out, std::vector<std::string> more) {
    more.insert(more.begin(), {at(in), "-o", at(out), "--filter", "none"});
    filter(more);
    return readCloud(at(out)).normals.size();
  };
  EXPECT_EQ(none("plane.pcd", "normals.pcd", {"--normals"}), 10000U);
  EXPECT_EQ(none("normals.pcd", "kept.pcd", {}), 10000U);
  EXPECT_EQ(none("normals.pcd", "noisy.pcd", {"--noise", "0.01"}), 0U);
  EXPECT_EQ(none("normals.pcd", "new.pcd", {"--noise", "0.01", "--normals"}), 10000U);
}

TEST_F(Filter, NormalsLookWhereTheFileSaysThatTheSensorStood) {
  PointCloud cloud = readCloud(plane_);
  cloud.viewpoint = Pose{0.5, 0.5, 3};  // behind the plane
  writeCloud(cloud, at("behind.pcd"));
  filter({at("behind.pcd"), "-o", at("out.ply"), "--filter", "none", "--normals"});
  EXPECT_GT(readCloud(at("out.ply")).normals.at(5050).z, 0.99F);
}

TEST_F(Filter, ADepthImageBecomesACloud) {
  cv::imwrite(at("depth.png"), cv::Mat(60, 80, CV_16U, cv::Scalar(1500)));
  refuses({at("depth.png"), "-o", at("a.ply"), "--filter", "none"}, ErrorCode::insufficientData, "depth.png");
  writeFile(at("mine.txt"), "100 100 39.5 29.5");
  const json told =
      filter({at("depth.png"), "-o", at("a.pcd"), "--filter", "none", "--intrinsics", at("mine.txt")});
  EXPECT_EQ(told["points_out"], 4800);
  EXPECT_TRUE(readCloud(at("a.pcd")).organized());
}

TEST_F(Filter, TellsPeopleInTwoLines) {
  const CommandResult result =
      run({"filter", plane_, "-o", at("out.pcd"), "--filter", "voxel", "--leaf", "0.2"});
  EXPECT_EQ(result.exitCode, 0);
  EXPECT_EQ(std::ranges::count(result.out, '\n'), 2);
  EXPECT_THAT(result.out, HasSubstr("out.pcd: 25 of 10000 points; voxels of 0.2 m"));
}

TEST_F(Filter, PointsThatAreNotFiniteAreHolesOrLeftOut) {
  PointCloud cloud = readCloud(plane_);
  for (std::size_t i = 0; i < 1000; ++i) cloud.points[7 * i].y = NAN;
  cloud.width = cloud.height = 100;
  writeCloud(cloud, at("holes.pcd"));
  const json kept = filter({at("holes.pcd"), "-o", at("a.pcd"), "--filter", "none"});
  EXPECT_EQ(kept["points_in"], 10000);
  EXPECT_EQ(kept["points_out"], 9000);
  EXPECT_EQ(kept["holes"], 1000);
  EXPECT_EQ(readCloud(at("a.pcd")).points.size(), 10000U);
  const json left = filter({at("holes.pcd"), "-o", at("a.ply"), "--filter", "none"});
  EXPECT_EQ(left["points_out"], 9000);
  EXPECT_EQ(left["holes"], 0);
  EXPECT_EQ(readCloud(at("a.ply")).points.size(), 9000U);
}

TEST_F(Filter, ReplacesCloudsAloneAndOnlyWithOverwrite) {
  const auto voxels = [](std::vector<std::string> words) {
    words.insert(words.end(), {"--filter", "voxel", "--leaf", "0.2"});
    return words;
  };
  writeFile(at("notes.pcd"), "not a cloud");
  filter(voxels({plane_, "-o", at("out.pcd")}));
  const std::string before = readFile(plane_);
  refuses(voxels({plane_, "-o", at("out.pcd")}), ErrorCode::fileExists, "out.pcd", "--overwrite");
  filter(voxels({plane_, "-o", at("out.pcd"), "--overwrite"}));
  refuses(voxels({plane_, "-o", plane_, "--overwrite"}), ErrorCode::fileExists, "plane.pcd");
  EXPECT_EQ(readFile(plane_), before) << "inputs are not replaced";
  refuses(voxels({plane_, "-o", at("notes.pcd"), "--overwrite"}), ErrorCode::fileExists, "notes.pcd");
  refuses(voxels({plane_, "-o", at("none/out.pcd")}), ErrorCode::fileNotFound, "none");
  refuses(voxels({plane_, "-o", at("out.xyz")}), ErrorCode::unsupportedFile, "out.xyz");
  writeFile(at("photo.png"), "\x89PNG\r\n a photograph");
  refuses({plane_, "-o", at("new.ply"), "--render", at("photo.png")}, ErrorCode::fileExists, "photo.png");
  EXPECT_EQ(readFile(at("photo.png")), "\x89PNG\r\n a photograph");
  refuses({plane_, "-o", at("new.ply"), "--render", plane_}, ErrorCode::fileExists, "plane.pcd");
  EXPECT_EQ(readFile(plane_), before);
  EXPECT_FALSE(std::filesystem::exists(at("new.ply")));
}

TEST_F(Filter, TheGraphIsAPlyOfItsOwn) {
  const auto graph = [&](const std::string& file) {
    return std::vector<std::string>{plane_, "-o", at("new.ply"), "--graph", file};
  };
  refuses(graph(at("new.ply")), ErrorCode::invalidOption, "new.ply");
  refuses(graph(at("../" + scratch_.path().filename().string() + "/new.ply")), ErrorCode::invalidOption,
          "new.ply");
  refuses(graph(at("g.pcd")), ErrorCode::unsupportedFile, "g.pcd");
  EXPECT_FALSE(std::filesystem::exists(at("new.ply")));
}

TEST_F(Filter, OptionsThatTheMethodDoesNotUseAreRefused) {
  const auto refusesOption = [&](const std::string& method, const std::string& option) {
    refuses({plane_, "-o", at("out.ply"), "--filter", method, option, "9"}, ErrorCode::invalidOption, option,
            method);
  };
  refusesOption("gng", "--leaf");
  for (const std::string option : {"--quantization-error", "--max-seconds", "--graph"})
    refusesOption("voxel", option);
  refusesOption("none", "--points");
  refuses({plane_, "-o", at("out.ply"), "--filter", "voxel", "--leaf", "0.2", "--points", "9"},
          ErrorCode::invalidOption, "--leaf", "--points");
  refuses({plane_, "-o", at("out.ply"), "--normal-radius", "0.1"}, ErrorCode::invalidOption, "--normals");
  EXPECT_FALSE(std::filesystem::exists(at("out.ply")));
}

TEST_F(Filter, ParametersComeFromTheCommandOrAFile) {
  writeFile(at("p.toml"), "[filter]\nmethod = \"voxel\"\npoints = 400\n[recognition]\naccept = 0.5\n");
  const auto filtered = [&](const std::string& name, std::vector<std::string> more) {
    more.insert(more.begin(), {plane_, "-o", at(name), "--config", at("p.toml")});
    return filter(more);
  };
  const json byFile = filtered("file.pcd", {});
  EXPECT_EQ(byFile["method"], "voxel") << "the tables of other commands are left alone";
  EXPECT_NEAR(byFile["points_out"].get<double>(), 400, 20);
  EXPECT_EQ(filtered("set.pcd", {"--set", "filter.leaf=0.2"})["points_out"], 25) << "--set beats --config";
  EXPECT_EQ(filtered("flag.pcd", {"--set", "filter.leaf=0.2", "--leaf", "0.5"})["leaf"], 0.5)
      << "a flag beats --set";
  const json gng = filter({plane_, "-o", at("gng.pcd"), "--points", "50", "--set",
                           "filter.gng.signals-per-insertion=10", "--set", "filter.gng.max-age=20"});
  EXPECT_LT(gng["signals"], 2000) << "nested groups, too";
}

TEST_F(Filter, UnknownOrImpossibleParametersAreRefused) {
  const auto refusesMore = [&](std::vector<std::string> more, ErrorCode code, const std::string& fact) {
    more.insert(more.begin(), {plane_, "-o", at("out.ply")});
    refuses(more, code, fact);
  };
  refusesMore({"--set", "filter.leef=1"}, ErrorCode::unknownName, "leef");
  refusesMore({"--set", "mapper.blur=1"}, ErrorCode::unknownName, "mapper");
  refusesMore({"--set", "filter.leaf"}, ErrorCode::invalidOption, "filter.leaf");
  refusesMore({"--set", "filter.gng.winner-rate=2"}, ErrorCode::invalidOption, "winner-rate");
  refusesMore({"--filter", "sieve"}, ErrorCode::unknownName, "sieve");
  refusesMore({"--points", "0"}, ErrorCode::invalidOption, "points");
  refusesMore({"--filter", "voxel", "--leaf", "-1"}, ErrorCode::invalidOption, "leaf");
  refusesMore({"--noise", "-1"}, ErrorCode::invalidOption, "-1");
  refusesMore({"--normals", "--normal-radius", "1e-9"}, ErrorCode::invalidOption, "1e-09");
  writeFile(at("p.toml"), "[filter]\npoints = 10\nleef = 1\n");
  refusesMore({"--config", at("p.toml")}, ErrorCode::malformedFile, "p.toml:3");
  refusesMore({"--config", at("none.toml")}, ErrorCode::fileNotFound, "none.toml");
  EXPECT_FALSE(std::filesystem::exists(at("out.ply")));
}

TEST_F(Filter, BadInputIsOneSentence) {
  writeFile(at("cut.pcd"), readFile(plane_).substr(0, 5000));
  writeFile(at("holes.ply"),
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
            "property float z\nend_header\nnan nan nan\nnan 1 1\n");
  refuses({at("cut.pcd"), "-o", at("out.ply")}, ErrorCode::truncatedFile, "cut.pcd");
  refuses({at("holes.ply"), "-o", at("out.ply")}, ErrorCode::invalidInput);
  refuses({at("holes.ply"), "-o", at("out.ply"), "--filter", "none"}, ErrorCode::invalidInput);
  refuses({at("missing.ply"), "-o", at("out.ply")}, ErrorCode::fileNotFound, "missing.ply");
  EXPECT_FALSE(std::filesystem::exists(at("out.ply")));
}

}  // namespace
}  // namespace estancia::test
