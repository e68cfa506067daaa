// Map file reader: every number and length is checked before it is used, and texts are printable(). Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

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
MapStore::Identity readIdentity(const sqlite::Database& database);

/// Which frames of a map are read: all of them, or some by their numbers.
class FrameRows {
 public:
  FrameRows() = default;
  /// `numbers` ascend.
  explicit FrameRows(std::span<const std::size_t> numbers);
  /// Rows of the frames of `map`, which was read from the database.
  FrameRows(const sqlite::Database& database, const TopologicalMap& map);

  /// The rows of these frames in order of their numbers, in column `frame`. This must live as long.
  sqlite::Statement select(const sqlite::Database& database, std::string_view columns, std::string_view table,
                           std::string_view frame) const;

 private:
  /// Frame numbers as a JSON array.
  std::optional<std::string> numbers_;
};

/// All but descriptors, images and states, checked before use. `maxFrames`, `also`: see MapStore::load().
TopologicalMap readContent(const sqlite::Database& database, const MapStore::Identity& identity,
                           std::size_t maxFrames, const std::vector<std::size_t>& also);

/// The runs of frames at one place, in order.
std::vector<Visit> readVisits(const sqlite::Database& database);

/// The number that the next frame will have: of all that were mapped, kept or left out.
std::size_t frameCountOf(const sqlite::Database& database);

/// The meta key of how many frames were mapped but are not kept, and its value.
constexpr const char* leftOutKey = "left_out";
std::size_t leftOutOf(const sqlite::Database& database);

/// In order of first frames, which are numbers.
std::vector<Transition> readTransitions(const sqlite::Database& database);

/// Drives of the map, in order of frames.
std::vector<Drive> readDrives(const sqlite::Database& database);

/// Copies a blob of `labels` float32 values. Throws Error for another length or a value out of 0 … 1.
void readValues(const sqlite::Database& database, std::span<const std::byte> bytes, std::size_t labels,
                const std::string& what, std::vector<float>& values);

}  // namespace estancia
