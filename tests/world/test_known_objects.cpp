// Known objects are recognized in a drive: names and poses, and nothing where there is none.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/layers/known_objects.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "estancia/core/pose.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/world_json.hpp"
#include "support/errors.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::desk;
using test::FailsWith;
using test::ScratchFolder;
using test::Shape;
using test::ShapeDrive;
using test::shelf;
using test::surfaceOf;

/// Beginning or going on.
WorldMap mapWith(const ShapeDrive& drive, std::size_t end, const fs::path& file,
                 const std::shared_ptr<const KnownObjects>& known) {
  return test::mapShapes(drive, end, file, [&](WorldMapper& world) {
    if (known) world.recognize(known);
  });
}

std::shared_ptr<const KnownObjects> knownBy(const std::vector<ModelFile>& files) {
  return std::make_shared<const KnownObjects>(files);
}

void expectDesk(const WorldMap& world) {
  ASSERT_EQ(world.objects.size(), 1U);
  const WorldObject& object = world.objects.front();
  ASSERT_TRUE(object.known);
  EXPECT_EQ(object.displayName(), "desk");
  EXPECT_GT(object.known->confidence, 0.6);
  EXPECT_EQ(object.probability(), object.known->confidence);
  const cv::Affine3d error = ShapeDrive::placeOfShape().inv() * rigidOf(object.known->pose);
  EXPECT_LT(cv::norm(error.translation()), 0.02);
  EXPECT_LT(angleOf(error) * 180 / std::numbers::pi, 2);
}

TEST(KnownObjects, GiveNamesAndPosesToTheObjectsThatTheyAre) {
  const ScratchFolder folder;
  writeCloud(surfaceOf(desk), folder / "desk.ply");
  writeCloud(surfaceOf(shelf), folder / "shelf.ply");
  const auto known = knownBy({{"desk", folder / "desk.ply"}, {"shelf", folder / "shelf.ply"}});
  const WorldMap world = mapWith(ShapeDrive(desk), 12, folder / "map.estancia", known);
  expectDesk(world);
  const WorldAnswers answers = askWorld(world, "Desk");
  ASSERT_EQ(answers.objects.size(), 1U);
  EXPECT_TRUE(answers.objects[0].isKnown);
  EXPECT_TRUE(answers.objects[0].isLikely());
  EXPECT_EQ(answers.objects[0].probability, world.objects[0].known->confidence);
  EXPECT_TRUE(answers.places.empty());
  EXPECT_THAT([&] { askWorld(world, "shelf"); }, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT(findNearNames(world, "desc"), testing::Contains("desk"));
  const auto json = toJson("desk", answers, world)["objects"][0];
  EXPECT_EQ(json["name"], "desk");
  EXPECT_EQ(json["recognized"], true);
  EXPECT_NEAR(json["known"]["position"][0].get<double>(), 0.3, 0.02);
  EXPECT_EQ(json["known"]["orientation"].size(), 4U);
}

TEST(KnownObjects, AreNotFoundWhereTheyAreNot) {
  const ScratchFolder folder;
  writeCloud(surfaceOf(shelf), folder / "shelf.ply");
  const WorldMap world =
      mapWith(ShapeDrive(desk), 12, folder / "map.estancia", knownBy({{"shelf", folder / "shelf.ply"}}));
  ASSERT_EQ(world.objects.size(), 1U);
  EXPECT_FALSE(world.objects[0].known);
  sqlite::Database database(folder / "map.estancia", sqlite::Database::Mode::read);
  EXPECT_EQ(database.number("SELECT count(*) FROM recognitions"), 3) << "the best views";
  EXPECT_EQ(database.number("SELECT count(confidence) FROM recognitions"), 0);
}

TEST(KnownObjects, StayFoundAndMayBeGivenAfterTheDrive) {
  const ScratchFolder folder;
  const ShapeDrive drive(desk);
  const fs::path file = folder / "map.estancia";
  EXPECT_FALSE(mapWith(drive, 8, file, nullptr).objects.at(0).known);
  writeCloud(surfaceOf(desk), folder / "desk.ply");
  const auto known = knownBy({{"desk", folder / "desk.ply"}});
  expectDesk(mapWith(drive, 8, file, known));
  expectDesk(mapWith(drive, 12, file, nullptr));
  const auto tries = [&file] {
    return sqlite::Database(file, sqlite::Database::Mode::read).number("SELECT count(*) FROM recognitions");
  };
  const std::int64_t before = tries();
  expectDesk(mapWith(drive, 12, file, known));
  EXPECT_EQ(tries(), before) << "it is found already";
  writeCloud(surfaceOf(shelf), folder / "desk.ply");
  EXPECT_FALSE(mapWith(drive, 12, file, knownBy({{"desk", folder / "desk.ply"}})).objects.at(0).known)
      << "another cloud of that name";
}

TEST(KnownObjects, SayWhichCloudCannotBeUsed) {
  const ScratchFolder folder;
  const auto known = [](const fs::path& file) { return [file] { KnownObjects({{"desk", file}}); }; };
  EXPECT_THAT(known(folder / "missing.ply"), FailsWith(ErrorCode::fileNotFound));
  PointCloud few = surfaceOf(desk);
  few.points.resize(5), few.normals.resize(5), few.width = 5;
  writeCloud(few, folder / "few.ply");
  EXPECT_THAT(known(folder / "few.ply"), FailsWith(ErrorCode::insufficientData));
  writeCloud(surfaceOf(desk, 1000), folder / "millimeters.ply");
  EXPECT_THAT(known(folder / "millimeters.ply"), FailsWith(ErrorCode::invalidInput));
  writeCloud(surfaceOf({{{{0, 0, 0}, {0.5, 0.5, 0.001}}}}), folder / "sheet.ply");
  EXPECT_THAT(known(folder / "sheet.ply"), FailsWith(ErrorCode::invalidInput));
  writeCloud(surfaceOf(desk), folder / "desk.ply");
  EXPECT_THAT(
      [&] {
        KnownObjects({{"desk", folder / "desk.ply"}, {"desk", folder / "desk.ply"}});
      },
      FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia
