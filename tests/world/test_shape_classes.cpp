// A trained object model names the objects of a map by their shapes.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/topology/sqlite.hpp"
#include "estancia/world/ask_world.hpp"
#include "estancia/world/export_world.hpp"
#include "estancia/world/world_json.hpp"
#include "support/errors.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::ScratchFolder;
using test::ShapeDrive;
using testing::HasSubstr;

class ShapeClasses : public testing::Test {
 protected:
  WorldMap map(const test::Shape& shape, std::size_t end = 12, const std::string& digest = "one") const {
    return test::mapShapes(ShapeDrive(shape), end, file_, [&](WorldMapper& world) {
      if (!digest.empty()) world.classify(model_, digest);
    });
  }
  std::int64_t number(const std::string& sql) const {
    return sqlite::Database(file_, sqlite::Database::Mode::read).number(sql);
  }

  const ObjectModel model_ = test::modelOfShapes();
  ScratchFolder scratch_;
  const fs::path file_ = scratch_ / "map.estancia";
};

/// The probabilities of the only object's classes.
std::map<std::string, float> classesOf(const WorldMap& world) {
  std::map<std::string, float> classes;
  EXPECT_EQ(world.objects.size(), 1U);
  for (const LabelProbability& of : world.objects.at(0).shapeClasses) classes[of.label] = of.probability;
  return classes;
}

TEST_F(ShapeClasses, AreThoseOfTheBestViewsPooled) {
  const WorldMap desk = map(test::desk);
  const auto classes = classesOf(desk);
  ASSERT_EQ(classes.size(), 2U);
  EXPECT_GT(classes.at("desk"), 0.6F);
  EXPECT_NEAR(classes.at("desk") + classes.at("shelf"), 1, 1e-5);
  EXPECT_EQ(number("SELECT count(*) FROM segment_shapes"), 5) << "the work of an object is bounded";
  fs::remove(file_);
  EXPECT_GT(classesOf(map(test::shelf)).at("shelf"), 0.6F);
}

TEST_F(ShapeClasses, AreAskedForAndTold) {
  const WorldMap world = map(test::desk);
  const WorldObject& object = world.objects.at(0);
  EXPECT_NE(object.displayName(), "desk") << "the labeler's words stay";
  EXPECT_THAT(shapeText(object), HasSubstr("by its shape desk ("));
  const WorldAnswers answers = askWorld(world, "Desks");
  ASSERT_EQ(answers.objects.size(), 1U);
  EXPECT_TRUE(answers.objects[0].isShaped);
  EXPECT_TRUE(answers.objects[0].isLikely());
  EXPECT_NEAR(answers.objects[0].probability, classesOf(world).at("desk"), 1e-6);
  EXPECT_THAT([&] { askWorld(world, "shelf"); }, FailsWith(ErrorCode::noAnswer)) << "improbable";
  EXPECT_THAT(findNearNames(world, "desc"), testing::Contains("desk"));
  const auto json = toJson("desk", answers, world)["objects"][0];
  EXPECT_EQ(json["by_shape"], true);
  EXPECT_EQ(json["shape"]["class"], "desk");
  EXPECT_EQ(json["shape"]["classes"].size(), 2U);
  EXPECT_THAT(exportWorld(world, "rooms", {}), HasSubstr("\"class\": \"desk\""));
}

TEST_F(ShapeClasses, StayAndMayBeGivenAfterTheDrive) {
  EXPECT_TRUE(classesOf(map(test::desk, 8, "")).empty());
  const auto early = classesOf(map(test::desk, 8));
  EXPECT_GT(early.at("desk"), 0.6F);
  EXPECT_GT(classesOf(map(test::desk, 12, "")).at("desk"), 0.6F) << "without the model";
  const auto continued = classesOf(map(test::desk, 12));
  fs::remove(file_);
  EXPECT_EQ(classesOf(map(test::desk, 12)), continued) << "as in one run";
  sqlite::Database(file_, sqlite::Database::Mode::write).run("UPDATE segment_shapes SET probabilities = x''");
  EXPECT_TRUE(classesOf(map(test::desk, 12)).empty()) << "what the model said is not asked again";
  EXPECT_FALSE(classesOf(map(test::desk, 12, "another")).empty()) << "another model is";
}

TEST_F(ShapeClasses, OfADamagedMapAreRefused) {
  map(test::desk);
  const fs::path whole = scratch_ / "whole.estancia";
  fs::copy_file(file_, whole);
  const auto damaged = [&](const char* damage) {
    fs::copy_file(whole, file_, fs::copy_options::overwrite_existing);
    sqlite::Database(file_, sqlite::Database::Mode::write).run(damage);
  };
  for (const char* damage :
       {"UPDATE object_classes SET object = 7", "UPDATE object_classes SET probability = 2"}) {
    damaged(damage);
    EXPECT_THAT([&] { readWorld(file_); }, FailsWith(ErrorCode::corruptFile)) << damage;
  }
  for (const char* damage : {"UPDATE segment_shapes SET probabilities = x'01'",
                             "UPDATE segment_shapes SET probabilities = x'0000c07f0000c07f'",
                             "UPDATE shape_classes SET id = id + 7"}) {
    damaged(damage);
    EXPECT_THAT([&] { map(test::desk); }, FailsWith(ErrorCode::corruptFile)) << damage;
  }
}

}  // namespace
}  // namespace estancia
