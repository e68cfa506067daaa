// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/published_messages.hpp"

#include "estancia/core/fail.hpp"
#include "estancia/ros/wire.hpp"

namespace estancia::ros {
namespace {

template <class Numbers>
void putAll(CdrWriter& cdr, const Numbers& numbers) {
  for (const auto number : numbers) cdr.put(number);
}

template <class Rows>
void putRows(CdrWriter& cdr, const Rows& rows) {
  cdr.putCount(rows.size());
  for (const auto& row : rows) putAll(cdr, row);
}

void putHeader(CdrWriter& cdr, std::int64_t stamp, const std::string& frame) {
  cdr.putTime(stamp);
  cdr.put(frame);
}

/// texture_resource, texture (an empty sensor_msgs/CompressedImage) and uv_coordinates.
void putNoTexture(CdrWriter& cdr) {
  cdr.put("");
  putHeader(cdr, 0, "");
  cdr.put("");
  cdr.putCount(0);
  cdr.putCount(0);
}

/// mesh_resource, mesh_file and mesh_use_embedded_materials.
void putNoMesh(CdrWriter& cdr) {
  cdr.put("");
  cdr.put("");
  cdr.putCount(0);
  cdr.put(false);
}

void putMarker(CdrWriter& cdr, const Marker& marker) {
  if (!marker.colors.empty() && marker.colors.size() != marker.points.size())
    fail(ErrorCode::invalidInput, "marker {} of \"{}\" has {} points and {} colors; give as many, or none",
         marker.id, marker.space, marker.points.size(), marker.colors.size());
  putHeader(cdr, marker.stamp, marker.frame);
  cdr.put(marker.space);
  cdr.put(marker.id);
  cdr.put(marker.type);
  cdr.put(marker.action);
  putAll(cdr, marker.position);
  putAll(cdr, marker.orientation);
  putAll(cdr, marker.scale);
  putAll(cdr, marker.color);
  cdr.putTime(marker.lifetime);
  cdr.put(marker.frameLocked);
  putRows(cdr, marker.points);
  putRows(cdr, marker.colors);
  putNoTexture(cdr);
  cdr.put(marker.text);
  putNoMesh(cdr);
}

}  // namespace

std::vector<std::byte> stringMessage(const std::string& text) {
  CdrWriter cdr;
  cdr.put(text);
  return cdr.take();
}

std::vector<std::byte> imageMessage(std::int64_t stamp, const std::string& frame, std::uint32_t width,
                                    std::uint32_t height, const std::string& encoding,
                                    std::span<const std::byte> data) {
  if (height == 0 ? !data.empty() : data.size() % height != 0)
    fail(ErrorCode::invalidInput, "{} bytes are not {} rows of an image; give whole rows", data.size(),
         height);
  CdrWriter cdr;
  putHeader(cdr, stamp, frame);
  cdr.put(height);
  cdr.put(width);
  cdr.put(encoding);
  cdr.put(false);
  cdr.putCount(height == 0 ? 0 : data.size() / height);
  cdr.putBytes(data);
  return cdr.take();
}

std::vector<std::byte> markerArrayMessage(const std::vector<Marker>& markers) {
  CdrWriter cdr;
  cdr.putCount(markers.size());
  for (const Marker& marker : markers) putMarker(cdr, marker);
  return cdr.take();
}

}  // namespace estancia::ros
