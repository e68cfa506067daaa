// Views of objects in clouds and in NYU's labeled frames: made up, and the real ones.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/object_samples.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "estancia/files/cloud_file.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/readers/object_views.hpp"
#include "support/clouds.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::encoded;
using test::FailsWith;
using test::Mentions;
using test::writeFile;
using ::testing::_;
using ::testing::ElementsAre;
using ::testing::FieldsAre;
using ::testing::IsEmpty;

PointCloud line(std::size_t count, bool colored = false) {
  std::vector<cv::Point3f> points;
  for (std::size_t i = 0; i < count; ++i) points.emplace_back(static_cast<float>(i), 1, 2);
  return test::cloudOf(std::move(points), std::vector<cv::Vec3b>(colored ? count : 0, {10, 20, 30}));
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
  EXPECT_THAT(views->view(1), FieldsAre("bowl/red/a.pcd", "bowl/red", "bowl", "", _, false, false));
  EXPECT_THAT(views->view(3), FieldsAre("mug/mug_10.pcd", "mug", "mug", "", _, false, false));
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

TEST(ObjectViews, WhatIsNoneIsRefused) {
  const test::ScratchFolder folder;
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
  EXPECT_THAT(views->view(0),
              FieldsAre("0000_chair_1", "0000_chair_1", "chair", "train", "0000.png", false, false));
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
}

const std::string start =
    "# estancia object samples 1\nname,instance,category,split,frame,x,y,width,height,flat,at_border\n";

test::Caught problemWith(const std::string& rows) {
  const test::ScratchFolder folder;
  writeFile(folder / "samples.csv", start + rows);
  return test::caught([&] { readObjectSamples(folder.path()); });
}

ObjectSample sample(const std::string& name) {
  ObjectSample sample;
  sample.view = {name, "7", "coffee \"mug\", large", "train", "frame 000012", true, false};
  sample.box = {2, 3, 4, 5};
  return sample;
}

void save(const fs::path& folder, const std::string& name, std::size_t points = 120) {
  fs::create_directories(folder / "images");
  writePng(test::plain(10, 10, {1, 2, 3}), imageOf(folder, name));
  save(cloudOf(folder, name), line(points));
}

TEST(ObjectSamples, ReadBackAsWritten) {
  const test::ScratchFolder folder;
  EXPECT_FALSE(isObjectSamples(folder.path()));
  writeObjectSamples({sample("a 1"), sample("ü")}, folder.path());
  EXPECT_TRUE(isObjectSamples(folder.path()));
  const auto read = readObjectSamples(folder.path());
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[1].view.name, "ü");
  EXPECT_THAT(read[0].view,
              FieldsAre("a 1", "7", "coffee \"mug\", large", "train", "frame 000012", true, false));
  EXPECT_EQ(read[0].box, cv::Rect(2, 3, 4, 5));
  ObjectSample odd = sample("b");
  odd.view.category = "\x1b";
  for (const auto& wrong : {std::vector{sample("a"), sample("a")}, {sample("a"), odd}})
    EXPECT_THAT([&] { writeObjectSamples(wrong, folder.path()); }, FailsWith(ErrorCode::invalidInput));
  writeObjectSamples({}, folder.path());
  EXPECT_THAT(readObjectSamples(folder.path()), IsEmpty());
}

TEST(ObjectSamples, NamesStayInTheFolder) {
  const test::ScratchFolder folder;
  for (const std::string& name :
       {std::string(), std::string(".."), std::string(".hidden"), std::string("../a"), std::string("/etc/a"),
        std::string("a/b"), std::string("a\\b"), std::string("a\x01"), std::string("a\xff"),
        std::string(201, 'a')}) {
    EXPECT_THAT(problemWith("\"" + name + "\",1,,,,0,0,1,1,0,0\n"), FailsWith(ErrorCode::malformedFile))
        << name;
    EXPECT_THAT([&] { writeObjectSamples({sample(name)}, folder.path()); },
                FailsWith(ErrorCode::invalidInput))
        << name;
    EXPECT_FALSE(fs::exists(folder / "samples.csv"));
  }
  EXPECT_FALSE(problemWith(std::string(200, 'a') + ",1,,,,0,0,1,1,0,0\n").code);
}

TEST(ObjectSamples, RefusesWhatIsNoSample) {
  EXPECT_FALSE(problemWith("a,1,,,,0,0,1,1,0,0\n").code);
  for (const std::string& rows :
       {std::string("a,1,,,,0,0,1,1,0,0\nb,1,,,,0,0,1,1,0,0\na,2,,,,0,0,1,1,0,0\n"),
        std::string("a,1,,,,0,0,1,1,0\n"), std::string("a,,,,,0,0,1,1,0,0\n"),
        std::string("a,1,,,,0,0,0,1,0,0\n"), std::string("a,1,,,,0,0,1,1,yes,0\n"),
        std::string("a,1,,,,0,0,1,1,0,2\n"), std::string("a\0,1,,,,0,0,1,1,0,0\n", 20),
        std::string("\"a,1,,,,0,0,1,1,0,0\n")})
    EXPECT_THAT(problemWith(rows), FailsWith(ErrorCode::malformedFile)) << rows;
  for (const char* number : {"", "-1", "1.5", "nan", "65536", "99999999999999999999", "1 "})
    EXPECT_THAT(problemWith(std::string("a,1,,,,\"") + number + "\",0,1,1,0,0\n"),
                FailsWith(ErrorCode::malformedFile));
}

TEST(ObjectSamples, RefusesOtherListsAndVersions) {
  const test::ScratchFolder folder;
  for (const auto& [text, code] : std::vector<std::pair<std::string, ErrorCode>>{
           {"", ErrorCode::truncatedFile},
           {"# estancia object samples 1\n", ErrorCode::truncatedFile},
           {"name,instance\n", ErrorCode::unsupportedFile},
           {"# estancia object samples 2\n", ErrorCode::unsupportedFile},
           {"# estancia object samples 1\nname,instance\n", ErrorCode::malformedFile}}) {
    writeFile(folder / "samples.csv", text);
    EXPECT_THAT([&] { readObjectSamples(folder.path()); }, FailsWith(code)) << text;
  }
  EXPECT_THAT([&] { readObjectSamples(folder / "none"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST(ObjectSamples, AreViews) {
  const test::ScratchFolder folder;
  for (const char* name : {"a", "b", "c"}) save(folder.path(), name);
  std::vector<ObjectSample> samples = {sample("a"), sample("b"), sample("c"), sample("d"), sample("e")};
  samples[1].box = {8, 8, 4, 1};
  save(folder.path(), "e");
  fs::remove(cloudOf(folder.path(), "e"));
  writeObjectSamples(samples, folder.path());
  const auto views = openObjectViews(folder.path());
  ASSERT_EQ(views->size(), 3U);
  EXPECT_THAT(views->warnings(), ElementsAre(Mentions({"2 of 5", "d.png"})));
  EXPECT_THAT(views->view(2), FieldsAre("c", "7", _, _, _, true, false));
  EXPECT_EQ(views->cloud(0).points.size(), 120U);
  EXPECT_EQ(views->image(0).box, cv::Rect(2, 3, 4, 5));
  EXPECT_EQ(views->image(0).image.at<cv::Vec3b>(0, 0), cv::Vec3b(1, 2, 3));
  EXPECT_THAT([&] { views->image(1); }, FailsWith(ErrorCode::mismatch));
  const std::string png = test::readFile(imageOf(folder.path(), "a"));
  writeFile(imageOf(folder.path(), "a"), png.substr(0, png.size() / 2));
  EXPECT_THAT([&] { views->image(0); }, FailsWith(ErrorCode::truncatedFile));
  save(folder.path(), "c", 99);
  EXPECT_THAT([&] { views->cloud(2); }, FailsWith(ErrorCode::insufficientData));
  for (const char* name : {"a", "b", "c"}) fs::remove(imageOf(folder.path(), name));
  EXPECT_THAT([&] { openObjectViews(folder.path()); }, FailsWith(ErrorCode::insufficientData));
}

class Washington : public ::testing::Test {
 protected:
  /// 20 × 10 pixels that begin in column 101 and row 201 (from 1); the thing fills all but the first 2
  /// columns, 1.5 m away, except for a hole.
  void view(const std::string& stem, const std::string& place = "101,201\n", int depthType = CV_16U) {
    cv::Mat mask(10, 20, CV_8U, cv::Scalar(255)), depth(10, 20, depthType, cv::Scalar(1500));
    mask({0, 0, 2, 10}).setTo(0);
    depth({2, 0, 1, 1}).setTo(0);
    write(stem + "_crop.png", encoded(".png", test::plain(20, 10, {1, 2, 3})));
    write(stem + "_depthcrop.png", encoded(".png", depth));
    write(stem + "_maskcrop.png", encoded(".png", mask));
    write(stem + "_loc.txt", place);
  }
  void write(const std::string& name, const std::string& bytes) { writeFile(folder_ / name, bytes); }
  std::unique_ptr<ObjectViews> open() { return openObjectViews(folder_.path()); }
  test::ScratchFolder folder_;
};

TEST_F(Washington, NamesAreReadFromTheRight) {
  view("bell_pepper/bell_pepper_1/bell_pepper_1_2_37");
  view("bell_pepper/bell_pepper_1/bell_pepper_1_2_9");
  view("bell_pepper/bell_pepper_12/bell_pepper_12_1_1");
  view("apple/apple_3/apple_3_4_1");
  view("apple/apple_3/apple_3_1");    // no video
  view("apple/apple_3/apple_1_4_1");  // image of another thing
  view("apple/pear_1/pear_1_1_1");    // in another category
  view("apple/apple_x/apple_x_1_1");  // no number
  write("README.txt", "words");
  const auto views = open();
  EXPECT_THAT(namesOf(*views),
              ElementsAre("apple_3_4_1", "bell_pepper_1_2_9", "bell_pepper_1_2_37", "bell_pepper_12_1_1"));
  const std::string seen = "bell_pepper_1_2_37";
  EXPECT_THAT(views->view(2), FieldsAre(seen, "bell_pepper_1", "bell_pepper", _, seen, false, false));
  EXPECT_THAT(views->warnings(), IsEmpty());
}

TEST_F(Washington, PointsAreMetricInTheWholeImage) {
  view("mug/mug_1/mug_1_1_1");
  view("mug/mug_1/mug_1_1_2", "1 1");
  const auto views = open();
  const PointCloud cloud = views->cloud(0);
  ASSERT_EQ(cloud.points.size(), 18U * 10U - 1U);
  EXPECT_FLOAT_EQ(cloud.points[0].z, 1.5F);  // column 103, counted from 0, of row 200
  EXPECT_NEAR(cloud.points[0].x, (103 - 320) / 570.3 * 1.5, 1e-6);
  EXPECT_NEAR(cloud.points[0].y, (200 - 240) / 570.3 * 1.5, 1e-6);
  EXPECT_EQ(cloud.colors[0], cv::Vec3b(1, 2, 3));
  EXPECT_NEAR(views->cloud(1).points[0].x, (3 - 320) / 570.3 * 1.5, 1e-6);
  const ObjectImage seen = views->image(0);
  EXPECT_EQ(seen.image.size(), cv::Size(20, 10));
  EXPECT_EQ(seen.box, cv::Rect(2, 0, 18, 10));
  EXPECT_EQ(cv::countNonZero(seen.mask), 180);
}

TEST_F(Washington, IncompleteViewsAreLeftOut) {
  for (const char* stem :
       {"mug/mug_1/mug_1_1_1", "mug/mug_1/mug_1_1_2", "mug/mug_1/mug_1_1_3", "mug/mug_1/mug_1_1_4"})
    view(stem);
  fs::remove(folder_ / "mug/mug_1/mug_1_1_1_maskcrop.png");
  fs::remove(folder_ / "mug/mug_1/mug_1_1_2_loc.txt");
  fs::remove(folder_ / "mug/mug_1/mug_1_1_3_depthcrop.png");
  const auto views = open();
  EXPECT_THAT(namesOf(*views), ElementsAre("mug_1_1_4"));
  EXPECT_THAT(views->warnings(), ElementsAre(Mentions({"3 of 4", "mug_1_1_1_maskcrop.png"})));
  fs::remove(folder_ / "mug/mug_1/mug_1_1_4_loc.txt");
  EXPECT_THAT([&] { open(); }, FailsWith(ErrorCode::insufficientData));
}

TEST_F(Washington, MasksAndIntrinsicsAreThoseOfTheFolder) {
  view("mug/mug_1/mug_1_1_1");
  write("intrinsics.txt", "500 500 300 200\n");
  EXPECT_NEAR(open()->cloud(0).points[0].x, (103 - 300) / 500.0 * 1.5, 1e-6);
  for (const auto& [size, code] :
       {std::pair(cv::Size(20, 10), ErrorCode::malformedFile), {cv::Size(10, 10), ErrorCode::mismatch}}) {
    write("mug/mug_1/mug_1_1_1_maskcrop.png", encoded(".png", cv::Mat::zeros(size, CV_8U)));
    EXPECT_THAT([&] { open()->image(0); }, FailsWith(code)) << size;
  }
}

TEST_F(Washington, WrongPlacesAreRefused) {
  const auto refusal = [&](const char* place) {
    view("mug/mug_1/mug_1_1_1", place);
    return test::caught([&] { open()->cloud(0); });
  };
  for (const char* place : {"", "1", "1,2,3", "x,y", "0,1", "-5,3", "nan,1", "1e9,1"})
    EXPECT_THAT(refusal(place), FailsWith(ErrorCode::malformedFile)) << place;
  for (const char* place : {"630,1", "1,480"})
    EXPECT_THAT(refusal(place), FailsWith(ErrorCode::mismatch)) << place;
}

TEST_F(NyuObjectViews, ClassesMustBeNamedInOrder) {
  const auto problem = [&](const std::string& classes) {
    writeFile(folder_ / "classes40.txt", classes);
    return test::caught([&] { open(folder_.path(), "nyu", 10); });
  };
  EXPECT_FALSE(problem("wall\nfloor\ncabinet\nbed\nchair\n").code);
  EXPECT_THAT(problem("0 wall\n2 floor\n"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(problem("0 wall paper\n"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(problem("chair\nchair\n"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(problem("\n"), FailsWith(ErrorCode::insufficientData));
  std::string many;
  for (int i = 0; i < 257; ++i) many += fmt::format("c{}\n", i);
  EXPECT_THAT(problem(many), FailsWith(ErrorCode::tooLarge));
  EXPECT_THAT(problem("wall\nfloor\n"), FailsWith(ErrorCode::insufficientData));  // no chairs, then
}

}  // namespace
}  // namespace estancia
