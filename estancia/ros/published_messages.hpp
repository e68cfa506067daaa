// Published messages: what Estancia publishes to ROS 2, in CDR: text, images, markers of RViz and Foxglove.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace estancia::ros {

/// visualization_msgs/Marker, but for textures and meshes.
struct Marker {
  /// The ones that are used.
  enum class Type : std::int32_t { cube = 1, sphere = 2, lineStrip = 4, lineList = 5, text = 9 };
  enum class Action : std::int32_t { add = 0, remove = 2, removeAll = 3 };
  /// r, g, b, a from 0 to 1.
  using Color = std::array<float, 4>;

  /// [ns]; 0: as new as it can be.
  std::int64_t stamp = 0;
  std::string frame = "map";
  /// Namespace and number together name a marker.
  std::string space;
  std::int32_t id = 0;
  Type type = Type::cube;
  Action action = Action::add;
  /// [m]
  std::array<double, 3> position{};
  /// x, y, z, w
  std::array<double, 4> orientation{0, 0, 0, 1};
  /// [m]; lines have their width in the first, text has its height in the third.
  std::array<double, 3> scale{1, 1, 1};
  Color color{1, 1, 1, 1};
  /// [ns]; 0: forever.
  std::int64_t lifetime = 0;
  /// Goes along with its frame.
  bool frameLocked = false;
  /// Points of lines and lists [m].
  std::vector<std::array<double, 3>> points;
  /// None, or one a point.
  std::vector<Color> colors;
  std::string text;
};

/// std_msgs/String
std::vector<std::byte> stringMessage(const std::string& text);

/// sensor_msgs/Image; `stamp` [ns]. Throws Error (invalidInput) unless `data` is `height` rows of one length.
std::vector<std::byte> imageMessage(std::int64_t stamp, const std::string& frame, std::uint32_t width,
                                    std::uint32_t height, const std::string& encoding,
                                    std::span<const std::byte> data);

/// visualization_msgs/MarkerArray as of Humble: earlier ROS 2 (Foxy, Galactic) has markers without textures,
/// and cannot read it. Throws Error (invalidInput) for colors that are not as many as points.
std::vector<std::byte> markerArrayMessage(const std::vector<Marker>& markers);

}  // namespace estancia::ros
