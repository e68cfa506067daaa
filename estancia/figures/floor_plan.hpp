// Floor plan: the building under the drawing of a map or of zones.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <vector>

namespace estancia {

namespace io {
struct HomePlan;
}

/// A drawing of the building: an image, or rooms with doors and windows.
struct FloorPlan {
  std::vector<unsigned char> image;               ///< a JPEG, PNG, GIF or WebP file
  double xMin = 0, yMin = 0, xMax = 0, yMax = 0;  ///< what its edges are in the map [m]; y grows upwards
  std::shared_ptr<const io::HomePlan> home = {};  ///< drawn instead of the image
};

/// Reads the image. `extent` is xMin, yMin, xMax, yMax [m].
/// Throws Error when it cannot be read, is no image, is larger than 8 MB, or the extent is empty.
FloorPlan readFloorPlan(const std::filesystem::path& path, const std::array<double, 4>& extent);

/// Reads a home.json, or that of a folder (io::readHomePlan()); its own coordinates are those of the map.
FloorPlan readHomeFloorPlan(const std::filesystem::path& path);

}  // namespace estancia
