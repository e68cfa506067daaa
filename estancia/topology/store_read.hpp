// Map file reader: every number and length is checked before it is used, and texts are printable(). Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "estancia/topology/sqlite.hpp"
#include "estancia/topology/store.hpp"

namespace estancia {

/// Throws Error when the labels do not match their digest.
MapStore::Identity readIdentity(sqlite::Database& database);

/// The parts of a vocabulary as JSON, [[labels, weight], …].
std::string partsToJson(const Vocabulary& vocabulary);

/// Everything but descriptors, images and states. Every number and length is checked before it is used.
/// `mostFrames`: see MapStore::load().
TopologicalMap readContent(sqlite::Database& database, const MapStore::Identity& identity,
                           std::size_t mostFrames);

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

/// Those that the map names, in order of frames.
std::vector<Drive> readDrives(sqlite::Database& database);

/// The number in a column. Throws Error when it is none; `what` names it.
double finiteReal(const sqlite::Database& database, const sqlite::Statement& row, int column,
                  const char* what);

/// Copies a blob of `labels` float32 values. Throws Error when it has another length or a value that is not
/// finite; `what` names it.
void readValues(const sqlite::Database& database, std::span<const std::byte> bytes, std::size_t labels,
                const std::string& what, std::vector<float>& values);

}  // namespace estancia
