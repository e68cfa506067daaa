// Object edits: people name and delete the objects of a map; edits outlive another derivation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <span>
#include <string>
#include <vector>

#include "estancia/world_file/world_map.hpp"

namespace estancia {

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

/// The object that an edit is about: of about its size, and the nearest within half its length, or 0.2 m; -1
/// where there is none.
int objectOf(const ObjectEdit& edit, std::span<const WorldObject> objects);

/// Does the edits, in order. Removed objects leave no gaps. Returns the new number of each object, -1 for
/// those that were removed.
std::vector<int> applyEdits(std::span<const ObjectEdit> edits, std::vector<WorldObject>& objects);

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
