// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/compressed_depth.hpp"

#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <string_view>

#include "estancia/core/fail.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/image_decoding.hpp"

namespace estancia::io {
namespace {

constexpr const char* what = "a compressed depth image";
constexpr std::uint64_t maxDepthPixels = std::uint64_t{1} << 26;

template <class Value>
Value valueAt(std::string_view bytes, std::size_t at) {
  if (at + sizeof(Value) > bytes.size())
    fail(ErrorCode::malformedFile, "{} of {} bytes ends in its header", what, bytes.size());
  Value value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// RVL: words of 32 bits, little-endian, of eight nibbles each, the highest first. A number is nibbles of
/// three bits, the lowest first, whose top bit is set if more follow.
class RvlNibbles {
 public:
  explicit RvlNibbles(std::string_view bytes) : bytes_(bytes) {}

  std::uint32_t number() {
    std::uint32_t value = 0;
    for (int shift = 0; shift < 32; shift += 3) {
      const std::uint32_t nibble = next();
      value |= (nibble & 7U) << shift;
      if ((nibble & 8U) == 0) return value;
    }
    fail(ErrorCode::malformedFile, "{} in RVL holds a number that is too long", what);
  }

 private:
  std::uint32_t next() {
    if (left_ == 0) {
      if (at_ + sizeof word_ > bytes_.size())
        fail(ErrorCode::malformedFile, "{} in RVL ends too early", what);
      std::memcpy(&word_, bytes_.data() + at_, sizeof word_);
      at_ += sizeof word_;
      left_ = 8;
    }
    --left_;
    const std::uint32_t nibble = word_ >> 28;
    word_ <<= 4;
    return nibble;
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  std::uint32_t word_ = 0;
  int left_ = 0;
};

/// Runs of zeros and of differences between neighbors, zigzag-coded.
cv::Mat decodeRvl(std::string_view bytes) {
  const auto columns = valueAt<std::uint32_t>(bytes, 0), rows = valueAt<std::uint32_t>(bytes, 4);
  const std::uint64_t pixels = std::uint64_t{columns} * rows;
  if (pixels == 0 || pixels > maxDepthPixels || columns > maxDepthPixels || rows > maxDepthPixels)
    fail(ErrorCode::tooLarge, "{} of {} × {} pixels", what, columns, rows);
  cv::Mat image(static_cast<int>(rows), static_cast<int>(columns), CV_16U);
  auto* const values = image.ptr<std::uint16_t>();
  RvlNibbles nibbles(bytes.substr(8));
  std::uint16_t previous = 0;
  for (std::uint64_t at = 0; at < pixels;) {
    const std::uint64_t zeros = nibbles.number();
    const std::uint64_t others = at + zeros < pixels ? nibbles.number() : 0;
    if (zeros > pixels - at || others > pixels - at - zeros || zeros + others == 0)
      fail(ErrorCode::malformedFile, "{} in RVL holds more than its {} pixels", what, pixels);
    std::fill_n(values + at, zeros, std::uint16_t{0});
    at += zeros;
    for (const std::uint64_t end = at + others; at < end; ++at) {
      const std::uint32_t coded = nibbles.number();
      const std::uint32_t difference = (coded >> 1) ^ (~(coded & 1U) + 1U);
      previous = static_cast<std::uint16_t>(previous + difference);
      values[at] = previous;
    }
  }
  return image;
}

}  // namespace

cv::Mat readCompressedDepth(const ros::CompressedImageMessage& message, double unitsPerMeter) {
  const std::string_view bytes(reinterpret_cast<const char*>(message.data.data()), message.data.size());
  constexpr std::size_t header = 12;
  const float a = valueAt<float>(bytes, 4), b = valueAt<float>(bytes, 8);
  const std::string_view body = bytes.substr(header);
  const bool isRvl = message.format.find("rvl") != std::string::npos;
  if (!isRvl) inspectImage(body, what);
  const cv::Mat raw = isRvl ? decodeRvl(body) : decodeImage(body, DecodedAs::stored, what);
  if (message.format.find("32FC1") == std::string::npos) return metersOf(raw, unitsPerMeter, what);
  if (raw.type() != CV_16U)
    fail(ErrorCode::unsupportedFile, "{} of floats must be quantized to 16 bits", what);
  cv::Mat meters(raw.size(), CV_32F);
  for (int row = 0; row < raw.rows; ++row)
    for (int column = 0; column < raw.cols; ++column) {
      const auto value = static_cast<float>(raw.at<std::uint16_t>(row, column));
      meters.at<float>(row, column) = value > 0 && value > b ? a / (value - b) : 0;
    }
  return metersOf(meters, 1, what);
}

}  // namespace estancia::io
