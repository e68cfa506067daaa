// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/image_file.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <span>

#include "estancia/core/base64.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/image_codecs.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/png.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/files/image_writer.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t maxImageBytes = std::size_t{1} << 29;

/// The bytes behind `export default 'data:…;base64,…'`.
std::string decodeDataUri(const std::string& text, const fs::path& file) {
  constexpr std::string_view mark = ";base64,";
  const auto start = text.find(mark);
  const auto begin = start + mark.size();
  const auto end = start == std::string::npos ? start : text.find_first_of("'\"`", begin);
  auto bytes = end == std::string::npos || end == begin
                   ? std::nullopt
                   : fromBase64(std::string_view(text).substr(begin, end - begin));
  if (!bytes) fail(ErrorCode::malformedFile, "{}: no complete data URI (data:…;base64,…)", printable(file));
  return *bytes;  // padding "=" decodes to zeros, which the decoders ignore
}

/// Returns the result of `call` on the bytes. Throws Error if it is empty.
template <class Call>
cv::Mat decode(std::string_view bytes, const fs::path& file, Call call) {
  const ImageCodecs& codecs = imageCodecs();
  cv::Mat image;
  try {
    image = call(codecs, std::span(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
  } catch (const cv::Exception&) {  // reported below
  }
  if (image.empty())
    fail(ErrorCode::malformedFile,
         "{}: the image cannot be decoded; it is damaged or of a rare kind; copy or convert it",
         printable(file));
  return image;
}

cv::Mat decodeReduced(std::string_view bytes, int divisor, const fs::path& file) {
  return decode(bytes, file, [divisor](const ImageCodecs& codecs, auto all) {
    return codecs.decodeReduced(all, divisor);
  });
}

/// 1, 2, 4 or 8: the largest that leaves the shorter side at least `side`.
int divisorFor(const ImageHeader& header, int side) {
  const auto least = static_cast<std::uint64_t>(side), shorter = std::min(header.width, header.height);
  int divisor = 1;
  while (divisor < 8 && shorter / (2 * static_cast<std::uint64_t>(divisor)) >= least) divisor *= 2;
  return divisor;
}

}  // namespace

cv::Mat decodeImage(std::string_view bytes, DecodedAs as, const fs::path& file) {
  return decode(bytes, file, [as](const ImageCodecs& codecs, auto all) { return codecs.decode(all, as); });
}

cv::Mat readPanorama(const fs::path& file) {
  std::string bytes = readBytes(file, maxImageBytes);
  if (file.extension() == ".js") bytes = decodeDataUri(bytes, file);
  const ImageHeader header = inspectImage(bytes, printable(file));
  const double ratio = static_cast<double>(header.width) / static_cast<double>(header.height);
  if (std::abs(ratio - 2) > 0.02)
    fail(ErrorCode::unsupportedFile,
         "{}: {} × {} pixels; an equirectangular panorama is twice as wide as high", printable(file),
         header.width, header.height);
  cv::Mat panorama = decodeImage(bytes, DecodedAs::color, file);
  return header.isRadiance() ? panorama : toBgr8(std::move(panorama));
}

cv::Mat decodeImage(const fs::path& file) {
  const std::string bytes = readBytes(file, maxImageBytes);
  inspectImage(bytes, printable(file));
  return decodeImage(bytes, DecodedAs::stored, file);
}

cv::Mat onlyChannel(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat first, other;
  cv::extractChannel(image, first, 0);
  for (int c = 1; c < std::min(image.channels(), 3); ++c) {
    cv::extractChannel(image, other, c);
    if (cv::norm(first, other, cv::NORM_INF) != 0) return {};
  }
  return first;
}

cv::Mat toBgr8(cv::Mat image) {
  if (image.depth() == CV_16U) image.convertTo(image, CV_8U, 1 / 257.0);
  if (image.depth() != CV_8U) {
    image.convertTo(image, CV_32F);
    cv::patchNaNs(image, 0);
    image.convertTo(image, CV_8U, 255);
  }
  if (image.channels() == 1) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
  return image;
}

}  // namespace estancia::io

namespace estancia {

cv::Mat readImage(const std::filesystem::path& file) {
  return readReducedImage(file, 0);
}

cv::Mat readReducedImage(const std::filesystem::path& file, int side) {
  const std::string bytes = io::readBytes(file, io::maxImageBytes);
  const io::ImageHeader header = io::inspectImage(bytes, io::printable(file));
  if (header.isRadiance())
    fail(ErrorCode::unsupportedFile,
         "{}: an HDR radiance map, not an image; open its folder (--type panorama)", io::printable(file));
  const int divisor = side > 0 && header.format == "JPEG" ? io::divisorFor(header, side) : 1;
  if (divisor > 1) return io::decodeReduced(bytes, divisor, file);
  return io::toBgr8(io::decodeImage(bytes, DecodedAs::color, file));
}

std::vector<unsigned char> encodeImage(const cv::Mat& bgr, int width) {
  cv::Mat small = bgr;
  if (bgr.cols > width) {
    const int height = std::max(1, static_cast<int>(std::lround(1.0 * bgr.rows * width / bgr.cols)));
    cv::resize(bgr, small, {width, height}, 0, 0, cv::INTER_AREA);
  }
  std::vector<unsigned char> jpeg = imageCodecs().encodeJpeg(small, /*quality=*/82);
  if (jpeg.empty())
    throw Error(ErrorCode::missingDependency, "cannot encode JPEG; OpenCV was built without it");
  return jpeg;
}

void writePng(const cv::Mat& bgr, const std::filesystem::path& file) {
  if (bgr.empty()) fail(ErrorCode::invalidInput, "{}: the image to write is empty", file.string());
  const std::vector<unsigned char> png = toPng(bgr);
  writeWhole(file, {reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace estancia
