// Scenes with marks of their objects: made up, and the real ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "experiments/src/objects/object_scenes.hpp"
#include "io/images.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::encoded;
using test::errorOf;
using test::writeFile;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
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
  EXPECT_THAT(problems, ElementsAre(AllOf(HasSubstr("1 of 3 scenes"), HasSubstr("learn1_rgb.jpg"))));
  const cv::Mat objects = readObjectMask(scenes[0].mask);
  EXPECT_THAT(std::vector<int>(objects.begin<int>(), objects.end<int>()), ElementsAre(0, 0, 0, 2, 2, 25));
  EXPECT_NE(errorOf([&] { readObjectMask(scenes[0].depth); }), "");
  writeFile(folder / "deep.png", encoded(".png", cv::Mat(2, 2, CV_16U, cv::Scalar(20))));
  EXPECT_THAT(errorOf([&] { readObjectMask(folder / "deep.png"); }), HasSubstr("8 bits"));
}

TEST(ObjectScenes, ListsThatAreWrong) {
  const test::ScratchFolder folder;
  const auto problem = [&](const std::string& index) {
    writeFile(folder / "index.csv", index);
    return errorOf([&] { readObjectScenes(folder.path()); });
  };
  EXPECT_THAT(problem("scene,n\n"), HasSubstr("index.csv:1: the header has no columns"));
  EXPECT_THAT(problem("split,n\nlearn\n"), HasSubstr("index.csv:2: 1 cells"));
  EXPECT_THAT(problem("split,n\n../learn,0\n"), HasSubstr("index.csv:2: `split` and `n`"));
  EXPECT_THAT(problem("split,n\nlearn,/0\n"), HasSubstr("index.csv:2: `split` and `n`"));
  EXPECT_THAT(problem("split,n\nlearn,0\nlearn,0\n"),
              HasSubstr("index.csv:3: the scene learn0 is there twice"));
  EXPECT_THAT(problem("split,n\nlearn,0\n"),
              AllOf(HasSubstr("there is no scene"), HasSubstr("learn0_rgb.jpg")));
  EXPECT_THAT(problem("split,n\n"), HasSubstr("there is no scene"));
  EXPECT_THAT(problem(""), HasSubstr("empty"));
  EXPECT_THAT(errorOf([&] { readObjectScenes(folder / "none"); }), HasSubstr("index.csv"));
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
