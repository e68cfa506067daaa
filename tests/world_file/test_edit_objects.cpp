// Edits of objects: names and deletions outlive another derivation.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/edit_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/map_file/sqlite.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::ScratchFolder;
using test::ShapeDrive;

WorldMap mapDesk(const fs::path& file, std::size_t end) {
  return test::mapShapes(ShapeDrive(test::desk), end, file, [](WorldMapper&) {});
}

TEST(EditObjects, ANameOutlivesAnotherDerivation) {
  const ScratchFolder folder;
  const fs::path file = folder / "map.estancia";
  ASSERT_EQ(mapDesk(file, 8).objects.size(), 1U);
  const std::string name = "Ana's \"desk\"";
  nameObject(file, "0", name);
  EXPECT_EQ(readWorld(file).objects.at(0).displayName(), name);
  const WorldMap later = mapDesk(file, 12);
  ASSERT_EQ(later.objects.size(), 1U);
  EXPECT_EQ(later.objects[0].givenName, name);
  nameObject(file, name, "");
  EXPECT_EQ(readWorld(file).objects.at(0).givenName, "");
  EXPECT_EQ(mapDesk(file, 12).objects.at(0).givenName, "");
}

TEST(EditObjects, WhatIsDeletedStaysAway) {
  const ScratchFolder folder;
  const fs::path file = folder / "map.estancia";
  ASSERT_EQ(mapDesk(file, 8).objects.size(), 1U);
  deleteObject(file, "0");
  EXPECT_TRUE(readWorld(file).objects.empty());
  const auto segments = [&] {
    return sqlite::Database(file, sqlite::Database::Mode::read)
        .number("SELECT count(*) FROM object_segments");
  };
  EXPECT_EQ(segments(), 0);
  EXPECT_TRUE(mapDesk(file, 12).objects.empty());
  EXPECT_EQ(segments(), 0);
  EXPECT_THAT([&] { deleteObject(file, "0"); }, FailsWith(ErrorCode::insufficientData));
}

TEST(EditObjects, AreDoneWhileAMapGrows) {
  const ScratchFolder folder;
  const fs::path file = folder / "map.estancia";
  mapDesk(file, 8);
  const WorldObject desk = readWorld(file).objects.at(0);
  test::mapShapes(ShapeDrive(test::desk), 12, file, [&](WorldMapper& world) {
    world.edit(namingOf(desk, "bureau"));
    EXPECT_EQ(readWorld(file).objects.at(0).givenName, "bureau") << "at once";
  });
  EXPECT_EQ(readWorld(file).objects.at(0).givenName, "bureau");
  test::mapShapes(ShapeDrive(test::desk), 12, file, [&](WorldMapper& world) {
    const auto derived = world.derivation()();
    world.edit(removalOf(desk));
    EXPECT_TRUE(readWorld(file).objects.empty());
    EXPECT_TRUE(world.refresh(*derived)) << "deletions are done to whatever is derived";
    EXPECT_TRUE(readWorld(file).objects.empty());
  });
  EXPECT_TRUE(readWorld(file).objects.empty());
}

TEST(EditObjects, AreOfTheNearestObjectOfThatSize) {
  std::vector<WorldObject> objects = test::sampleObjects();
  for (const WorldObject& object : objects) {
    EXPECT_EQ(objectOf(removalOf(object), objects), object.id);
    ObjectEdit moved = removalOf(object);
    moved.center.x += 0.1;
    moved.size *= 1.3;
    EXPECT_EQ(objectOf(moved, objects), object.id) << "poses were corrected, and more was seen of it";
    moved.center.y += 100;
    EXPECT_EQ(objectOf(moved, objects), -1);
  }
  ObjectEdit tabletop = removalOf(objects[1]);  // a mug on a table is no part of the table
  tabletop.center = objects[0].center;
  EXPECT_NE(objectOf(tabletop, objects), 0);
}

TEST(EditObjects, SayWhichObjectIsMeant) {
  const WorldMap world = test::sampleWorld();
  EXPECT_EQ(getObject(world, "3").id, 3);
  EXPECT_THAT([&] { getObject(world, "77"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { getObject(world, "-1"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { getObject(world, "no such thing"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { namingOf(world.objects[0], " 7 "); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { namingOf(world.objects[0], "  "); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { nameObject("/nowhere.estancia", "0", "cup"); }, FailsWith(ErrorCode::fileNotFound));
}

}  // namespace
}  // namespace estancia
