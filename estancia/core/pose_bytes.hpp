// Pose bytes: poses in the states that map files keep. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/core/bytes.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

inline void write(ByteWriter& bytes, const Pose& pose) {
  for (const double value : {pose.x, pose.y, pose.z, pose.qx, pose.qy, pose.qz, pose.qw}) bytes.number(value);
}

/// Throws Error: truncatedFile, and `code` for numbers that are no pose.
inline Pose readPose(ByteReader& bytes, ErrorCode code = ErrorCode::malformedFile) {
  Pose pose;
  for (double* value : {&pose.x, &pose.y, &pose.z, &pose.qx, &pose.qy, &pose.qz, &pose.qw})
    *value = bytes.number<double>();
  if (!pose.isPlausible()) bytes.fail("a pose is not finite", code);
  return pose;
}

}  // namespace estancia
