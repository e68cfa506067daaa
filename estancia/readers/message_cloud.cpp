// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "estancia/core/fail.hpp"
#include "estancia/files/pcd.hpp"
#include "estancia/readers/message_image.hpp"

namespace estancia::io {
namespace {

constexpr std::uint64_t maxCloudPoints = std::uint64_t{1} << 26;
constexpr std::array<std::size_t, 9> bytesOfFieldType = {0, 1, 1, 2, 2, 4, 4, 4, 8};

/// Where a number of each point is, and how it is stored.
struct NumberField {
  std::size_t offset = 0;
  std::uint8_t type = 0;
  bool isSwapped = false;

  template <class Value>
  double as(const std::byte* point) const {
    std::array<std::byte, sizeof(Value)> bytes{};
    std::memcpy(bytes.data(), point + offset, sizeof(Value));
    if (isSwapped) std::ranges::reverse(bytes);
    return static_cast<double>(std::bit_cast<Value>(bytes));
  }
  double of(const std::byte* point) const {
    switch (type) {
      case 1:
        return as<std::int8_t>(point);
      case 2:
        return as<std::uint8_t>(point);
      case 3:
        return as<std::int16_t>(point);
      case 4:
        return as<std::uint16_t>(point);
      case 5:
        return as<std::int32_t>(point);
      case 6:
        return as<std::uint32_t>(point);
      case 7:
        return as<float>(point);
      default:
        return as<double>(point);
    }
  }
};

std::optional<NumberField> findField(const ros::PointCloudMessage& message, const char* name) {
  const auto found = std::ranges::find(message.fields, name, &ros::PointField::name);
  if (found == message.fields.end()) return std::nullopt;
  if (found->type == 0 || found->type >= bytesOfFieldType.size() ||
      std::uint64_t{found->offset} + bytesOfFieldType[found->type] > message.pointStep)
    fail(ErrorCode::malformedFile, "the field {} of a cloud is not inside its points of {} bytes", name,
         message.pointStep);
  return NumberField{found->offset, found->type,
                     message.bigEndian != (std::endian::native == std::endian::big)};
}

}  // namespace

ImageContent contentOf(const ros::PointCloudMessage& message) {
  return message.height > 1 ? ImageContent::depth : ImageContent::unknown;
}

cv::Mat depthOf(const ros::PointCloudMessage& message) {
  return depthOf(cloudOf(message));
}

PointCloud cloudOf(const ros::PointCloudMessage& message) {
  const std::uint64_t width = message.width, height = message.height;
  if (width > maxCloudPoints || height > maxCloudPoints || width * height > maxCloudPoints)
    fail(ErrorCode::tooLarge, "a cloud of {} × {} points; at most {} are read", width, height,
         maxCloudPoints);
  const std::uint64_t rowStep = message.rowStep == 0 ? width * message.pointStep : message.rowStep;
  if (width * height > 0 && (rowStep < width * message.pointStep ||
                             (height - 1) * rowStep + width * message.pointStep > message.data.size()))
    fail(ErrorCode::malformedFile, "a cloud of {} × {} points of {} bytes has only {} bytes", width, height,
         message.pointStep, message.data.size());
  const auto x = findField(message, "x"), y = findField(message, "y"), z = findField(message, "z");
  if (!x || !y || !z) fail(ErrorCode::unsupportedFile, "a cloud without the fields x, y and z");
  auto color = findField(message, "rgb");
  if (!color) color = findField(message, "rgba");
  if (color && bytesOfFieldType[color->type] != 4) color.reset();
  PointCloud cloud;
  cloud.width = width;
  cloud.height = height;
  cloud.points.reserve(width * height);
  for (std::uint64_t row = 0; row < height; ++row)
    for (std::uint64_t column = 0; column < width; ++column) {
      const std::byte* point = message.data.data() + row * rowStep + column * message.pointStep;
      cloud.points.emplace_back(static_cast<float>(x->of(point)), static_cast<float>(y->of(point)),
                                static_cast<float>(z->of(point)));
      if (!color) continue;
      std::array<unsigned char, 4> bgra{};  // 0xAARRGGBB in the bytes of a number
      std::memcpy(bgra.data(), point + color->offset, bgra.size());
      if (color->isSwapped) std::ranges::reverse(bgra);
      cloud.colors.emplace_back(bgra[0], bgra[1], bgra[2]);
    }
  return cloud;
}

}  // namespace estancia::io
