// Layers in a map file: objects and their edits, observations, and files that are damaged.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/edit_rules.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>

#include "estancia/map_file/sqlite.hpp"
#include "estancia/objects/object_instance.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/segment_answers.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::caught;
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

enum RoomPart : std::uint8_t { floorPart, wallPart, cupboardPart, canePart };

struct SeenRoom {
  cv::Mat depth = cv::Mat(240, 320, CV_32F), part = cv::Mat(240, 320, CV_8U);
  CameraIntrinsics camera{320, 240, 262.5, 262.5, 159.5, 119.5};
};

/// What a level camera 0.8 m above the floor sees: a wall at 3 m, a cupboard before it, and a cane, too thin
/// for a segment.
SeenRoom roomWithACupboard() {
  SeenRoom room;
  for (int v = 0; v < room.depth.rows; ++v)
    for (int u = 0; u < room.depth.cols; ++u) {
      const double x = room.camera.slopeX(u), y = room.camera.slopeY(v);
      double z = 3;
      RoomPart part = wallPart;
      const auto meet = [&](double distance, RoomPart other, bool hit) {
        if (!hit || distance >= z) return;
        z = distance;
        part = other;
      };
      const auto between = [](double value, double low, double high) {
        return low <= value && value <= high;
      };
      meet(0.8 / y, floorPart, y > 0);
      meet(2.45, cupboardPart, between(2.45 * x, -1.2, -0.4) && between(2.45 * y, -0.3, 0.8));
      meet(1.5, canePart, between(1.5 * x, 0.5, 0.52) && between(1.5 * y, 0.1, 0.8));
      room.depth.at<float>(v, u) = static_cast<float>(z);
      room.part.at<std::uint8_t>(v, u) = part;
    }
  return room;
}

/// Share of a part's pixels for which the predicate holds.
template <class Predicate>
double shareOf(const Observation& seen, const SeenRoom& room, RoomPart part, const Predicate& predicate) {
  double all = 0, right = 0;
  for (int v = 0; v < room.part.rows; ++v)
    for (int u = 0; u < room.part.cols; ++u) {
      if (room.part.at<std::uint8_t>(v, u) != part) continue;
      ++all;
      right += predicate(seen.segments.at<std::uint8_t>(v, u)) ? 1 : 0;
    }
  return right / all;
}

TEST(Observation, TellsSegmentsWallsAndLoosePixelsApart) {
  const SeenRoom room = roomWithACupboard();
  Observation seen = observe(room.depth, room.camera);
  findSegments(seen, {}, {});
  // Far away the tolerance of a plane is wide: what is near two of them may be of either.
  EXPECT_GT(shareOf(seen, room, floorPart, [](std::uint8_t p) { return p == 0; }), 0.8);
  EXPECT_GT(shareOf(seen, room, wallPart, [](std::uint8_t p) { return p == wallPixel; }), 0.9);
  EXPECT_GT(shareOf(seen, room, cupboardPart, [](std::uint8_t p) { return inSegment(p); }), 0.9);
  EXPECT_GT(shareOf(seen, room, canePart, [](std::uint8_t p) { return p == loosePixel; }), 0.8);

  const Observation read = observationFromBytes(toBytes(seen));
  EXPECT_EQ(cv::norm(read.segments, seen.segments, cv::NORM_INF), 0);
  ASSERT_EQ(read.info.size(), seen.info.size());
}

TEST(Observation, IsRefusedWhereItIsCutOffOrDamaged) {
  Observation good;
  good.depth = cv::Mat(12, 16, CV_16U, cv::Scalar(1500));
  good.camera = {16, 12, 10, 10, 8, 6};
  good.segments = cv::Mat(12, 16, CV_8U, cv::Scalar(1));
  good.info.push_back({{0, 0, 16, 12}});
  good.seenFrom = Pose::planar(1, 2, 0);
  const std::string whole = toBytes(good);
  const std::size_t withoutPose = whole.size() - 7 * sizeof(double);
  for (std::size_t end = 0; end <= whole.size(); ++end)
    EXPECT_EQ(caught([&] { observationFromBytes(whole.substr(0, end)); }).code.has_value(),
              end != withoutPose && end != whole.size())
        << end;
  const std::function<void(Observation&)> damages[] = {
      [](Observation& seen) { seen.camera.fx = 0; },
      [](Observation& seen) { seen.camera.fy = -1; },
      [](Observation& seen) { seen.camera.cx = std::nan(""); },
      [](Observation& seen) { seen.depth.convertTo(seen.depth, CV_8U); },
      [](Observation& seen) { seen.segments = 2; },
      [](Observation& seen) { seen.segments.convertTo(seen.segments, CV_16U); },
      [](Observation& seen) { seen.segments = seen.segments.colRange(0, 9).clone(); },
      [](Observation& seen) { seen.info[0].box.width = 17; },
      [](Observation& seen) { seen.info[0].box.width = 0; },
      [](Observation& seen) { seen.seenFrom->x = std::nan(""); }};
  for (const auto& damage : damages) {
    Observation seen = good;
    seen.segments = good.segments.clone();
    damage(seen);
    EXPECT_THAT([&] { observationFromBytes(toBytes(seen)); }, FailsWith(ErrorCode::corruptFile))
        << &damage - damages;
  }
}

/// The sample world as a file that has something in each of its tables.
void writeAllLayers(const fs::path& file) {
  test::writeWorld(test::sampleWorld(), file);
  MapStore store = MapStore::open(file, MapStore::Access::write);
  WorldStore layers(store, MapStore::Access::write);
  const std::vector<unsigned char> image{0xFF, 0xD8, 0xFF, 0xD9};
  layers.putView({1, 0, 1, LexicalDescriptor(6, 0.1F)}, image);
  layers.putObservation(1, observe(cv::Mat(12, 16, CV_32F, cv::Scalar(2)), {16, 12, 10, 10, 8, 6}));
  layers.putRegionLabels({1});
  layers.putSegmentWords({1, 0}, {0.5F});
  KnownStore known(store);
  known.begin("mug", "digest");
  known.put({1, 0}, {"mug", Pose{}, 0.9});
  known.putPoses(std::vector<std::optional<KnownPose>>{KnownPose{"mug", 0.9, Pose{}, 1}});
  ShapeStore shapes(store);
  shapes.begin({"mug"}, "digest");
  shapes.put({1, 0}, {0.5F});
  store.commit();
}

void readAllLayers(const fs::path& file) {
  readWorld(file);
  MapStore store = MapStore::open(file, MapStore::Access::read);
  const WorldStore layers(store, MapStore::Access::read);
  EXPECT_LE(layers.views().size() + layers.objectSegments().size() + layers.objectEdits().size(), 2U);
  layers.forEachObservation([](std::size_t, const Observation&) { return true; });
  layers.forEachSegmentWords([](const SegmentPlace&, const LexicalDescriptor&) {});
  layers.observation(1);
  EXPECT_EQ(KnownStore(store).recognitions().size() + ShapeStore(store).probabilities().size(), 2U);
}

TEST(WorldStore, RefusesDamagedLayers) {
  const ScratchFolder folder;
  const fs::path whole = folder / "whole.estancia", file = folder / "damaged.estancia";
  writeAllLayers(whole);
  readAllLayers(whole);
  const std::pair<std::string, std::vector<std::string>> damages[] = {
      {"UPDATE floor SET ",
       {"columns = 1000000000", "columns = 0", "columns = 99", "rows = 1000000000", "rows = 0",
        "columns = 60000000, rows = 60000000", "first_column = -1000000000", "first_row = 1000000000",
        "cell = 0", "cell = 1e9", "cell = 9e999", "up_z = 0", "walls = areas", "areas = walls"}},
      {"UPDATE areas SET ", {"outline = '[[1]]' WHERE id = 0", "id = 9 WHERE id = 3", "x = 9e999"}},
      {"DELETE FROM ", {"areas WHERE id = 3", "observations"}},
      {"UPDATE frame_areas SET ", {"area = 77", "area = -1", "frame = frame - 1", "frame = frame + 100"}},
      {"INSERT INTO ",
       {"area_edits VALUES(9, 'paint', 0, 0, 0, 0, '')", "zones VALUES(1, '', 0)", "zones VALUES(0, '', -1)",
        "frame_zones VALUES(0, 0)", "object_classes VALUES(77, 'cup', 0.5)",
        "object_classes VALUES(0, 'cup', 2)", "object_classes VALUES(0, 'cup', -1)",
        "object_edits VALUES(1, 'paint', 0, 0, 0, 0, 0, 0, '')", "shape_classes VALUES(3, 'cup')"}},
      {"UPDATE observations SET ", {"seen = x'0011'", "frame = -1", "frame = 99"}},
      {"UPDATE objects SET ",
       {"id = 9 WHERE id = 5", "red = 256", "red = -1", "views = 99", "best_frame = 8", "support = 'air'",
        "on_object = 77", "area = 77", "yaw = 9e999"}},
      {"UPDATE object_words SET ",
       {"object = 77 WHERE object = 4", "object = -1 WHERE object = 4", "label = 77 WHERE object = 4",
        "label = -1 WHERE object = 4", "probability = 9e999"}},
      {"UPDATE object_views SET ", {"frame = -1", "segment = -1", "words = x'00'", "quality = 9e999"}},
      {"UPDATE object_segments SET ", {"frame = -1", "segment = -1", "object = 77", "object = -1"}},
      {"UPDATE segment_words SET ", {"frame = -1", "segment = -1", "words = x'00'"}},
      {"UPDATE state SET bytes = ", {"x'0100000000000000ff000000'", "x'01'"}},
      {"UPDATE recognitions SET ", {"frame = -1", "segment = -1", "confidence = 2", "confidence = -1"}},
      {"UPDATE object_poses SET ",
       {"object = 77", "object = -1", "frame = 99", "frame = -1", "confidence = 2", "x = 9e999"}},
      {"UPDATE segment_shapes SET ",
       {"frame = -1", "segment = -1", "probabilities = x'00'", "probabilities = x'00000040'",
        "probabilities = x'000000c0'"}}};
  for (const auto& [statement, ends] : damages)
    for (const std::string& end : ends) {
      fs::copy_file(whole, file, fs::copy_options::overwrite_existing);
      sqlite::Database(file, sqlite::Database::Mode::write).run(statement + end);
      EXPECT_THAT([&] { readAllLayers(file); }, FailsWith(ErrorCode::corruptFile)) << statement << end;
    }
}

}  // namespace
}  // namespace estancia
