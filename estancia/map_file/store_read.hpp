// Map file reader: every number and length is checked before it is used, and texts are printable(). Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"

namespace estancia {

/// A thousand years of 30 images a second. Counts of a map stay below, so that sums of them do not overflow.
constexpr std::size_t maxFramesOfMap = std::size_t{1} << 40;

/// Throws Error when the labels do not match their digest.
MapStore::Identity readIdentity(sqlite::Database& database);

/// The parts of a vocabulary as JSON, [[labels, weight], …].
std::string partsToJson(const Vocabulary& vocabulary);

/// Which frames of a map are read: all of them, or some by their numbers.
class FrameRows {
 public:
  FrameRows() = default;
  /// `numbers` ascend.
  explicit FrameRows(std::span<const std::size_t> numbers);
  /// Rows of the frames of `map`, which was read from the database.
  FrameRows(sqlite::Database& database, const TopologicalMap& map);

  /// The rows of these frames in the order of their numbers, which are in the column `frame`; this must live
  /// as long. `Row`: a sqlite::Statement.
  template <class Row = sqlite::Statement>
  Row select(const sqlite::Database& database, std::string_view columns, std::string_view table,
             std::string_view frame) const {
    if (!numbers_) return Row(database, fmt::format("SELECT {} FROM {} ORDER BY {}", columns, table, frame));
    const std::string sql = fmt::format(
        "SELECT {} FROM (SELECT value AS number_read FROM json_each(?1)) CROSS JOIN {} "
        "ON {} = number_read",
        columns, table, frame);
    return Row(database, sql, std::string_view(*numbers_));
  }

 private:
  /// Frame numbers as a JSON array.
  std::optional<std::string> numbers_;
};

/// Everything but descriptors, images and states. Every number and length is checked before it is used.
/// `maxFrames`, `also`: see MapStore::load().
TopologicalMap readContent(sqlite::Database& database, const MapStore::Identity& identity,
                           std::size_t maxFrames, const std::vector<std::size_t>& also);

/// The runs of frames at one place, in order.
std::vector<Visit> readVisits(sqlite::Database& database);

/// Numbers of the kept frames, in order.
std::vector<std::size_t> numbersOf(const sqlite::Database& database);

/// The number that the next frame will have: of all that were mapped, kept or left out.
std::size_t frameCountOf(sqlite::Database& database);

/// The meta key of how many frames were mapped but are not kept, and its value.
constexpr const char* leftOutKey = "left_out";
std::size_t leftOutOf(sqlite::Database& database);

/// The pose in columns x, y, z, qx, qy, qz, qw from `column` on; absent where these are NULL or cannot be
/// one.
std::optional<Pose> readPose(const sqlite::Statement& row, int column);

/// In order of first frames, which are numbers.
std::vector<Transition> readTransitions(sqlite::Database& database);

/// Drives of the map, in order of frames.
std::vector<Drive> readDrives(sqlite::Database& database);

/// The number in a column. Throws Error when it is none; `what` names it.
double finiteReal(const sqlite::Database& database, const sqlite::Statement& row, int column,
                  const char* what);

/// Copies a blob of `labels` float32 values. Throws Error when it has another length or a value that is not
/// finite; `what` names it.
void readValues(const sqlite::Database& database, std::span<const std::byte> bytes, std::size_t labels,
                const std::string& what, std::vector<float>& values);

}  // namespace estancia
