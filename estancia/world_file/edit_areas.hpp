// Area edits: people name, merge and split the areas of a map; edits outlive another segmentation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>
#include <string_view>

#include "estancia/core/progress.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// The area of that number; nullptr where the text is no number of an area.
const WorldArea* findAreaNumber(const WorldMap& world, std::string_view text);

/// The area of that number, or the one that is called so (areasCalled()). Throws Error: unknownName, where
/// none or several are, with the areas that are meant; insufficientData where the map has none.
const WorldArea& getArea(const WorldMap& world, const std::string& area);

/// Edits that the functions below store, for an area of `world` as getArea() takes it. Throw Error like
/// these.
AreaEdit namingOf(const WorldMap& world, const std::string& area, const std::string& name);
AreaEdit mergeOf(const WorldMap& world, const std::string& area, const std::string& other);
AreaEdit splitOf(const WorldMap& world, const cv::Point2d& from, const cv::Point2d& to);
/// Throws the Error (invalidInput) of a split that does not cut an area in two.
[[noreturn]] void failUncut(const AreaEdit& split);

/// Throws Error (invalidInput) for a name of more than 120 bytes, with control characters or of no UTF-8
/// (what printable() shows otherwise), of blanks, and for one that would be taken for a number; `what` it is
/// for: "an area". "" is none, and takes a name away.
void requireGivenName(const std::string& name, const char* what);

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

}  // namespace estancia
