// Map edits: people name, merge and split areas, name and delete objects; edits outlive the next drive.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>

#include "estancia/core/progress.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// The area of that number, or the one that is called so (areasCalled()). Throws Error: unknownName, where
/// none or several are, with the areas that are meant; insufficientData where the map has none.
const WorldArea& getArea(const WorldMap& world, const std::string& area);

/// Edits that the functions below store, for an area of `world` as getArea() takes it. Throw Error like
/// these.
AreaEdit namingOf(const WorldMap& world, const std::string& area, const std::string& name);
AreaEdit mergeOf(const WorldMap& world, const std::string& area, const std::string& other);
AreaEdit splitOf(const WorldMap& world, const cv::Point2d& from, const cv::Point2d& to);

/// Gives the area a name; "" takes it away. All three write the map file, whole or not at all, and throw
/// Error as getArea() and readMap() do, and busy when another process writes the map; this one also
/// invalidInput for a name of blanks or digits.
void nameArea(const std::filesystem::path& map, const std::string& area, const std::string& name);

/// Makes two areas one. Throws Error (invalidInput) where they do not touch and the robot never drove from
/// one into the other; Interrupted.
void mergeAreas(const std::filesystem::path& map, const std::string& area, const std::string& other,
                Progress& progress = Progress::none());

/// Splits the area halfway between two points of the floor [m] along the line between them
/// (AreaEdit::Kind::split). Throws Error (invalidInput) where their middle is in no area, or the line does
/// not cut it in two; Interrupted.
void splitArea(const std::filesystem::path& map, const cv::Point2d& from, const cv::Point2d& to,
               Progress& progress = Progress::none());

/// A correction by a person. It is anchored to where the object was, and how large, so that it outlives
/// another derivation of the objects.
struct ObjectEdit {
  enum class Kind {
    /// People call it `name`.
    name,
    /// It is none.
    remove
  };
  Kind kind = Kind::name;
  /// Its box [m]: WorldObject::center and size.
  cv::Point3d center = {}, size = {};
  std::string name = {};
};

/// The object of that number, or the only one that is called so. Throws Error: unknownName, where none or
/// several are, with those that are meant; insufficientData where the map has none.
const WorldObject& getObject(const WorldMap& world, const std::string& object);

/// Edits that nameObject() and deleteObject() store. Throw Error like these.
ObjectEdit namingOf(const WorldObject& object, const std::string& name);
ObjectEdit removalOf(const WorldObject& object);

/// Gives the object a name; "" takes it away. Both write the map file, whole or not at all, and throw Error
/// as getObject() and readMap() do, and busy when another process writes the map; this one also invalidInput
/// for a name of blanks or digits.
void nameObject(const std::filesystem::path& map, const std::string& object, const std::string& name);

/// Takes the object out of the map; it stays away when the same thing is derived again. What stood on it
/// stands on a surface.
void deleteObject(const std::filesystem::path& map, const std::string& object);

}  // namespace estancia
