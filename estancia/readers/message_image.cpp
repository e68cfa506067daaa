// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/message_image.hpp"

#include <algorithm>
#include <bit>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/readers/compressed_depth.hpp"

namespace estancia::io {
namespace {

constexpr std::uint64_t maxPixels = std::uint64_t{1} << 26;

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
  inspectImage(bytes, "a compressed depth image");
  return metersOf(decodeImage(bytes, DecodedAs::stored, "a compressed depth image"), unitsPerMeter,
                  "a compressed depth image");
}

}  // namespace estancia::io
