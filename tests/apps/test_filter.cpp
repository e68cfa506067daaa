// `estancia filter` as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/io/cloud_file.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
using ::testing::AllOf;
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
  void refuses(std::vector<std::string> more, const std::string& why) const {
    more.insert(more.begin(), "filter");
    const CommandResult result = run(more);
    EXPECT_EQ(result.exitCode, 2);
    EXPECT_THAT(result.err, AllOf(HasSubstr("error: "), HasSubstr(why)));
  }

  ScratchFolder scratch_;
  const std::string plane_ = scratch_ / "plane.pcd";
};

TEST_F(Filter, NeuronsTheirGraphAndNormals) {
  const json told = filter({plane_, at("out.ply"), "--points", "200", "--graph", at("graph.ply"), "--normals",
                            "--noise", "0.003", "--render", at("out.png")});
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
  EXPECT_THAT(readFile(at("graph.ply")),
              HasSubstr("element edge " + std::to_string(told["edges"].get<std::size_t>())));
}

TEST_F(Filter, VoxelsOfASizeOrForANumber) {
  EXPECT_EQ(filter({plane_, at("a.pcd"), "--method", "voxel", "--leaf", "0.2"})["points_out"], 25);
  const json told = filter({plane_, at("b.pcd"), "--method", "voxel", "--points", "400"});
  EXPECT_NEAR(told["points_out"].get<double>(), 400, 20);  // a grid over a grid: leaves come in steps
  EXPECT_GT(told["leaf"].get<double>(), 0.04);
  EXPECT_NEAR(told["resolution"].get<double>(), 0.01, 1e-6);
  EXPECT_EQ(readCloud(at("b.pcd")).points.size(), told["points_out"]);
}

TEST_F(Filter, NoiseIsSeeded) {
  filter({plane_, at("a.pcd"), "--method", "none", "--noise", "0.01", "--seed", "4"});
  filter({plane_, at("b.pcd"), "--method", "none", "--noise", "0.01", "--seed", "4"});
  filter({plane_, at("c.pcd"), "--method", "none", "--noise", "0.01", "--seed", "5"});
  EXPECT_EQ(readFile(at("a.pcd")), readFile(at("b.pcd")));
  EXPECT_NE(readFile(at("a.pcd")), readFile(at("c.pcd")));
}

TEST_F(Filter, NoiseDropsTheNormalsThatItMakesWrong) {
  const auto none = [&](const std::string& in, const std::string& out, std::vector<std::string> more) {
    more.insert(more.begin(), {at(in), at(out), "--method", "none"});
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
  filter({at("behind.pcd"), at("out.ply"), "--method", "none", "--normals"});
  EXPECT_GT(readCloud(at("out.ply")).normals.at(5050).z, 0.99F);
}

TEST_F(Filter, ADepthImageBecomesACloud) {
  cv::imwrite(at("depth.png"), cv::Mat(60, 80, CV_16U, cv::Scalar(1500)));
  refuses({at("depth.png"), at("a.ply"), "--method", "none"}, "intrinsics");
  writeFile(at("mine.txt"), "100 100 39.5 29.5");
  const json told =
      filter({at("depth.png"), at("a.pcd"), "--method", "none", "--intrinsics", at("mine.txt")});
  EXPECT_EQ(told["points_out"], 4800);
  EXPECT_TRUE(readCloud(at("a.pcd")).organized());
}

TEST_F(Filter, TellsPeopleInTwoLines) {
  const CommandResult result = run({"filter", plane_, at("out.pcd"), "--method", "voxel", "--leaf", "0.2"});
  EXPECT_EQ(result.exitCode, 0);
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("out.pcd: 25 of 10000 points; voxels of 0.2 m"), HasSubstr("resolution")));
}

TEST_F(Filter, PointsThatAreNotFiniteAreHolesOrLeftOut) {
  PointCloud cloud = readCloud(plane_);
  for (std::size_t i = 0; i < 1000; ++i) cloud.points[7 * i].y = NAN;
  cloud.width = cloud.height = 100;
  writeCloud(cloud, at("holes.pcd"));
  const json kept = filter({at("holes.pcd"), at("a.pcd"), "--method", "none"});
  EXPECT_EQ(kept["points_in"], 10000);
  EXPECT_EQ(kept["points_out"], 9000);
  EXPECT_EQ(kept["holes"], 1000);
  EXPECT_EQ(readCloud(at("a.pcd")).points.size(), 10000U);
  const json left = filter({at("holes.pcd"), at("a.ply"), "--method", "none"});
  EXPECT_EQ(left["points_out"], 9000);
  EXPECT_EQ(left["holes"], 0);
  EXPECT_EQ(readCloud(at("a.ply")).points.size(), 9000U);
  const auto told = [&](const std::string& out) {
    return run({"filter", at("holes.pcd"), out, "--method", "none", "--overwrite"}).out;
  };
  EXPECT_THAT(told(at("a.pcd")),
              HasSubstr("9000 of 10000 points; 1000 that are not finite are kept as holes"));
  EXPECT_THAT(told(at("a.ply")), HasSubstr("9000 of 10000 points; 1000 that are not finite are left out"));
}

TEST_F(Filter, ReplacesCloudsAloneAndOnlyWhenAsked) {
  const std::vector<std::string> voxels{"--method", "voxel", "--leaf", "0.2"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), voxels.begin(), voxels.end());
    return words;
  };
  writeFile(at("notes.pcd"), "not a cloud");
  filter(with({plane_, at("out.pcd")}));
  const std::string before = readFile(plane_);
  refuses(with({plane_, at("out.pcd")}), "--overwrite");
  filter(with({plane_, at("out.pcd"), "--overwrite"}));
  refuses(with({plane_, plane_, "--overwrite"}), "read here");
  refuses(with({plane_, at("notes.pcd"), "--overwrite"}), "no point cloud");
  refuses(with({plane_, at("none/out.pcd")}), "no such folder");
  refuses(with({plane_, at("out.xyz")}), ".pcd or .ply");
  refuses(with({plane_, at("new.ply"), "--graph", at("g.ply")}), "--method gng");
  refuses({plane_, at("new.ply"), "--graph", at("new.ply")}, "both the cloud and the graph");
  refuses({plane_, at("new.ply"), "--graph", at("../" + scratch_.path().filename().string() + "/new.ply")},
          "both the cloud and the graph");
  refuses({plane_, at("new.ply"), "--graph", at("g.pcd")}, "as .ply");
  refuses({plane_, at("new.ply"), "--render", plane_}, "is read here");
  writeFile(at("photo.png"), "\x89PNG\r\n a photograph");
  refuses({plane_, at("new.ply"), "--render", at("photo.png")}, "--overwrite");
  EXPECT_EQ(readFile(at("photo.png")), "\x89PNG\r\n a photograph");
  refuses({plane_, at("new.ply"), "--normals", "--normal-radius", "1e-9"}, "--normal-radius of");
  EXPECT_EQ(readFile(plane_), before);
  EXPECT_FALSE(std::filesystem::exists(at("new.ply")));
}

TEST_F(Filter, OptionsThatTheMethodDoesNotUseAreRefused) {
  refuses({plane_, at("out.ply"), "--leaf", "0.2"}, "--leaf needs --method voxel; gng has no use for it");
  for (const std::string option : {"--error", "--deadline"})
    refuses({plane_, at("out.ply"), "--method", "voxel", option, "0.1"}, option + " needs --method gng");
  refuses({plane_, at("out.ply"), "--method", "none", "--points", "9"},
          "--points needs --method gng or voxel");
  refuses({plane_, at("out.ply"), "--method", "voxel", "--leaf", "0.2", "--points", "9"}, "excludes");
  refuses({plane_, at("out.ply"), "--normal-radius", "0.1"}, "requires --normals");
  EXPECT_FALSE(std::filesystem::exists(at("out.ply")));
}

TEST_F(Filter, BadInputIsOneSentence) {
  writeFile(at("cut.pcd"), readFile(plane_).substr(0, 5000));
  writeFile(at("holes.ply"),
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
            "property float z\nend_header\nnan nan nan\nnan 1 1\n");
  refuses({at("cut.pcd"), at("out.ply")}, "cut.pcd");
  refuses({at("holes.ply"), at("out.ply")}, "finite");
  refuses({at("holes.ply"), at("out.ply"), "--method", "none"}, "empty cloud");
  refuses({at("missing.ply"), at("out.ply")}, "missing.ply");
  refuses({plane_, at("out.ply"), "--method", "sieve"}, "sieve");
  refuses({plane_, at("out.ply"), "--points", "0"}, "--points");
  refuses({plane_, at("out.ply"), "--method", "voxel", "--leaf", "0"}, "--leaf");
  refuses({plane_, at("out.ply"), "--noise", "-1"}, "--noise");
  EXPECT_FALSE(std::filesystem::exists(at("out.ply")));
}

}  // namespace
}  // namespace estancia::test
