// World map: places, areas and objects of one drive as plain data, and how they are read from a map file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/areas/area_plan.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/map_file/map.hpp"

namespace estancia {

/// An area as the map knows it.
struct WorldArea : Area {
  /// Name given by a person; "" if none.
  std::string givenName = {};
  /// Room predicted by a classifier, and its probability; "" if none was run.
  std::string predictedRoom = {};
  double roomProbability = 0;
  /// Whether that is sure enough for a name: see nameAreasByRooms().
  bool isSurelyRoom = false;
  /// Its name by that room: the room, with a number where several areas are one; "" where a person gave a
  /// name, or no room is more probable than all others together. See nameAreasByRooms().
  std::string roomName = {};

  /// For people: the given name, else the room name, else the telling words.
  const std::string& displayName() const {
    return !givenName.empty() ? givenName : !roomName.empty() ? roomName : name;
  }
  /// The name followed by the distinguishing words: "kitchen: microwave, dishwasher, bottle".
  std::string describedName() const {
    return displayName() == name || name.empty() ? displayName() : displayName() + ": " + name;
  }
};

/// Frames that look alike (findZones()), wherever they are.
struct WorldZone {
  int id = 0;
  /// Its telling words.
  std::string name = {};
  std::size_t frames = 0;
};

/// Support of a thing.
enum class Support {
  unknown,
  floor,
  /// Another object.
  object,
  /// A surface that is no object.
  surface,
  /// It hangs at a wall.
  wall
};
/// By their numbers, as map files and JSON call them; "" for unknown.
constexpr std::array<const char*, 5> supportNames{"", "floor", "object", "surface", "wall"};

/// A known object that was recognized.
struct KnownPose {
  std::string name;
  /// How far model and views agree, in [0, 1]: KnownLayer::recognized().
  double confidence = 0;
  /// T_map_model: of the axes of the cloud that was given.
  Pose pose;
  /// Frame that shows this pose.
  std::size_t frame = 0;
};

/// A thing that was seen in several frames: one instance, from whatever side and however often it was seen.
struct WorldObject {
  /// Its position in WorldMap::objects.
  int id = 0;
  /// Name given by a person; "" if none.
  std::string givenName = {};
  /// The known object that it is, if it is one.
  std::optional<KnownPose> known = {};
  /// Its words and their probabilities, best first; empty where nothing has labeled it.
  std::vector<LabelProbability> words = {};
  /// The classes of a trained object model by its shape (`objects train`), and their probabilities, best
  /// first; empty where no model was given, and of flat things, which are none of them.
  std::vector<LabelProbability> shapeClasses = {};
  /// Middle of its box in the map [m]; the box is upright.
  cv::Point3d center = {};
  /// Size of the box before it is turned [m].
  cv::Point3d size = {};
  /// Turn of the box about the floor's up, counter-clockwise [rad].
  double yaw = 0;
  /// Mean, red, green, blue.
  std::array<int, 3> color = {};
  /// A poster, a rug: no depth of its own.
  bool flat = false;
  /// Frames that show it.
  std::size_t views = 0;
  /// The first and the last of them, and the one that shows it best.
  std::size_t firstFrame = 0, lastFrame = 0, bestFrame = 0;
  Support support = Support::unknown;
  /// The object that it stands on; -1 for none.
  int onObject = -1;
  /// The area that it is in; -1 for none.
  int area = -1;

  /// The class that is more probable than all others together; nullptr where none is.
  const std::string* shapeClass() const {
    return shapeClasses.empty() || shapeClasses.front().probability <= 0.5F ? nullptr
                                                                            : &shapeClasses.front().label;
  }
  /// For people: the given name, else that of the known object, else its best word, else "object".
  std::string displayName() const;
  /// The confidence of the known object, else of the best word; 0 without either.
  double probability() const {
    return known ? known->confidence : words.empty() ? 0 : static_cast<double>(words.front().probability);
  }
};

/// The layers of a map. Invariants: areaOfFrame and zoneOfFrame have one entry a frame (-1 where there are
/// no areas or zones) and nothing that does not exist; plan.areas equals areas without what people added. An
/// object's area and what it stands on exist, and its frames are frames of the map.
struct WorldMap {
  TopologicalMap places;
  std::vector<WorldZone> zones = {};
  std::vector<int> zoneOfFrame = {};
  /// Absent without poses and depth.
  std::optional<AreaPlan> plan = {};
  std::vector<WorldArea> areas = {};
  std::vector<int> areaOfFrame = {};
  std::vector<WorldObject> objects = {};
  /// Corrections by people, in the order they were made.
  std::vector<AreaEdit> edits = {};

  /// The area of most frames of a place; -1 where there are no areas.
  int areaOfNode(int node) const;
  /// nullptr when there is no such area.
  const WorldArea* findArea(int id) const;
  const WorldObject* findObject(int id) const;
};

/// The floor of the plan; without one, of the frames' poses.
Floor floorOf(const WorldMap& world);

/// Number of frames of a longer drive, evenly spread, that name its rooms and answer questions: more do not
/// make the rooms surer, but a day at ten frames a second has 4 GB of words. The other frames have no
/// prediction of their own.
constexpr std::size_t maxFramesOfAnswers = 5000;

/// Reads a map file with all its layers as of its last commit. `maxFrames`: of a longer drive each n-th
/// frame is read, so that there are no more (TopologicalMap::isThinned()), and those that the layers name:
/// where objects are seen, transitions and drives begin, and some of each place. Throws Error as readMap()
/// does.
WorldMap readWorld(const std::filesystem::path& path,
                   std::size_t maxFrames = std::numeric_limits<std::size_t>::max());

/// The best image of an object, a small JPEG; empty where there is none. Throws Error as readMap() does.
std::vector<unsigned char> readObjectImage(const std::filesystem::path& path, int object);

/// The image of the middle frame of a place among those that the map has images of, a small JPEG; empty where
/// it has none. `world` was read from the file. Throws Error as readMap() does.
std::vector<unsigned char> readPlaceImage(const std::filesystem::path& path, const WorldMap& world, int node);

}  // namespace estancia
