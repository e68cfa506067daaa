// Scenes with marks of their objects: made up, and the real ones.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "objects/object_scenes.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::encoded;
using test::FailsWith;
using test::Mentions;
using test::writeFile;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ObjectScenes, ListsWhatIsThere) {
  const test::ScratchFolder folder;
  writeFile(folder / "index.csv",
            "split,n,category,objects\nlearn,0,boxes,2\nlearn,1,boxes,1\ntest,0,mixed,3\n");
  cv::Mat marks(2, 3, CV_8U);
  std::copy_n(std::vector<uchar>{0, 1, 19, 20, 29, 255}.begin(), 6, marks.begin<uchar>());
  for (const char* name : {"learn/learn0", "test/test0"}) {
    writeFile(folder / (std::string(name) + "_rgb.jpg"), "jpg");
    writeFile(folder / (std::string(name) + "_depth.png"), "png");
    writeFile(folder / (std::string(name) + "_label.png"), encoded(".png", marks));
  }
  std::vector<std::string> problems;
  const auto scenes = readObjectScenes(folder.path(), &problems);
  ASSERT_EQ(scenes.size(), 2U);
  EXPECT_EQ(scenes[1].name, "test0");
  EXPECT_EQ(scenes[1].category, "mixed");
  EXPECT_THAT(problems, ElementsAre(Mentions({"1 of 3", "learn1_rgb.jpg"})));
  const cv::Mat objects = readObjectMask(scenes[0].mask);
  EXPECT_THAT(std::vector<int>(objects.begin<int>(), objects.end<int>()), ElementsAre(0, 0, 0, 2, 2, 25));
  EXPECT_TRUE(test::caught([&] { readObjectMask(scenes[0].depth); }).code);
  writeFile(folder / "deep.png", encoded(".png", cv::Mat(2, 2, CV_16U, cv::Scalar(20))));
  EXPECT_THAT([&] { readObjectMask(folder / "deep.png"); },
              FailsWith(ErrorCode::unsupportedFile, "deep.png"));
}

TEST(ObjectScenes, ListsThatAreWrong) {
  const test::ScratchFolder folder;
  const auto problem = [&](const std::string& index) {
    writeFile(folder / "index.csv", index);
    return test::caught([&] { readObjectScenes(folder.path()); });
  };
  EXPECT_THAT(problem("scene,n\n0,0\n"), FailsWith(ErrorCode::malformedFile, "index.csv:1", "\"split\""));
  EXPECT_THAT(problem("split,n\nlearn\n"), FailsWith(ErrorCode::malformedFile, "index.csv:2: 1", "2"));
  EXPECT_THAT(problem("split,n\n../learn,0\n"),
              FailsWith(ErrorCode::malformedFile, "index.csv:2: `split`", "`n`"));
  EXPECT_THAT(problem("split,n\nlearn,/0\n"),
              FailsWith(ErrorCode::malformedFile, "index.csv:2: `split`", "`n`"));
  EXPECT_THAT(problem("split,n\nlearn,0\nlearn,0\n"),
              FailsWith(ErrorCode::malformedFile, "index.csv:3", "learn0"));
  EXPECT_THAT(problem("split,n\nlearn,0\n"), FailsWith(ErrorCode::insufficientData, "learn0_rgb.jpg"));
  EXPECT_THAT(problem("split,n\n"), FailsWith(ErrorCode::insufficientData, "index.csv"));
  EXPECT_THAT(problem(""), FailsWith(ErrorCode::insufficientData, "index.csv"));
  EXPECT_THAT([&] { readObjectScenes(folder / "none"); }, FailsWith(ErrorCode::fileNotFound, "index.csv"));
}

TEST(ObjectScenes, OfTheMultiObjectSceneDataset) {
  const auto folder = test::findData("mosd_rgbd");
  ESTANCIA_NEEDS(folder, "mosd_rgbd is not there");
  std::vector<std::string> problems;
  const auto scenes = readObjectScenes(*folder, &problems);
  EXPECT_EQ(scenes.size(), 45U);
  EXPECT_THAT(problems, IsEmpty());
  const cv::Mat mask = readObjectMask(scenes[0].mask);
  EXPECT_EQ(mask.size(), cv::Size(640, 480));
  EXPECT_EQ(cv::countNonZero(mask == 2), 20792);
  EXPECT_EQ(cv::countNonZero(mask == 3), 8177);
}

}  // namespace
}  // namespace estancia::experiments
