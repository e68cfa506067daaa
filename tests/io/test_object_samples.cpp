// Folders that `estancia objects collect` fills, sound and hostile.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/io/object_samples.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/io/cloud_file.hpp"
#include "estancia/io/image_writer.hpp"
#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::Mentions;
using test::writeFile;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::string kStart =
    "# estancia object samples 1\nname,instance,category,split,frame,x,y,width,height,flat,at_border\n";

test::Caught problemWith(const std::string& rows) {
  const test::ScratchFolder folder;
  writeFile(folder / "samples.csv", kStart + rows);
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
  fs::create_directories(folder / "clouds");
  writePng(test::plain(10, 10, {1, 2, 3}), imageOf(folder, name));
  PointCloud cloud;
  cloud.points.assign(points, {1, 2, 3});
  cloud.width = points;
  cloud.height = 1;
  writeCloud(cloud, cloudOf(folder, name));
}

TEST(ObjectSamples, ReadBackAsWritten) {
  const test::ScratchFolder folder;
  EXPECT_FALSE(isObjectSamples(folder.path()));
  writeObjectSamples({sample("a 1"), sample("ü")}, folder.path());
  EXPECT_TRUE(isObjectSamples(folder.path()));
  const auto read = readObjectSamples(folder.path());
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[1].view.name, "ü");
  EXPECT_EQ(read[0].view.instance, "7");
  EXPECT_EQ(read[0].view.category, "coffee \"mug\", large");
  EXPECT_EQ(read[0].view.split, "train");
  EXPECT_EQ(read[0].view.frame, "frame 000012");
  EXPECT_EQ(read[0].box, cv::Rect(2, 3, 4, 5));
  EXPECT_TRUE(read[0].view.flat);
  EXPECT_FALSE(read[0].view.atBorder);
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
  const auto problem = [&](const std::string& text) {
    writeFile(folder / "samples.csv", text);
    return test::caught([&] { readObjectSamples(folder.path()); });
  };
  EXPECT_THAT(problem(""), FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT(problem("# estancia object samples 1\n"), FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT(problem("name,instance\n"), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(problem("# estancia object samples 2\n"), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(problem("# estancia object samples 1\nname,instance\n"), FailsWith(ErrorCode::malformedFile));
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
  EXPECT_EQ(views->view(2).name, "c");
  EXPECT_EQ(views->view(2).instance, "7");
  EXPECT_TRUE(views->view(2).flat);
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

}  // namespace
}  // namespace estancia
