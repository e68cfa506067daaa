// Things that were found beside those that are there: each counted once, by class, with its name.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/instance_accuracy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

OrientedBox cubeAt(double x) {
  return {{x, 0, 0.5}, {1, 1, 1}, 0};
}

/// A sofa and a bed, a mug that was hardly seen, and a stove, which is a fixture.
std::vector<TrueThing> fourThings() {
  return {{10, cubeAt(0), "furniture", true, {"studio couch, day bed"}},
          {11, cubeAt(3), "furniture", true, {"four-poster", "studio couch, day bed"}},
          {12, cubeAt(6), "small", false, {"cup"}},
          {13, cubeAt(9), "fixture", true, {}}};
}

TEST(InstanceAccuracy, CountsWhatIsFoundAndWhatIsThere) {
  const std::vector<FoundInstance> found{{cubeAt(0.1), false, "studio couch, day bed"},
                                         {cubeAt(6), false, "teapot"},
                                         {cubeAt(9), false, ""},
                                         {cubeAt(20), false, "cup"},
                                         {cubeAt(30), true, "cup"}};
  const InstanceAccuracy accuracy = judgeInstances(found, fourThings());
  const InstanceScore& all = accuracy.counted;
  EXPECT_EQ(all.things, 2U) << "neither the fixture nor what was hardly seen";
  EXPECT_EQ(all.found, 1U);
  EXPECT_EQ(all.recall(), 0.5);
  EXPECT_EQ(all.instances, 3U) << "neither the fixture nor what hangs at a wall and is no thing";
  EXPECT_EQ(all.right, 2U) << "a thing that was hardly seen may be found";
  EXPECT_NEAR(*all.precision(), 2. / 3, 1e-12);
  EXPECT_NEAR(*all.error, 0.1, 1e-12);
  EXPECT_EQ(all.nameable, 1U);
  EXPECT_EQ(all.nameAccuracy(), 1.0);
  EXPECT_EQ(accuracy.ofClass.at("fixture").found, 1U);
  EXPECT_EQ(accuracy.ofClass.at("fixture").nameable, 0U);
  EXPECT_EQ(accuracy.ofClass.at("none").instances, 2U);
  EXPECT_EQ(accuracy.ofClass.at("small").right, 1U);
  EXPECT_FALSE(accuracy.split || accuracy.merged) << "nobody knows what the segments show";
  EXPECT_FALSE(judgeInstances({}, {}).counted.recall());
  const std::vector<FoundInstance> wrong{{cubeAt(0), false, "teapot"}, {cubeAt(3), false, ""}};
  EXPECT_EQ(judgeInstances(wrong, fourThings()).counted.nameAccuracy(), 0.0);
}

TEST(InstanceAccuracy, KnowsSplitThingsAndMergedOnesByTheirPixels) {
  const std::vector<FoundInstance> found{{cubeAt(0), false, "", {{10, 70}, {2, 30}}},
                                         {cubeAt(1), false, "", {{10, 90}, {11, 10}}},
                                         {cubeAt(3), false, "", {{11, 70}, {12, 30}}},
                                         {cubeAt(9), false, "", {{1, 80}, {13, 20}}}};
  const InstanceAccuracy accuracy = judgeInstances(found, fourThings());
  EXPECT_EQ(accuracy.split, 1U) << "10, in two instances; walls are no thing";
  EXPECT_EQ(accuracy.merged, 1U) << "11 and 12";
}

TEST(InstanceAccuracy, ThingsCountThatTheImagesOfTheMapShowOftenEnough) {
  io::HomeTruth truth;
  truth.instances.resize(2);
  truth.instances[0].id = 10, truth.instances[0].category = "mug";
  truth.instances[1].id = 11, truth.instances[1].category = "bed";
  for (const char* image : {"a", "b", "c", "d", "e"}) truth.visible[image] = {{10, 150, 150}, {11, 149, 149}};
  const Vocabulary vocabulary({"cup", "stove"});
  const ThingClasses classes{.classOf = {{"bed", "furniture"}},
                             .words = {{"mug", {"cup"}}, {"bed", {"bed"}}}};
  const auto things = trueThings(truth, classes, &vocabulary);
  EXPECT_TRUE(things[0].counts);
  EXPECT_FALSE(things[1].counts);
  EXPECT_EQ(things[0].thingClass, "thing");
  EXPECT_EQ(things[1].thingClass, "furniture");
  EXPECT_THAT(things[0].labels, ElementsAre("cup"));
  EXPECT_TRUE(things[1].labels.empty()) << "the vocabulary has no bed";
  EXPECT_FALSE(trueThings(truth, classes, &vocabulary, {"a", "b", "c", "d"})[0].counts);
  EXPECT_TRUE(trueThings(truth, classes, &vocabulary, {}, 100)[1].counts);
  truth.visible.clear();
  EXPECT_TRUE(trueThings(truth, classes, &vocabulary)[1].counts) << "nobody knows what images show";
}

TEST(ThingClasses, AreReadFromAFile) {
  const test::ScratchFolder folder;
  const auto file = folder / "things.toml";
  const auto read = [&](const std::string& text) {
    test::writeFile(file, text);
    return readThingClasses(file);
  };
  const ThingClasses classes = read(
      "other = \"small\"\n[classes]\nfixture = [\"stove\"]\n[words]\n"
      "mug = [\"coffee mug\", \"cup\"]\n");
  EXPECT_EQ(classes.of("stove"), ThingClasses::fixture);
  EXPECT_EQ(classes.of("mug"), "small");
  EXPECT_THAT(classes.words.at("mug"), ElementsAre("coffee mug", "cup"));
  EXPECT_EQ(read("").of("mug"), "thing");
  for (const char* wrong :
       {"[classes]\na = [\"x\"]\nb = [\"x\"]\n", "[words]\nmug = []\n", "[words]\nmug = 1\n", "typo = 1\n"})
    EXPECT_THAT([&] { read(wrong); }, FailsWith(ErrorCode::malformedFile)) << wrong;
}

}  // namespace
}  // namespace estancia
