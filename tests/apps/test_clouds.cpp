// `estancia filter` and `estancia recognize` as a user runs them.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "apps/json_of.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"
#include "support/written_drive.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
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
  static json filter(const std::vector<std::string>& more) { return jsonOf(run({"filter", "--json"}, more)); }
  static void refuses(const std::vector<std::string>& more, ErrorCode code) {
    EXPECT_THAT(run({"filter"}, more), FailsWith(code)) << testing::PrintToString(more);
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
  for (const auto& [arguments, code] : refused) refuses(arguments, code);
  EXPECT_FALSE(std::filesystem::exists(out));
}

/// A desk in a recorded room, and the cloud of its surface.
class RecognizeInDrive : public testing::Test {
 protected:
  void SetUp() override {
    writeDrive(shown_, drive_);
    writeCloud(surfaceOf(desk), scratch_ / "desk.ply");
  }
  CommandResult recognize(const std::string& scene, const std::vector<std::string>& more) const {
    return run({"recognize", scene, "--object", scratch_ / "desk.ply", "--json"}, more);
  }
  /// Expects the desk alone, where it stands, in the frame of `camera` or in the map.
  static void expectDesk(const json& told, const std::string& reference, const cv::Affine3d& toReference) {
    EXPECT_EQ(told["poses_in"], reference);
    ASSERT_EQ(told["instances"].size(), 1U) << told;
    const auto numbers = told["instances"][0]["pose"].get<std::vector<double>>();
    const cv::Matx44d pose(numbers.data()), truth = (toReference * ShapeDrive::placeOfShape()).matrix;
    const cv::Vec4d somewhere(0.2, 0.1, 0.3, 1);
    EXPECT_LT(cv::norm(pose * somewhere - truth * somewhere), 0.03) << told;
  }
  cv::Affine3d toCamera(std::size_t i) const { return rigidOf(*shown_.frame(i).pose).inv(); }

  ScratchFolder scratch_;
  const ShapeDrive shown_{desk};
  const fs::path drive_ = scratch_ / "drive";
};

TEST_F(RecognizeInDrive, OneFrameIsSearchedInTheFrameOfItsCamera) {
  const json told = jsonOf(recognize(drive_, {"--frame", "2"}));
  expectDesk(told, "camera", toCamera(2));
  EXPECT_EQ(told["frames"][0]["name"], "0002.png");
  EXPECT_EQ(told["frames"][0]["pose"].size(), 16U);
  EXPECT_FALSE(told.contains("warnings")) << "it is known where the camera stood";
  EXPECT_EQ(jsonOf(recognize(drive_, {"--frame", "0002.png"})), told) << "by its name";
}

TEST_F(RecognizeInDrive, SeveralFramesAreSearchedInTheMap) {
  const json told = jsonOf(recognize(drive_, {"--frame", "1,3", "--frame", "5"}));
  expectDesk(told, "map", cv::Affine3d::Identity());
  EXPECT_EQ(told["frames"].size(), 3U);
  EXPECT_EQ(told["warnings"][0]["code"], "no-view");
}

TEST_F(RecognizeInDrive, ADepthImageNeedsItsCameraAlone) {
  const std::string depth = drive_ / "depth/0002.png", camera = drive_ / "intrinsics.txt";
  expectDesk(jsonOf(recognize(depth, {"--colors", drive_ / "rgb/0002.png"})), "camera", toCamera(2));
  fs::rename(depth, scratch_ / "depth.png");
  EXPECT_THAT(recognize(scratch_ / "depth.png", {}), FailsWith(ErrorCode::insufficientData));
  const json told = jsonOf(recognize(scratch_ / "depth.png", {"--intrinsics", camera}));
  expectDesk(told, "camera", toCamera(2));
  EXPECT_FALSE(told.contains("frames"));
  EXPECT_THAT(recognize(scratch_ / "depth.png", {"--intrinsics", camera, "--depth-scale", "1e6"}),
              FailsWith(ErrorCode::mismatch));
}

TEST_F(RecognizeInDrive, ObjectsAndScenesMayBeInOtherUnits) {
  writeCloud(surfaceOf(desk, 1000), scratch_ / "desk.ply");
  EXPECT_THAT(recognize(drive_, {"--frame", "2"}), FailsWith(ErrorCode::mismatch));
  expectDesk(jsonOf(recognize(drive_, {"--frame", "2", "--object-unit", "mm"})), "camera", toCamera(2));
  PointCloud scene = backProject(1000 * shown_.depth(2), *shown_.intrinsics());
  writeCloud(scene, scratch_ / "scene.ply");
  expectDesk(jsonOf(recognize(scratch_ / "scene.ply", {"--object-unit", "mm", "--scene-unit", "mm"})),
             "cloud", toCamera(2));
  EXPECT_THAT(recognize(drive_, {"--frame", "2", "--object-unit", "furlong"}),
              FailsWith(ErrorCode::unknownName));
}

TEST_F(RecognizeInDrive, RefusesFramesThatItCannotUse) {
  const auto refuses = [&](const std::string& scene, const std::vector<std::string>& more, ErrorCode code) {
    EXPECT_THAT(recognize(scene, more), FailsWith(code)) << testing::PrintToString(more);
  };
  const std::string drive = drive_;
  refuses(drive, {}, ErrorCode::invalidOption);
  refuses(drive, {"--frame", "2,2"}, ErrorCode::invalidOption);
  refuses(drive, {"--frame", "2", "--scene-unit", "mm"}, ErrorCode::invalidOption);
  refuses(drive, {"--frame", "2", "--colors", drive + "/rgb/0002.png"}, ErrorCode::invalidOption);
  for (const char* frame : {"12", "-1", "1.5", "desk", "nan"})
    refuses(drive, {std::string("--frame=") + frame}, ErrorCode::unknownName);
  refuses(scratch_ / "desk.ply", {"--frame", "2"}, ErrorCode::invalidOption);
  refuses(drive_ / "depth/0002.png", {"--frame", "2"}, ErrorCode::invalidOption);
  refuses(drive_ / "poses.txt", {}, ErrorCode::unsupportedFile);
  refuses(drive_ / "poses.txt", {"--frame", "2"}, ErrorCode::unsupportedFile);
  refuses(scratch_ / "none", {"--frame", "2"}, ErrorCode::fileNotFound);
  for (const char* dark : {"1", "3"})
    cv::imwrite(drive_ / fmt::format("depth/000{}.png", dark), cv::Mat(180, 240, CV_16U, cv::Scalar(0)));
  refuses(drive, {"--frame", "1,3"}, ErrorCode::insufficientData);
  writeFile(drive_ / "poses.txt", "0 0 0 0 0 0 0 1\n");
  refuses(drive, {"--frame", "1,3"}, ErrorCode::insufficientData);
  fs::remove(drive_ / "intrinsics.txt");
  refuses(drive, {"--frame", "1"}, ErrorCode::insufficientData);
  refuses(drive_ / "rgb", {"--frame", "1"}, ErrorCode::insufficientData);
}

TEST(RealDepthImage, IsSearchedByTheViewOfItsCamera) {
  const auto data = findData("ycb_tables");
  ESTANCIA_NEEDS(data, "ycb_tables is not unpacked");
  const fs::path table = *data / "ycbv_demo_1";
  const json camera = json::parse(readFile(table / "camera.json"));
  const ScratchFolder scratch;
  writeFile(scratch / "camera.txt",
            fmt::format("{} {} {} {}\n", camera["fx"].get<double>(), camera["fy"].get<double>(),
                        camera["cx"].get<double>(), camera["cy"].get<double>()));
  const json told =
      jsonOf(run({"recognize", table / "depth.png", "--intrinsics", scratch / "camera.txt", "--colors",
                  table / "rgb.png", "--object", *data / "models/006_mustard_bottle.pcd", "--json"}));
  ASSERT_EQ(told["instances"].size(), 1U);
  EXPECT_EQ(told["poses_in"], "camera");
  for (const json& thing : json::parse(readFile(table / "truth.json"))) {
    if (thing["model"] != told["instances"][0]["model"]) continue;
    for (const std::size_t at : {3U, 7U, 11U})
      EXPECT_NEAR(told["instances"][0]["pose"][at].get<double>(), thing["pose"][at].get<double>(), 0.01);
  }
}

TEST(RealDrive, JoinedFramesHaveTheThingOfAnEarlierOne) {
  const auto data = findData("sevenscenes_redkitchen");
  ESTANCIA_NEEDS(data, "sevenscenes_redkitchen is not unpacked");
  const auto drive = openSequence(*data);
  const cv::Point3f middle(0.485F, -0.606F, 2.546F);  // shelves at the wall
  PointCloud thing;
  for (const cv::Point3f& p : backProject(drive->depth(98), *drive->intrinsics()).points)
    if (cv::norm(p - middle) < 0.4) thing.points.push_back(p);
  thing.width = thing.points.size();
  thing.height = 1;
  const ScratchFolder scratch;
  writeCloud(thing, scratch / "thing.pcd");
  const json told = jsonOf(
      run({"recognize", *data, "--frame", "100,110,120", "--object", scratch / "thing.pcd", "--json"}));
  ASSERT_EQ(told["instances"].size(), 1U);
  EXPECT_EQ(told["poses_in"], "map");
  const auto numbers = told["instances"][0]["pose"].get<std::vector<double>>();
  const cv::Affine3d pose(cv::Matx44d(numbers.data()));
  EXPECT_LT(cv::norm(pose * cv::Point3d(middle) - rigidOf(*drive->frame(98).pose) * cv::Point3d(middle)),
            0.04);
}

class Recognize : public testing::Test {
 protected:
  void SetUp() override {
    data_ = findData("shot_kinect");
    ESTANCIA_NEEDS(data_, "shot_kinect is not unpacked");
  }
  std::string in(const std::string& name) const { return *data_ / name; }

  std::optional<fs::path> data_;
  ScratchFolder scratch_;
};

cv::Matx44d readPose(const fs::path& file) {
  std::ifstream in(file);
  cv::Matx44d pose;
  for (double& number : pose.val) in >> number;
  return pose;
}

TEST_F(Recognize, TellsModelsPosesRowByRowAndDrawsThem) {
  const std::string image = scratch_ / "found.png";
  writeFile(image, "\x89PNG\r\n an older one");
  const json told =
      jsonOf(run({"recognize", in("scenes/scene001.pcd"), "--object", "mario=" + in("meshes/mario000_0.ply"),
                  "--object", in("meshes/Squirrel011_0.ply"), "--json", "--render", image, "--overwrite"}));
  ASSERT_EQ(told["instances"].size(), 2U);
  const std::map<std::string, std::string> truth{{"mario", "gt/scene001-rs0.xf"},
                                                 {"Squirrel011_0", "gt/scene001-rs2.xf"}};
  for (const json& found : told["instances"]) {
    ASSERT_TRUE(truth.contains(found["model"])) << found;
    const cv::Matx44d pose = readPose(in(truth.at(found["model"])));
    const cv::Vec4d somewhere(0.05, -0.1, 1, 1);  // about where models are
    const auto numbers = found["pose"].get<std::vector<double>>();
    ASSERT_EQ(numbers.size(), 16U);
    EXPECT_LT(cv::norm(cv::Matx44d(numbers.data()) * somewhere - pose * somewhere), 0.02);
    EXPECT_GT(found["confidence"], 0.5);
    EXPECT_GT(found["inliers"], 100);
  }
  const cv::Mat drawn = cv::imread(image);
  ASSERT_EQ(drawn.cols, 1280);
  int orange = 0;  // the first instance's color, shaded
  for (int y = 0; y < drawn.rows; ++y)
    for (int x = 0; x < drawn.cols; ++x) {
      const cv::Vec3b bgr = drawn.at<cv::Vec3b>(y, x);
      orange += bgr[0] == 0 && bgr[2] > 200 && bgr[1] > 120;
    }
  EXPECT_GT(orange, 1000);
}

TEST_F(Recognize, SaysWhatIsNotThereAndWhy) {
  const CommandResult result = run({"recognize", in("scenes/scene001.pcd"), "--object",
                                    "doll=" + in("meshes/Doll013_0.ply"), "--explain", "--json"});
  EXPECT_EQ(result.exitCode, 1) << result.err;
  const json answer = json::parse(result.out);
  EXPECT_EQ(answer["instances"].size(), 0U);
  const json& stages = answer["stages"];
  EXPECT_EQ(stages["scene"][0]["stage"], "filter");
  std::set<std::string> names;
  for (const json& stage : stages["models"]["doll"]) names.insert(stage["stage"]);
  for (const char* name : {"filter", "keypoints", "matching", "grouping", "verification"})
    EXPECT_TRUE(names.contains(name)) << name;
}

TEST_F(Recognize, ABadModelDoesNotEndTheSearchForTheOthers) {
  const auto writeScaled = [&](const std::string& name, PointCloud cloud, float scale) {
    for (cv::Point3f& p : cloud.points) p *= scale;
    writeCloud(cloud, scratch_ / name);
    return scratch_ / name;
  };
  PointCloud plane, few;
  for (int i = 0; i < 10000; ++i)
    plane.points.emplace_back(0.002F * static_cast<float>(i % 100), 0.002F * static_cast<float>(i / 100),
                              1.F);
  few.points.assign(plane.points.begin(), plane.points.begin() + 3);
  plane.width = 10000, few.width = 3;
  plane.height = few.height = 1;
  const std::string mario = in("meshes/mario000_0.ply");
  const std::map<std::string, std::string> bad{
      {"gone", scratch_ / "gone.ply"},
      {"few", writeScaled("few.ply", few, 1)},
      {"flat", writeScaled("flat.ply", plane, 1)},
      {"millimeters", writeScaled("millimeters.ply", readCloud(mario), 1000)}};
  std::vector<std::string> arguments{"recognize", "--json", in("scenes/scene001.pcd")};
  for (const auto& [name, file] : bad) arguments.insert(arguments.end(), {"--object", name + "=" + file});
  const CommandResult none = run(arguments);
  EXPECT_EQ(none.exitCode, 2);
  EXPECT_EQ(json::parse(none.out)["error"]["code"], "invalid-input");
  EXPECT_THAT(none, FailsWith(ErrorCode::invalidInput));

  arguments.insert(arguments.end(), {"--object", mario});
  const CommandResult one = run(arguments);
  ASSERT_EQ(one.exitCode, 0) << one.err;
  const json told = json::parse(one.out);
  ASSERT_EQ(told["instances"].size(), 1U);
  EXPECT_EQ(told["instances"][0]["model"], "mario000_0");
  ASSERT_EQ(told["failed"].size(), bad.size());
  for (const json& failed : told["failed"]) {
    const std::string name = failed["model"];
    EXPECT_TRUE(bad.contains(name)) << failed;
    EXPECT_NE(one.err.find("warning: " + name), std::string::npos) << one.err;
  }
}

TEST_F(Recognize, RefusesWhatItCannotUse) {
  const std::string mario = in("meshes/mario000_0.ply"), scene = in("scenes/scene001.pcd");
  const auto refuses = [&](const std::vector<std::string>& arguments, ErrorCode code) {
    EXPECT_THAT(run({"recognize", "--object", mario}, arguments), FailsWith(code));
  };
  EXPECT_THAT(run({"recognize", scene}), FailsWith(ErrorCode::invalidOption));
  refuses({}, ErrorCode::invalidOption);
  refuses({scene, "--object", mario}, ErrorCode::invalidOption);
  refuses({scene, "--descriptor", "magic"}, ErrorCode::unknownName);
  refuses({scene, "--set", "recognition.normal-radius=1", "--set", "recognition.normal-neighbors=5"},
          ErrorCode::invalidOption);
  refuses({scene, "--viewpoint", "1,2"}, ErrorCode::invalidOption);
  refuses({scratch_ / "none.pcd"}, ErrorCode::fileNotFound);
}

}  // namespace
}  // namespace estancia::test
