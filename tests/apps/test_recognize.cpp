// `estancia recognize` as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/affine.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>

#include "estancia/core/rigid.hpp"
#include "estancia/files/cloud_file.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

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
  const CommandResult result =
      run({"recognize", in("scenes/scene001.pcd"), "--object", "mario=" + in("meshes/mario000_0.ply"),
           "--object", in("meshes/Squirrel011_0.ply"), "--json", "--render", image, "--overwrite"});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const json told = json::parse(result.out);
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
  const CommandResult result =
      run({"recognize", in("scenes/scene001.pcd"), "--object", in("meshes/Doll013_0.ply"), "--object",
           in("meshes/Frog000_0.ply"), "--explain"});
  EXPECT_EQ(result.exitCode, 1);
  const auto scene = result.out.find("scene001.pcd\n"), doll = result.out.find("Doll013_0\n"),
             frog = result.out.find("Frog000_0\n");
  EXPECT_LT(scene, doll);
  EXPECT_LT(doll, frog) << "stages in the order of the objects";
  EXPECT_NE(frog, std::string::npos);
  EXPECT_EQ(result.err, "");
  const CommandResult machines =
      run({"recognize", "--object", in("meshes/Doll013_0.ply"), in("scenes/scene001.pcd"), "--json"});
  EXPECT_EQ(machines.exitCode, 1);
  EXPECT_EQ(json::parse(machines.out), json::parse(R"({"instances": []})"));
}

TEST_F(Recognize, ExplainsItsStagesToMachines) {
  const json stages = json::parse(run({"recognize", in("scenes/scene001.pcd"), "--object",
                                       "doll=" + in("meshes/Doll013_0.ply"), "--explain", "--json"})
                                      .out)["stages"];
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
  const std::map<std::string, std::pair<std::string, std::string>> bad{
      {"gone", {scratch_ / "gone.ply", "gone.ply"}},
      {"few", {writeScaled("few.ply", few, 1), "3 of its 3"}},
      {"flat", {writeScaled("flat.ply", plane, 1), "planar"}},
      {"millimeters", {writeScaled("millimeters.ply", readCloud(mario), 1000), "0.001"}}};
  std::vector<std::string> arguments{"recognize", "--json", in("scenes/scene001.pcd")};
  for (const auto& [name, fileAndReason] : bad)
    arguments.insert(arguments.end(), {"--object", name + "=" + fileAndReason.first});
  const CommandResult none = run(arguments);
  EXPECT_EQ(none.exitCode, 2);
  EXPECT_EQ(json::parse(none.out)["error"]["code"], "invalid-input");
  EXPECT_THAT(none, FailsWith(ErrorCode::invalidInput, "4"));

  arguments.insert(arguments.end(), {"--object", mario});
  const CommandResult one = run(arguments);
  ASSERT_EQ(one.exitCode, 0) << one.err;
  const json told = json::parse(one.out);
  ASSERT_EQ(told["instances"].size(), 1U);
  EXPECT_EQ(told["instances"][0]["model"], "mario000_0");
  ASSERT_EQ(told["failed"].size(), bad.size());
  for (const json& failed : told["failed"]) {
    const std::string name = failed["model"];
    EXPECT_NE(failed["reason"].get<std::string>().find(bad.at(name).second), std::string::npos) << failed;
    EXPECT_NE(one.err.find("warning: " + name), std::string::npos) << one.err;
  }
}

TEST_F(Recognize, FindsWhereTheSensorStoodOrIsTold) {
  // As robots have it: z up, the origin elsewhere.
  const cv::Affine3d fromCamera(cv::Matx33d(0, 0, 1, -1, 0, 0, 0, -1, 0), cv::Vec3d(1, 2, 3));
  PointCloud scene = readCloud(in("scenes/scene001.pcd"));
  for (cv::Point3f& p : scene.points) p = fromCamera * cv::Point3d(p);
  const std::string moved = scratch_ / "moved.pcd", mario = in("meshes/mario000_0.ply");
  writeCloud(scene, moved);
  const CommandResult unsaid = run({"recognize", moved, "--object", mario});
  EXPECT_EQ(unsaid.exitCode, 0) << "it is estimated";
  EXPECT_THAT(unsaid.err, HasSubstr("--viewpoint"));
  const auto expectFound = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"recognize", "--object", mario, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandResult result = run(arguments);
    ASSERT_EQ(result.exitCode, 0) << result.err;
    EXPECT_EQ(result.err, "");
    const auto numbers = json::parse(result.out)["instances"][0]["pose"].get<std::vector<double>>();
    const cv::Vec4d somewhere(0.05, -0.1, 1, 1);
    EXPECT_LT(cv::norm(cv::Matx44d(numbers.data()) * somewhere -
                       fromCamera.matrix * readPose(in("gt/scene001-rs0.xf")) * somewhere),
              0.02);
  };
  expectFound({moved, "--viewpoint", "1,2,3"});
  scene.viewpoint = poseOf(fromCamera);
  writeCloud(scene, moved);
  expectFound({moved});
  scene.viewpoint = Pose{5, 2, 3};
  writeCloud(scene, moved);
  EXPECT_THAT(run({"recognize", moved, "--object", mario}).out, HasSubstr("VIEWPOINT"));
  expectFound({moved, "--viewpoint", "1,2,3"});
}

TEST_F(Recognize, WarnsOfNoViewWhetherOrNotSomethingIsFound) {
  PointCloud scene = readCloud(in("scenes/scene001.pcd"));
  const std::size_t seen = scene.points.size();
  for (std::size_t i = 0; i < seen; i += 3)  // as many again behind the sensor
    scene.points.push_back(scene.points[i] - cv::Point3f(0, 0, 2.5F));
  scene.width = scene.points.size();
  scene.height = 1;
  const std::string around = scratch_ / "around.pcd", mario = in("meshes/mario000_0.ply");
  writeCloud(scene, around);
  const CommandResult found = run({"recognize", around, "--object", mario});
  EXPECT_EQ(found.exitCode, 0);
  const auto warning = HasSubstr("--viewpoint");
  EXPECT_THAT(found.err, warning);
  const json told = json::parse(run({"recognize", around, "--object", mario, "--json"}).out);
  ASSERT_EQ(told["instances"].size(), 2U) << "the copy, too";
  const auto depth = [&](int i) { return told["instances"][i]["pose"][11].get<double>(); };
  EXPECT_NEAR(std::abs(depth(0) - depth(1)), 2.5, 0.01);
  ASSERT_EQ(told["warnings"].size(), 1U);
  EXPECT_EQ(told["warnings"][0]["code"], "no-view");
  EXPECT_THAT(told["warnings"][0]["message"].get<std::string>(), warning);
  const std::string doll = in("meshes/Doll013_0.ply");
  const CommandResult missed = run({"recognize", around, "--object", doll, "--json"});
  EXPECT_EQ(missed.exitCode, 1);
  EXPECT_THAT(missed.err, warning);
  EXPECT_EQ(json::parse(missed.out)["warnings"].size(), 1U);
  const CommandResult said = run({"recognize", around, "--object", doll, "--viewpoint", "0,0,0", "--json"});
  EXPECT_THAT(said.err, HasSubstr("correct --viewpoint"));
  EXPECT_EQ(json::parse(said.out)["warnings"][0]["code"], "no-view");
}

TEST_F(Recognize, ParametersComeFromPresetFileAndCommand) {
  const std::string scene = in("scenes/scene001.pcd"), object = "mario=" + in("meshes/mario000_0.ply"),
                    config = scratch_ / "p.toml";
  writeFile(config, "[recognition]\nkeypoint_spacing = 0.02\ndescriptor = \"fpfh\"\n");
  /// How a stage of the object describes itself, with these parameters.
  const auto stage = [&](const std::string& name, std::vector<std::string> more) {
    more.insert(more.begin(), {"recognize", scene, "--object", object, "--explain", "--json"});
    const CommandResult result = run(more);
    EXPECT_LT(result.exitCode, 2) << result.err;
    const json stages = json::parse(result.out)["stages"]["models"]["mario"];
    for (const json& s : stages)
      if (s["stage"] == name) return s["detail"].get<std::string>();
    return std::string();
  };
  const std::string thesis = stage("keypoints", {"--preset", "thesis"});
  EXPECT_EQ(thesis.find("uniform, 0.01 m"), 0U) << thesis;
  const std::string file = stage("keypoints", {"--preset", "thesis", "--config", config});
  EXPECT_EQ(file.find("uniform, 0.02 m"), 0U) << "--config beats --preset: " << file;
  const std::string set =
      stage("keypoints", {"--config", config, "--set", "recognition.keypoint-spacing=0.03"});
  EXPECT_EQ(set.find("uniform, 0.03 m"), 0U) << "--set beats --config: " << set;
  const std::string flag = stage("keypoints", {"--set", "recognition.keypoint-spacing=0.03",
                                               "--keypoint-spacing", "0.04", "--preset", "thesis"});
  EXPECT_EQ(flag.find("uniform, 0.04 m"), 0U) << "a flag beats --set: " << flag;
  EXPECT_EQ(stage("filter", {"--preset", "thesis", "--set", "recognition.model-filter.method=voxel", "--set",
                             "recognition.model-filter.points=500"})
                .find("voxel: "),
            0U);
  EXPECT_EQ(
      run({"recognize", scene, "--object", object, "--preset", "thesis", "--normal-radius", "0.02", "--json"})
          .err,
      "")
      << "a radius replaces the preset's number of neighbors";
}

TEST_F(Recognize, RefusesWhatItCannotUse) {
  const std::string mario = in("meshes/mario000_0.ply"), scene = in("scenes/scene001.pcd");
  const auto refuses = [&](std::vector<std::string> arguments, ErrorCode code, const std::string& fact) {
    arguments.insert(arguments.begin(), {"recognize", "--object", mario});
    EXPECT_THAT(run(arguments), FailsWith(code, fact));
  };
  EXPECT_THAT(run({"recognize", scene}), FailsWith(ErrorCode::invalidOption, "--object"));
  refuses({}, ErrorCode::invalidOption, "SCENE");
  refuses({scene, "--object", mario}, ErrorCode::invalidOption, "mario000_0");
  refuses({scene, "--preset", "magic"}, ErrorCode::unknownName, "magic");
  refuses({scene, "--descriptor", "magic"}, ErrorCode::unknownName, "magic");
  refuses({scene, "--set", "recognition.magic=1"}, ErrorCode::unknownName, "magic");
  refuses({scene, "--set", "magic.points=1"}, ErrorCode::unknownName, "magic");
  refuses({scene, "--normal-radius", "-1"}, ErrorCode::invalidOption, "-1");
  refuses({scene, "--set", "recognition.normal-radius=1", "--set", "recognition.normal-neighbors=5"},
          ErrorCode::invalidOption, "normal-neighbors");
  refuses({scene, "--points", "-1"}, ErrorCode::invalidOption, "--points");
  refuses({scene, "--viewpoint", "1,2"}, ErrorCode::invalidOption, "1,2");
  refuses({scratch_ / "none.pcd"}, ErrorCode::fileNotFound, "none.pcd");
}

TEST_F(Recognize, DrawsIntoNewImagesOnly) {
  const std::string mario = in("meshes/mario000_0.ply"), scene = in("scenes/scene001.pcd");
  const auto refuses = [&](std::vector<std::string> image, ErrorCode code, const std::string& fact) {
    image.insert(image.begin(), {"recognize", scene, "--object", "a=" + mario, "--render"});
    EXPECT_THAT(run(image), FailsWith(code, fact));
  };
  const std::string before = readFile(mario), photo = "\x89PNG\r\n a photograph";
  refuses({mario, "--overwrite"}, ErrorCode::fileExists, "mario000_0.ply");
  EXPECT_EQ(readFile(mario), before);
  writeFile(scratch_ / "photo.png", photo);
  writeFile(scratch_ / "notes.png", "notes");
  refuses({scratch_ / "photo.png"}, ErrorCode::fileExists, "--overwrite");
  EXPECT_EQ(readFile(scratch_ / "photo.png"), photo);
  refuses({scratch_ / "notes.png", "--overwrite"}, ErrorCode::fileExists, "notes.png");
  EXPECT_EQ(readFile(scratch_ / "notes.png"), "notes");
  refuses({scratch_ / "none/found.png"}, ErrorCode::fileNotFound, "none");
  refuses({scratch_ / "found.jpg"}, ErrorCode::unsupportedFile, "found.jpg");
}

}  // namespace
}  // namespace estancia::test
