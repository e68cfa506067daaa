// SPDX-License-Identifier: Apache-2.0
#include "recognition/model_pairs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/error.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::findData;
using test::ScratchFolder;
using test::writeFile;

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
  test::Caught error(const std::string& rows, const std::string& head = "scene,object,model,pose") {
    return test::caught([&] { read(rows, head); });
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
  EXPECT_THAT([&] { onlyScenes(all, {"attic"}); }, FailsWith(ErrorCode::unknownName, "attic"));
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

TEST_F(ModelPairsTest, ThePublishedPairingIsRead) {
  // the whole download, and the files of one folder beside each other
  for (const std::string meshes : {"Kinect/Meshes/Mario/", "Kinect/Scenes/config/"}) {
    const ScratchFolder root;
    writeFile(root / (meshes + "mario000.ply"), "");
    writeFile(root / "Kinect/Scenes/2011/scene001.ply", "");
    writeFile(root / "Kinect/Scenes/config/scene001-rs0.xf", shifted);
    writeFile(root / "Kinect/Scenes/config/Configscene001.ini",
              "[MODELS]\nNUMBER = 1\n\nMODEL_0 = \"/3D models/Kinect/Meshes/Mario/mario000.ply\"\n"
              "MODEL_0_GROUNDTRUTH = \"/3D models/Kinect/Scenes/2011/config/scene001-rs0.xf\"\n[SCENE]\n"
              "PATH = \"/3D models/Kinect/Scenes/2011/scene001.ply\"\nGT_THRESHOLD = 5\n");
    const auto found = readModelPairs(root / "Kinect/Scenes/config");
    ASSERT_EQ(found.pairs.size(), 1U) << meshes;
    EXPECT_EQ(found.scenes[0].name, "scene001");
    EXPECT_EQ(found.models[0].name, "mario000");
    EXPECT_EQ(found.models[0].object, std::filesystem::path(meshes).parent_path().filename().string());
    EXPECT_EQ(found.pairs[0].poses[0].translation(), cv::Vec3d(0.1, 0.2, 0.3));
  }
}

TEST_F(ModelPairsTest, APairingThatNamesNoFileIsRefused) {
  writeFile(scratch / "Configscene001.ini", "MODEL_0 = \"mug.pcd\"\nPATH = \"../../etc/hostname\"\n");
  EXPECT_THAT([&] { readModelPairs(scratch.path()); }, FailsWith(ErrorCode::fileNotFound, "hostname"));
  writeFile(scratch / "Configscene001.ini", "MODEL_0 = \"mug.pcd\"\nPATH = \"hall.pcd\"\n");
  EXPECT_THAT([&] { readModelPairs(scratch.path()); },
              FailsWith(ErrorCode::malformedFile, "MODEL_0_GROUNDTRUTH"));
  std::filesystem::remove(scratch / "Configscene001.ini");
  EXPECT_THAT([&] { readModelPairs(scratch.path()); }, FailsWith(ErrorCode::insufficientData));
}

TEST_F(ModelPairsTest, WrongListsAreRefusedWithTheirLine) {
  EXPECT_THAT(error(""), FailsWith(ErrorCode::insufficientData, "list.csv"));
  EXPECT_THAT(error("hall.pcd,mug,mug.pcd\n", "scene,object,model"),
              FailsWith(ErrorCode::malformedFile, "list.csv:1", "\"pose\"", "scene, object, model"));
  EXPECT_THAT(error("hall.pcd,mug,mug.pcd,pose.txt\n", "scene,scene,model,pose"),
              FailsWith(ErrorCode::malformedFile, "list.csv:1", "\"scene\""));
  EXPECT_THAT(error("hall.pcd,mug\n"), FailsWith(ErrorCode::malformedFile, "list.csv:2: 2", "4"));
  EXPECT_THAT(error("hall.pcd,,mug.pcd,pose.txt\n"),
              FailsWith(ErrorCode::malformedFile, "list.csv:2", "\"object\""));
  EXPECT_THAT(error("attic.pcd,mug,mug.pcd,pose.txt\n"),
              FailsWith(ErrorCode::malformedFile, "list.csv:2", "attic.pcd"));
  EXPECT_THAT(error("hall.pcd,mug,mug.pcd,pose.txt\nhall.pcd,cup,mug.pcd,pose.txt\n"),
              FailsWith(ErrorCode::malformedFile, "list.csv:3", "mug.pcd", "\"cup\"", "\"mug\""));
  EXPECT_THAT(error("hall.pcd,0,mug,mug.pcd,pose.txt\n", "scene,scene_present,object,model,pose"),
              FailsWith(ErrorCode::insufficientData, "scene_present"));
}

TEST_F(ModelPairsTest, WrongPosesAreRefused) {
  const auto poseError = [&](const std::string& text) {
    writeFile(scratch / "pose.txt", text);
    return error("hall.pcd,mug,mug.pcd,pose.txt\n");
  };
  EXPECT_THAT(poseError(""), FailsWith(ErrorCode::malformedFile, "pose.txt: 0"));
  EXPECT_THAT(poseError("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0"),
              FailsWith(ErrorCode::malformedFile, "pose.txt: 15"));
  EXPECT_THAT(poseError("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 one"), FailsWith(ErrorCode::malformedFile, "\"one\""));
  EXPECT_THAT(poseError("1 0 0 nan 0 1 0 0 0 0 1 0 0 0 0 1"), FailsWith(ErrorCode::malformedFile, "\"nan\""));
  EXPECT_THAT(poseError("1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1"), FailsWith(ErrorCode::malformedFile, "pose.txt"))
      << "mirrored";
  EXPECT_THAT(poseError("1000 0 0 0 0 1000 0 0 0 0 1000 0 0 0 0 1"),
              FailsWith(ErrorCode::malformedFile, "pose.txt"));
  EXPECT_THAT(poseError("1 0 0 0 0 1 0 0 0 0 1 0 5 0 0 1"),
              FailsWith(ErrorCode::malformedFile, "pose.txt", "0 0 0 1"));
  EXPECT_THAT(poseError(std::string(1 << 17, '1')), FailsWith(ErrorCode::tooLarge, "pose.txt"));
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
