// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/message_image.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string_view>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/files/pcd.hpp"
#include "estancia/files/scalar.hpp"

namespace estancia::io {
namespace {

constexpr std::uint64_t maxPixels = std::uint64_t{1} << 26;
constexpr const char* whatDepth = "a compressed depth image";

/// How an encoding of sensor_msgs/image_encodings is stored, and what makes BGR or gray of it.
struct PixelFormat {
  const char* encoding;
  int type;
  /// A code of cv::cvtColor; -1: it is BGR or gray already.
  int conversion = -1;
  ImageContent content = ImageContent::color;
  /// Rows of the data for three rows of the image: 3, but 4½ of nv21.
  double rowsOfThree = 3;
};

// OpenCV names a Bayer pattern by its second row's second and third pixel: RGGB is its BG.
constexpr PixelFormat pixelFormats[] = {
    {"bgr8", CV_8UC3},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
    {"bgr16", CV_16UC3},
    {"rgb16", CV_16UC3, cv::COLOR_RGB2BGR},
    {"bgra16", CV_16UC4, cv::COLOR_BGRA2BGR},
    {"rgba16", CV_16UC4, cv::COLOR_RGBA2BGR},
    {"mono8", CV_8UC1, -1, ImageContent::gray},
    {"mono16", CV_16UC1, -1, ImageContent::depth},
    {"8UC1", CV_8UC1, -1, ImageContent::gray},
    {"8UC3", CV_8UC3},
    {"8UC4", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"16UC1", CV_16UC1, -1, ImageContent::depth},
    {"16UC3", CV_16UC3},
    {"32FC1", CV_32FC1, -1, ImageContent::depth},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2BGR},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2BGR},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"uyvy", CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"yuyv", CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"nv21", CV_8UC1, cv::COLOR_YUV2BGR_NV21, ImageContent::color, 4.5},
    {"nv12", CV_8UC1, cv::COLOR_YUV2BGR_NV12, ImageContent::color, 4.5},
};

const PixelFormat* findPixelFormat(const std::string& encoding) {
  const auto* found = std::ranges::find_if(
      pixelFormats, [&](const PixelFormat& format) { return encoding == format.encoding; });
  return found == std::end(pixelFormats) ? nullptr : found;
}

void swapBytes(cv::Mat& pixels) {
  const std::size_t size = pixels.elemSize1(),
                    bytes = static_cast<std::size_t>(pixels.cols) * pixels.elemSize();
  for (int row = 0; row < pixels.rows; ++row)
    for (unsigned char* value = pixels.ptr(row); value < pixels.ptr(row) + bytes; value += size)
      std::reverse(value, value + size);
}

/// The values as they are stored: of the message's memory, unless its bytes had to be swapped.
cv::Mat storedPixels(const ros::ImageMessage& message, const PixelFormat& format) {
  const std::uint64_t width = message.width, height = message.height;
  if (width == 0 || height == 0)
    fail(ErrorCode::malformedFile, "an image of {} × {} pixels has none", width, height);
  if (width > maxPixels || height > maxPixels || width * height > maxPixels)
    fail(ErrorCode::tooLarge, "an image of {} × {} pixels; at most {} are read", width, height, maxPixels);
  const std::uint64_t rows = format.rowsOfThree == 3 ? height : height * 3 / 2;
  const std::uint64_t rowBytes = width * static_cast<std::uint64_t>(CV_ELEM_SIZE(format.type));
  const std::uint64_t step = message.step == 0 ? rowBytes : message.step;
  const std::uint64_t numberBytes = CV_ELEM_SIZE1(format.type);
  if (step < rowBytes || step % numberBytes != 0 || (rows - 1) * step + rowBytes > message.data.size())
    fail(ErrorCode::malformedFile,
         "an image of {} × {} pixels in {} has {} bytes in rows of {}; it needs rows of {}, {} in all", width,
         height, message.encoding, message.data.size(), step, rowBytes, rows * rowBytes);
  // OpenCV takes no pointer to constant data; the data are not written to.
  auto* const data = const_cast<std::byte*>(message.data.data());
  cv::Mat pixels(static_cast<int>(rows), static_cast<int>(width), format.type, data, step);
  if (message.bigEndian == (std::endian::native == std::endian::big) || pixels.elemSize1() == 1)
    return pixels;
  pixels = pixels.clone();
  swapBytes(pixels);
  return pixels;
}

const PixelFormat& getPixelFormat(const ros::ImageMessage& message) {
  const PixelFormat* format = findPixelFormat(message.encoding);
  if (format == nullptr)
    fail(ErrorCode::unsupportedFile,
         "images in \"{}\" are not read; record rgb8, bgr8, mono8, a Bayer pattern, yuv422, 16UC1 or 32FC1",
         printable(message.encoding));
  return *format;
}

std::string_view textOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class Value>
Value headerValue(std::string_view bytes, std::size_t at) {
  if (at + sizeof(Value) > bytes.size())
    fail(ErrorCode::malformedFile, "{} of {} bytes ends in its header", whatDepth, bytes.size());
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
    fail(ErrorCode::malformedFile, "{} in RVL holds a number that is too long", whatDepth);
  }

 private:
  std::uint32_t next() {
    if (left_ == 0) {
      if (at_ + sizeof word_ > bytes_.size())
        fail(ErrorCode::malformedFile, "{} in RVL ends too early", whatDepth);
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
  const auto columns = headerValue<std::uint32_t>(bytes, 0), rows = headerValue<std::uint32_t>(bytes, 4);
  const std::uint64_t pixels = std::uint64_t{columns} * rows;
  if (pixels == 0 || pixels > maxPixels || columns > maxPixels || rows > maxPixels)
    fail(ErrorCode::tooLarge, "{} of {} × {} pixels", whatDepth, columns, rows);
  cv::Mat image(static_cast<int>(rows), static_cast<int>(columns), CV_16U);
  auto* const values = image.ptr<std::uint16_t>();
  RvlNibbles nibbles(bytes.substr(8));
  std::uint16_t previous = 0;
  for (std::uint64_t at = 0; at < pixels;) {
    const std::uint64_t zeros = nibbles.number();
    const std::uint64_t others = at + zeros < pixels ? nibbles.number() : 0;
    if (zeros > pixels - at || others > pixels - at - zeros || zeros + others == 0)
      fail(ErrorCode::malformedFile, "{} in RVL holds more than its {} pixels", whatDepth, pixels);
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

cv::Mat readCompressedDepth(const ros::CompressedImageMessage& message, double unitsPerMeter) {
  const std::string_view bytes = textOf(message.data);
  constexpr std::size_t header = 12;
  const float a = headerValue<float>(bytes, 4), b = headerValue<float>(bytes, 8);
  const std::string_view body = bytes.substr(header);
  const bool isRvl = message.format.find("rvl") != std::string::npos;
  if (!isRvl) inspectImage(body, whatDepth);
  const cv::Mat raw = isRvl ? decodeRvl(body) : decodeImage(body, DecodedAs::stored, whatDepth);
  if (message.format.find("32FC1") == std::string::npos) return metersOf(raw, unitsPerMeter, whatDepth);
  if (raw.type() != CV_16U)
    fail(ErrorCode::unsupportedFile, "{} of floats must be quantized to 16 bits", whatDepth);
  cv::Mat meters(raw.size(), CV_32F);
  for (int row = 0; row < raw.rows; ++row)
    for (int column = 0; column < raw.cols; ++column) {
      const auto value = static_cast<float>(raw.at<std::uint16_t>(row, column));
      meters.at<float>(row, column) = value > 0 && value > b ? a / (value - b) : 0;
    }
  return metersOf(meters, 1, whatDepth);
}

/// The types of sensor_msgs/PointField, from 1.
constexpr std::array<Scalar, 8> fieldTypes = {
    {{'I', 1}, {'U', 1}, {'I', 2}, {'U', 2}, {'I', 4}, {'U', 4}, {'F', 4}, {'F', 8}}};

/// Where a number of each point is, and how it is stored.
struct NumberField {
  std::size_t offset = 0;
  Scalar type;
  bool isSwapped = false;

  float of(const std::byte* point) const {
    return static_cast<float>(numberAt(type, reinterpret_cast<const char*>(point + offset), isSwapped));
  }
};

std::optional<NumberField> findField(const ros::PointCloudMessage& message, const char* name) {
  const auto found = std::ranges::find(message.fields, name, &ros::PointField::name);
  if (found == message.fields.end()) return std::nullopt;
  const bool isKnown = found->type >= 1 && found->type <= fieldTypes.size();
  const Scalar type = isKnown ? fieldTypes[found->type - 1U] : Scalar();
  if (!isKnown || std::uint64_t{found->offset} + type.size > message.pointStep)
    fail(ErrorCode::malformedFile, "the field {} of a cloud is not inside its points of {} bytes", name,
         message.pointStep);
  return NumberField{found->offset, type, message.bigEndian};
}

}  // namespace

ImageContent contentOf(const ros::ImageMessage& message) {
  const PixelFormat* format = findPixelFormat(message.encoding);
  return format == nullptr ? ImageContent::unknown : format->content;
}

ImageContent contentOf(const ros::CompressedImageMessage& message) {
  if (message.format.find("compressedDepth") != std::string::npos) return ImageContent::depth;
  const std::string stored = message.format.substr(0, message.format.find(';'));
  const PixelFormat* format = findPixelFormat(stored);
  if (format != nullptr && stored != message.format) return format->content;
  return message.data.empty() ? ImageContent::unknown : ImageContent::color;
}

cv::Mat imageOf(const ros::ImageMessage& message) {
  const PixelFormat& format = getPixelFormat(message);
  const cv::Mat stored = storedPixels(message, format);
  if (format.rowsOfThree != 3 && (stored.rows % 3 != 0 || stored.cols % 2 != 0))
    fail(ErrorCode::malformedFile, "an image of {} × {} pixels cannot be {}", message.width, message.height,
         message.encoding);
  if (format.conversion < 0) return toBgr8(stored.clone());
  cv::Mat image;
  cv::cvtColor(stored, image, format.conversion);
  return toBgr8(image);
}

cv::Mat imageOf(const ros::CompressedImageMessage& message) {
  const std::string_view bytes = textOf(message.data);
  inspectImage(bytes, "a compressed image");
  return toBgr8(decodeImage(bytes, DecodedAs::color, "a compressed image"));
}

cv::Mat depthOf(const ros::ImageMessage& message, double unitsPerMeter) {
  const PixelFormat& format = getPixelFormat(message);
  if (format.content != ImageContent::depth)
    fail(ErrorCode::unsupportedFile, "images in {} are not depth; depth is 16UC1, mono16 or 32FC1",
         message.encoding);
  return metersOf(storedPixels(message, format), unitsPerMeter, "a depth image");
}

cv::Mat depthOf(const ros::CompressedImageMessage& message, double unitsPerMeter) {
  if (message.format.find("compressedDepth") != std::string::npos)
    return readCompressedDepth(message, unitsPerMeter);
  const std::string_view bytes = textOf(message.data);
  inspectImage(bytes, whatDepth);
  return metersOf(decodeImage(bytes, DecodedAs::stored, whatDepth), unitsPerMeter, whatDepth);
}

ImageContent contentOf(const ros::SerializedMessage& message, const std::string& type, std::string& frame) {
  const auto contentIn = [&frame](const auto& read) {
    frame = read.header.frame;
    return contentOf(read);
  };
  if (type == "sensor_msgs/Image") return contentIn(ros::readImageMessage(message));
  if (type == "sensor_msgs/PointCloud2") return contentIn(ros::readPointCloud(message));
  return contentIn(ros::readCompressedImage(message));
}

cv::Mat imageOf(const ros::SerializedMessage& message, const std::string& type) {
  return type == "sensor_msgs/Image" ? imageOf(ros::readImageMessage(message))
                                     : imageOf(ros::readCompressedImage(message));
}

cv::Mat depthOf(const ros::SerializedMessage& message, const std::string& type, double unitsPerMeter) {
  if (type == "sensor_msgs/PointCloud2") return depthOf(ros::readPointCloud(message));
  return type == "sensor_msgs/Image" ? depthOf(ros::readImageMessage(message), unitsPerMeter)
                                     : depthOf(ros::readCompressedImage(message), unitsPerMeter);
}

ImageContent contentOf(const ros::PointCloudMessage& message) {
  return message.height > 1 ? ImageContent::depth : ImageContent::unknown;
}

cv::Mat depthOf(const ros::PointCloudMessage& message) {
  return depthOf(cloudOf(message));
}

PointCloud cloudOf(const ros::PointCloudMessage& message) {
  const std::uint64_t width = message.width, height = message.height;
  if (width > maxPixels || height > maxPixels || width * height > maxPixels)
    fail(ErrorCode::tooLarge, "a cloud of {} × {} points; at most {} are read", width, height, maxPixels);
  const std::uint64_t rowStep = message.rowStep == 0 ? width * message.pointStep : message.rowStep;
  if (width * height > 0 && (rowStep < width * message.pointStep ||
                             (height - 1) * rowStep + width * message.pointStep > message.data.size()))
    fail(ErrorCode::malformedFile, "a cloud of {} × {} points of {} bytes has only {} bytes", width, height,
         message.pointStep, message.data.size());
  const auto x = findField(message, "x"), y = findField(message, "y"), z = findField(message, "z");
  if (!x || !y || !z) fail(ErrorCode::unsupportedFile, "a cloud without the fields x, y and z");
  auto color = findField(message, "rgb");
  if (!color) color = findField(message, "rgba");
  if (color && color->type.size != 4) color.reset();
  PointCloud cloud;
  cloud.width = width;
  cloud.height = height;
  cloud.points.reserve(width * height);
  for (std::uint64_t row = 0; row < height; ++row)
    for (std::uint64_t column = 0; column < width; ++column) {
      const std::byte* point = message.data.data() + row * rowStep + column * message.pointStep;
      cloud.points.emplace_back(x->of(point), y->of(point), z->of(point));
      if (!color) continue;
      std::array<unsigned char, 4> bgra{};  // 0xAARRGGBB in the bytes of a number
      std::memcpy(bgra.data(), point + color->offset, bgra.size());
      if (color->isSwapped) std::ranges::reverse(bgra);
      cloud.colors.emplace_back(bgra[0], bgra[1], bgra[2]);
    }
  return cloud;
}

}  // namespace estancia::io
