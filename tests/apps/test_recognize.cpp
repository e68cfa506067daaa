// `estancia recognize` as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/affine.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "estancia/core/rigid.hpp"
#include "estancia/io/cloud_file.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
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
      run({"recognize", in("scenes/scene001.pcd"), "--model", "mario=" + in("meshes/mario000_0.ply"),
           "--model", in("meshes/Squirrel011_0.ply"), "--json", "--render", image, "--overwrite"});
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
  const CommandResult result = run({"recognize", "--model", in("meshes/Doll013_0.ply"),
                                    in("meshes/Frog000_0.ply"), in("scenes/scene001.pcd"), "--explain"});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("None of the models is in"), HasSubstr("Doll013_0\n"), HasSubstr("Frog000_0\n"),
                    HasSubstr("of 0.23 needed"), HasSubstr("keypoints")));
  EXPECT_EQ(result.err, "");
  const CommandResult machines =
      run({"recognize", "--model", in("meshes/Doll013_0.ply"), in("scenes/scene001.pcd"), "--json"});
  EXPECT_EQ(machines.exitCode, 1);
  EXPECT_EQ(json::parse(machines.out), json::parse(R"({"instances": []})"));
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
      {"few", {writeScaled("few.ply", few, 1), "3 of its 3 points"}},
      {"flat", {writeScaled("flat.ply", plane, 1), "planar"}},
      {"millimeters", {writeScaled("millimeters.ply", readCloud(mario), 1000), "0.001"}}};
  std::vector<std::string> arguments{"recognize", "--json", in("scenes/scene001.pcd")};
  for (const auto& [name, fileAndReason] : bad)
    arguments.insert(arguments.end(), {"--model", name + "=" + fileAndReason.first});
  const CommandResult none = run(arguments);
  EXPECT_EQ(none.exitCode, 2);
  EXPECT_EQ(json::parse(none.out)["error"]["code"], "invalid-input");
  EXPECT_THAT(none.err, HasSubstr("none of the 4 models can be looked for"));

  arguments.insert(arguments.end(), {"--model", mario});
  const CommandResult one = run(arguments);
  ASSERT_EQ(one.exitCode, 0) << one.err;
  const json told = json::parse(one.out);
  ASSERT_EQ(told["instances"].size(), 1U);
  EXPECT_EQ(told["instances"][0]["model"], "mario000_0");
  ASSERT_EQ(told["failed"].size(), bad.size());
  for (const json& failed : told["failed"]) {
    const std::string name = failed["model"];
    EXPECT_THAT(failed["reason"].get<std::string>(), HasSubstr(bad.at(name).second));
    EXPECT_THAT(one.err, HasSubstr("warning: " + name + " is left out: "));
  }
}

TEST_F(Recognize, AsksWhereTheSensorStoodAndUsesIt) {
  // As robots have it: z up, the origin elsewhere.
  const cv::Affine3d fromCamera(cv::Matx33d(0, 0, 1, -1, 0, 0, 0, -1, 0), cv::Vec3d(1, 2, 3));
  PointCloud scene = readCloud(in("scenes/scene001.pcd"));
  for (cv::Point3f& p : scene.points) p = fromCamera * cv::Point3d(p);
  const std::string moved = scratch_ / "moved.pcd", mario = in("meshes/mario000_0.ply");
  writeCloud(scene, moved);
  const CommandResult unsaid = run({"recognize", "--model", mario, moved});
  EXPECT_EQ(unsaid.exitCode, 1);
  EXPECT_THAT(unsaid.out, HasSubstr("--viewpoint"));
  const auto expectFound = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"recognize", "--model", mario, "--json"};
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
  expectFound({moved, "--viewpoint", "1", "2", "3"});
  scene.viewpoint = poseOf(fromCamera);
  writeCloud(scene, moved);
  expectFound({moved});
  scene.viewpoint = Pose{5, 2, 3};
  writeCloud(scene, moved);
  EXPECT_THAT(run({"recognize", "--model", mario, moved}).out, HasSubstr("where its VIEWPOINT says"));
  expectFound({moved, "--viewpoint", "1", "2", "3"});
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
  const CommandResult found = run({"recognize", "--model", mario, around});
  EXPECT_EQ(found.exitCode, 0);
  const auto warning = AllOf(HasSubstr("does not look like a view"), HasSubstr("--viewpoint"));
  EXPECT_THAT(found.err, warning);
  const json told = json::parse(run({"recognize", "--model", mario, around, "--json"}).out);
  EXPECT_EQ(told["instances"].size(), 1U);
  ASSERT_EQ(told["warnings"].size(), 1U);
  EXPECT_EQ(told["warnings"][0]["code"], "no-view");
  EXPECT_THAT(told["warnings"][0]["message"].get<std::string>(), warning);
  const std::string doll = in("meshes/Doll013_0.ply");
  const CommandResult missed = run({"recognize", "--model", doll, around, "--json"});
  EXPECT_EQ(missed.exitCode, 1);
  EXPECT_THAT(missed.err, warning);
  EXPECT_EQ(json::parse(missed.out)["warnings"].size(), 1U);
  const CommandResult said =
      run({"recognize", "--model", doll, around, "--viewpoint", "0", "0", "0", "--json"});
  EXPECT_EQ(said.err, "");
  EXPECT_FALSE(json::parse(said.out).contains("warnings"));
}

TEST_F(Recognize, RefusesWhatItCannotUse) {
  const std::string mario = in("meshes/mario000_0.ply"), scene = in("scenes/scene001.pcd");
  const auto refuses = [&](std::vector<std::string> arguments, const std::string& why) {
    arguments.insert(arguments.begin(), "recognize");
    const CommandResult result = run(arguments);
    EXPECT_EQ(result.exitCode, 2);
    EXPECT_THAT(result.err, AllOf(HasSubstr("error: "), HasSubstr(why)));
  };
  refuses({"--model", mario}, "SCENE is missing");
  refuses({scene}, "--model");
  refuses({"--model", "a=" + mario, "a=" + mario, scene}, "two models are called a");
  refuses({"--model", mario, scene, "--preset", "magic"}, "default, classical");
  refuses({"--model", mario, scene, "--descriptor", "magic"}, "shot, fpfh");
  refuses({"--model", mario, scene, "--normal-radius", "-1"}, "-1");
  refuses({"--model", mario, scene, "--render", mario}, "is read here");
  refuses({"--model", "a=" + mario, scene, "--render", mario}, "is read here");
  writeFile(scratch_ / "photo.png", "\x89PNG\r\n a photograph");
  writeFile(scratch_ / "notes.png", "notes");
  refuses({"--model", mario, scene, "--render", scratch_ / "photo.png"}, "--overwrite");
  refuses({"--model", mario, scene, "--render", scratch_ / "notes.png", "--overwrite"}, "not replaced");
  EXPECT_EQ(readFile(scratch_ / "photo.png"), "\x89PNG\r\n a photograph");
  refuses({"--model", mario, scene, "--render", scratch_ / "none/found.png"}, "no such folder");
  refuses({"--model", mario, scene, "--render", scratch_ / "found.jpg"}, "only PNG");
  refuses({"--model", mario, scene, "--points", "-1"}, "--points");
  refuses({"--model", mario, scratch_ / "none.pcd"}, "none.pcd");
}

}  // namespace
}  // namespace estancia::test
