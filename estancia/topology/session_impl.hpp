// Mapping session implementation: a map file, its mapper, and what labels images. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <exception>

#include <functional>
#include <opencv2/core/affine.hpp>
#include <optional>

#include "estancia/topology/drive_alignment.hpp"
#include "estancia/topology/drive_guide.hpp"
#include "estancia/topology/session.hpp"
#include "estancia/topology/store.hpp"

namespace estancia {

struct MappingSession::Impl {
  MapStore store;
  Mapper mapper;
  Labeler* labeler = nullptr;
  std::chrono::steady_clock::time_point lastWritten = std::chrono::steady_clock::now();
  /// In flight when the session began.
  int exceptions = std::uncaught_exceptions();
  bool finished = true;
  /// The last one.
  Drive drive = {};
  /// Of drives but the first.
  std::optional<DriveGuide> guide = {};
  /// Of a drive whose poses are not known in the map yet.
  std::optional<DriveAlignment> alignment = {};
  std::size_t nextAlignment = 0;  ///< pairs
  /// Looks at depth: the transform that is right where one is near `guess` (T_map_drive), else nothing. Where
  /// it is not set, words decide.
  std::function<std::optional<cv::Affine3d>(const cv::Affine3d& guess)> verify = {};

  void beginDrive(const DriveStart& start);
  /// Goes on with the last drive of the file.
  void restoreDrive();
  /// A pose that add() was given, in the map.
  std::optional<Pose> inMap(const std::optional<Pose>& given) const;
  void align();

  /// Without writing.
  int add(const Frame& frame, DescriptorView descriptor, const Image& image);
  void correct(const std::vector<Correction>& corrections);
  void writeWhenDue();
  /// What has changed since the last time.
  void write();
  const MapStore& written();
};

/// The mapper that a map file was made with, as it was at the last commit.
Mapper restoreMapper(const MapStore& store);

}  // namespace estancia
