#include "experiments/src/recognition/model_pairs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/error.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::errorOf;
using test::findData;
using test::ScratchFolder;
using test::writeFile;
using testing::HasSubstr;

constexpr const char* shifted = "1 0 0 0.1\n0 1 0 0.2\n0 0 1 0.3\n0 0 0 1\n";

class ModelPairsTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* cloud : {"hall.pcd", "lab.pcd", "mug.pcd", "cup.pcd"}) writeFile(scratch / cloud, "");
    writeFile(scratch / "pose.txt", shifted);
  }
  ModelPairs read(const std::string& rows, const std::string& head = "scene,object,model,pose",
                  const ModelPairsOptions& options = {}) {
    writeFile(scratch / "list.csv", head + "\n" + rows);
    return readModelPairs(scratch / "list.csv", options);
  }
  std::string error(const std::string& rows, const std::string& head = "scene,object,model,pose") {
    return errorOf([&] { read(rows, head); });
  }
  ScratchFolder scratch;
};

TEST_F(ModelPairsTest, KnowsScenesModelsAndPoses) {
  const auto found = read(
      "hall.pcd,mug,mug.pcd,pose.txt\nlab.pcd,mug,mug.pcd,pose.txt\n"
      "hall.pcd,cup,cup.pcd,pose.txt\nhall.pcd,mug,mug.pcd,pose.txt\n");
  ASSERT_EQ(found.scenes.size(), 2U);
  ASSERT_EQ(found.models.size(), 2U);
  ASSERT_EQ(found.pairs.size(), 3U);
  EXPECT_EQ(found.scenes[1].name, "lab.pcd");
  EXPECT_EQ(found.models[0].name, "mug");
  EXPECT_EQ(found.models[1].file, scratch / "cup.pcd");
  EXPECT_EQ(found.pairs[0].poses.size(), 2U) << "the scene holds it twice";
  EXPECT_EQ(found.pairs[1].poses.size(), 1U);
  EXPECT_EQ(found.pairs[0].poses[0].translation(), cv::Vec3d(0.1, 0.2, 0.3));
  EXPECT_TRUE(found.holds(0, "cup"));
  EXPECT_FALSE(found.holds(1, "cup"));
}

TEST_F(ModelPairsTest, SomeScenesMayBeChosen) {
  const auto all = read(
      "hall.pcd,mug,mug.pcd,pose.txt\nlab.pcd,mug,mug.pcd,pose.txt\n"
      "hall.pcd,cup,cup.pcd,pose.txt\n");
  const auto lab = onlyScenes(all, {"lab.pcd"});
  ASSERT_EQ(lab.scenes.size(), 1U);
  ASSERT_EQ(lab.pairs.size(), 1U);
  EXPECT_EQ(lab.pairs[0].scene, 0U);
  EXPECT_EQ(lab.models.size(), 2U);
  EXPECT_FALSE(lab.holds(0, "cup"));
  EXPECT_EQ(onlyScenes(all, {"lab.pcd", "hall.pcd"}).pairs.size(), 3U);
  EXPECT_THAT(errorOf([&] { onlyScenes(all, {"attic"}); }),
              HasSubstr("no scene of the pairs is called \"attic\""));
}

TEST_F(ModelPairsTest, ColumnsAndFilesMayBeCalledOtherwise) {
  const auto found = read("hall,1,mug,mug.pcd,pose.txt,0.7\nlab,0,cup,cup.pcd,none.txt,0.7\n",
                          "scene,scene_present,object,mesh,xf,overlap", {"mesh", "xf", "{}.pcd"});
  EXPECT_EQ(found.scenes.size(), 1U);
  EXPECT_EQ(found.scenes[0].file, scratch / "hall.pcd");
  EXPECT_EQ(found.leftOut, 1U);
  EXPECT_EQ(found.models.size(), 2U) << "a model may be looked for where it is not";
}

TEST_F(ModelPairsTest, ModelsOfOneFileNameKeepTheirFolders) {
  std::filesystem::create_directory(scratch / "other");
  writeFile(scratch / "other/mug.pcd", "");
  const auto found = read("hall.pcd,mug,mug.pcd,pose.txt\nhall.pcd,beer mug,other/mug.pcd,pose.txt\n");
  EXPECT_EQ(found.models[0].name, "mug.pcd");
  EXPECT_EQ(found.models[1].name, "other/mug.pcd");
}

TEST_F(ModelPairsTest, WrongListsAreRefusedWithTheirLine) {
  EXPECT_THAT(error(""), HasSubstr("there are no pairs"));
  EXPECT_THAT(error("hall.pcd,mug,mug.pcd\n", "scene,object,model"),
              HasSubstr("list.csv:1: there is no column \"pose\"; there are scene, object, model"));
  EXPECT_THAT(error("hall.pcd,mug,mug.pcd,pose.txt\n", "scene,scene,model,pose"), HasSubstr("twice"));
  EXPECT_THAT(error("hall.pcd,mug\n"), HasSubstr("list.csv:2: there is nothing in the column \"model\""));
  EXPECT_THAT(error("hall.pcd,,mug.pcd,pose.txt\n"), HasSubstr("nothing in the column \"object\""));
  EXPECT_THAT(error("attic.pcd,mug,mug.pcd,pose.txt\n"), HasSubstr("list.csv:2: there is no file"));
  EXPECT_THAT(error("hall.pcd,mug,mug.pcd,pose.txt\nhall.pcd,cup,mug.pcd,pose.txt\n"),
              HasSubstr("list.csv:3: mug.pcd is a model of \"cup\" here and of \"mug\" above"));
  EXPECT_THAT(error("hall.pcd,0,mug,mug.pcd,pose.txt\n", "scene,scene_present,object,model,pose"),
              HasSubstr("the scene of no pair is there"));
}

TEST_F(ModelPairsTest, WrongPosesAreRefused) {
  const auto poseError = [&](const std::string& text) {
    writeFile(scratch / "pose.txt", text);
    return error("hall.pcd,mug,mug.pcd,pose.txt\n");
  };
  EXPECT_THAT(poseError(""), HasSubstr("pose.txt: there are 0 numbers"));
  EXPECT_THAT(poseError("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0"), HasSubstr("15 numbers"));
  EXPECT_THAT(poseError("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 one"), HasSubstr("\"one\" is no number"));
  EXPECT_THAT(poseError("1 0 0 nan 0 1 0 0 0 0 1 0 0 0 0 1"), HasSubstr("\"nan\" is no number"));
  EXPECT_THAT(poseError("1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1"), HasSubstr("the rotation is none")) << "mirrored";
  EXPECT_THAT(poseError("1000 0 0 0 0 1000 0 0 0 0 1000 0 0 0 0 1"), HasSubstr("the rotation is none"));
  EXPECT_THAT(poseError("1 0 0 0 0 1 0 0 0 0 1 0 5 0 0 1"), HasSubstr("the last row"));
  EXPECT_THAT(poseError(std::string(1 << 17, '1')), HasSubstr("pose.txt"));
}

TEST(ModelPairs, OfTheThesisData) {
  const auto data = findData("shot_kinect");
  ESTANCIA_NEEDS(data, "shot_kinect is not here");
  const auto found = readModelPairs(*data / "gt.csv", {"mesh_ply", "xf", "scenes/{}.pcd"});
  EXPECT_EQ(found.scenes.size(), 16U);
  EXPECT_EQ(found.models.size(), 28U);
  EXPECT_EQ(found.pairs.size(), 46U);
  EXPECT_EQ(found.leftOut, 3U);
}

}  // namespace
}  // namespace estancia::experiments
