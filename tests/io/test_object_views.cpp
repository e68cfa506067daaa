// Views of objects in clouds and in NYU's labeled frames: made up, and the real ones.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "estancia/io/cloud_file.hpp"
#include "estancia/io/object_views.hpp"
#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::encoded;
using test::FailsWith;
using test::Mentions;
using test::writeFile;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

PointCloud line(std::size_t count, bool colored = false) {
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) cloud.points.emplace_back(static_cast<float>(i), 1, 2);
  if (colored) cloud.colors.assign(count, {10, 20, 30});
  cloud.width = count;
  cloud.height = 1;
  return cloud;
}

void save(const fs::path& file, const PointCloud& cloud) {
  fs::create_directories(file.parent_path());
  writeCloud(cloud, file);
}

std::vector<std::string> namesOf(const ObjectViews& views) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < views.size(); ++i) names.push_back(views.view(i).name);
  return names;
}

std::unique_ptr<ObjectViews> open(const fs::path& folder, const std::string& type = "auto",
                                  std::size_t least = 100) {
  ObjectViewsOptions options;
  options.type = type;
  options.minPoints = least;
  return openObjectViews(folder, options);
}

TEST(CloudViews, FolderIsACategoryAndInnerFoldersAreInstances) {
  const test::ScratchFolder folder;
  save(folder / "mug/mug_10.pcd", line(150, true));
  save(folder / "mug/mug_9.ply", line(120));
  save(folder / "bowl/red/a.pcd", line(110));
  save(folder / "bowl/blue/a.pcd", line(110));
  writeFile(folder / "README.md", "words");
  const auto views = open(folder.path());
  EXPECT_THAT(namesOf(*views),
              ElementsAre("bowl/blue/a.pcd", "bowl/red/a.pcd", "mug/mug_9.ply", "mug/mug_10.pcd"));
  EXPECT_EQ(views->view(1).instance, "bowl/red");
  EXPECT_EQ(views->view(1).category, "bowl");
  EXPECT_EQ(views->view(3).instance, "mug");
  EXPECT_EQ(views->view(3).split, "");
  EXPECT_EQ(views->cloud(3).points.size(), 150U);
  EXPECT_EQ(views->cloud(3).colors[7], cv::Vec3b(10, 20, 30));
  EXPECT_THAT(views->cloud(2).colors, IsEmpty());
  EXPECT_TRUE(views->image(0).image.empty());
  EXPECT_THAT(views->warnings(), IsEmpty());
}

TEST(CloudViews, BrokenAndSmallCloudsAreLeftOut) {
  const test::ScratchFolder folder;
  save(folder / "mug/whole.pcd", line(150));
  save(folder / "mug/small.pcd", line(99));
  PointCloud holes = line(150);
  for (std::size_t i = 0; i < 60; ++i) holes.points[i].x = std::numeric_limits<float>::quiet_NaN();
  save(folder / "mug/holes.pcd", holes);
  const std::string whole = test::readFile(folder / "mug/whole.pcd");
  writeFile(folder / "mug/cut.pcd", whole.substr(0, whole.size() / 2));
  writeFile(folder / "mug/huge.pcd",
            "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2000000000\nHEIGHT 1\nDATA binary\n");
  fs::create_directories(folder / "empty");
  const auto views = open(folder.path());
  EXPECT_THAT(namesOf(*views), ElementsAre("mug/whole.pcd"));
  EXPECT_THAT(views->warnings(), ElementsAre(Mentions({"4 of 5"})));
  EXPECT_EQ(open(folder.path(), "clouds", 90)->size(), 3U);
  EXPECT_THAT([&] { open(folder.path(), "clouds", 1000); }, FailsWith(ErrorCode::insufficientData));
  fs::remove(folder / "mug/whole.pcd");
  EXPECT_THAT([&] { views->cloud(0); }, FailsWith(ErrorCode::fileNotFound));
}

TEST(ObjectViews, WhatIsNoneSaysWhatIsRead) {
  const test::ScratchFolder folder;
  for (const char* type : {"samples", "clouds", "washington", "nyu"})
    EXPECT_THAT([&] { open(folder.path()); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { open(folder.path(), "cloud"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { open(folder / "none"); }, FailsWith(ErrorCode::fileNotFound));
  for (const auto& [type, explanation] : objectViewTypes())
    EXPECT_TRUE(test::caught([&, name = type] { open(folder.path(), name); }).code) << type;
  EXPECT_EQ(objectViewTypes().size(), 4U);
}

/// A frame of 64 × 48 pixels: two chairs (4), a table (6), a wall (0) around them, all at 3 m but a hole.
class NyuObjectViews : public ::testing::Test {
 protected:
  NyuObjectViews() {
    writeFile(folder_ / "classes40.txt", "0 wall\n1 floor\n2 cabinet\n3 bed\n4 chair\n5 sofa\n6 table\n");
    writeFile(folder_ / "scenes.csv", "index,split,scene\n0,train,kitchen\n1,test,office\n");
    frame(0);
  }
  void frame(int number) {
    marks_ = cv::Mat::zeros(48, 64, CV_8U);
    marks_({10, 10, 8, 20}).setTo(4);
    marks_({30, 10, 10, 10}).setTo(4);
    marks_({40, 20, 5, 5}).setTo(4);  // touches the one before at a corner
    marks_({20, 36, 40, 12}).setTo(6);
    marks_({2, 2, 2, 2}).setTo(4);  // too small
    depth_ = cv::Mat(48, 64, CV_8U, cv::Scalar(76));
    depth_({12, 12, 2, 2}).setTo(0);
    write(number, cv::Size(64, 48));
  }
  void write(int number, cv::Size image) {
    writeFile(folder_ / fmt::format("rgb/{:04}.png", number),
              encoded(".png", test::plain(image.width, image.height, {1, 2, 3})));
    writeFile(folder_ / fmt::format("depth/{:04}.png", number), encoded(".png", depth_));
    writeFile(folder_ / fmt::format("label/{:04}.png", number), encoded(".png", marks_));
  }
  test::ScratchFolder folder_;
  cv::Mat marks_, depth_;
};

TEST_F(NyuObjectViews, ComponentsOfClassesAreInstances) {
  const auto views = open(folder_.path(), "auto", 10);
  ASSERT_THAT(namesOf(*views), ElementsAre("0000_chair_1", "0000_chair_2", "0000_table_1"));
  const ObjectView& chair = views->view(0);
  EXPECT_EQ(chair.instance, "0000_chair_1");
  EXPECT_EQ(chair.category, "chair");
  EXPECT_EQ(chair.split, "train");
  EXPECT_EQ(chair.frame, "0000.png");
  EXPECT_FALSE(chair.atBorder);
  EXPECT_TRUE(views->view(2).atBorder);
  const ObjectImage seen = views->image(1);
  EXPECT_EQ(seen.image.size(), cv::Size(64, 48));
  EXPECT_EQ(seen.box, cv::Rect(30, 10, 15, 15));
  EXPECT_EQ(cv::countNonZero(seen.mask), 125);
  EXPECT_EQ(cv::countNonZero(seen.mask(seen.box)), 125);
  const PointCloud cloud = views->cloud(0);
  EXPECT_EQ(cloud.points.size(), 160U - 4U);
  EXPECT_EQ(cloud.colors[0], cv::Vec3b(1, 2, 3));
  const double z = 76 / 25.5, fx = 518.85790117450188 / 10, cx = (325.58244941119034 + 0.5) / 10 - 0.5;
  EXPECT_NEAR(cloud.points[0].z, z, 1e-5);
  EXPECT_NEAR(cloud.points[0].x, (10 - cx) / fx * z, 1e-5);
}

TEST_F(NyuObjectViews, FramesThatDoNotFitAreLeftOut) {
  frame(1);
  frame(2);
  frame(3);
  depth_ = cv::Mat(24, 32, CV_8U, cv::Scalar(76));
  write(1, {64, 48});
  const std::string label = test::readFile(folder_ / "label/0002.png");
  writeFile(folder_ / "label/0002.png", label.substr(0, label.size() / 2));
  fs::remove(folder_ / "label/0003.png");
  const auto views = open(folder_.path(), "nyu", 10);
  EXPECT_EQ(views->size(), 3U);
  EXPECT_THAT(views->warnings(), ElementsAre(Mentions({"3 of 4", "0001.png"})));
  depth_ = cv::Mat(48, 64, CV_8U, cv::Scalar(76));
  write(0, {32, 24});
  EXPECT_THAT([&] { views->image(0); }, FailsWith(ErrorCode::mismatch));
  marks_.setTo(0);
  write(0, {64, 48});
  EXPECT_THAT([&] { views->cloud(0); }, FailsWith(ErrorCode::invalidState));
  cv::Mat colors(48, 64, CV_8UC3, cv::Scalar(1, 2, 3));
  writeFile(folder_ / "label/0000.png", encoded(".png", colors));
  EXPECT_THAT([&] { views->image(0); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(NyuObjectViews, ClassesMustBeNamedInOrder) {
  const auto problem = [&](const std::string& classes) {
    writeFile(folder_ / "classes40.txt", classes);
    return test::caught([&] { open(folder_.path(), "nyu", 10); });
  };
  EXPECT_FALSE(problem("wall\nfloor\ncabinet\nbed\nchair\n").code);
  for (const char* classes : {"0 wall\n2 floor\n", "0 wall paper\n", "chair\nchair\n"})
    EXPECT_THAT(problem(classes), FailsWith(ErrorCode::malformedFile)) << classes;
  for (const char* classes : {"\n", "wall\nfloor\n"})
    EXPECT_THAT(problem(classes), FailsWith(ErrorCode::insufficientData)) << classes;
}

TEST(RealObjectViews, NyuHasTheThingsOfTheStudy) {
  const auto folder = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(folder, "nyuv2_half is not there");
  const auto views = openObjectViews(*folder);
  std::map<std::string, int> counts, splits;
  for (std::size_t i = 0; i < views->size(); ++i) {
    ++counts[views->view(i).category];
    ++splits[views->view(i).split];
  }
  EXPECT_EQ(counts["chair"], 710);
  EXPECT_EQ(counts["bathtub"], 43);
  EXPECT_EQ(counts["refridgerator"], 75);
  EXPECT_FALSE(counts.contains("wall"));
  EXPECT_EQ(splits.size(), 2U);
  EXPECT_GE(views->cloud(views->size() - 1).points.size(), 600U);
}

}  // namespace
}  // namespace estancia
