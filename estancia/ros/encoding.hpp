// Serialization of ROS messages: ROS 1's own, and CDR of ROS 2.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace estancia::ros {

enum class Encoding {
  /// Little-endian and packed; strings have no terminating zero.
  ros1,
  /// OMG's Common Data Representation (XCDR1): a header of four bytes, then aligned from there.
  cdr
};

}  // namespace estancia::ros
