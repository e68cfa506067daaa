// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/png.hpp"

#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <new>
#include <opencv2/core.hpp>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

constexpr int fastest = 1;                         // zlib's compression level
constexpr png_alloc_size_t maxChunkBytes = 65536;  // beside the pixels; toPng() writes none

// libpng reports an error by a jump over its frames. So a function that it can jump back to has no object of
// its own to destroy; its callers have them.
[[noreturn]] void jumpBack(png_structp png, png_const_charp) {
  png_longjmp(png, 1);
}

void saySilently(png_structp, png_const_charp) {}

void appendPngBytes(png_structp png, png_bytep data, std::size_t size) {
  auto& file = *static_cast<std::vector<unsigned char>*>(png_get_io_ptr(png));
  bool fits = true;
  try {
    file.insert(file.end(), data, data + size);
  } catch (const std::bad_alloc&) {
    fits = false;  // no exception may pass libpng's frames
  }
  if (!fits) png_error(png, "no memory");
}

void takePngBytes(png_structp png, png_bytep data, std::size_t size) {
  auto& rest = *static_cast<std::span<const unsigned char>*>(png_get_io_ptr(png));
  if (rest.size() < size) png_error(png, "it ends early");
  std::copy_n(rest.begin(), size, data);
  rest = rest.subspan(size);
}

class PngWriter {
 public:
  explicit PngWriter(std::vector<unsigned char>& file)
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, jumpBack, saySilently)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {
    if (info_ != nullptr) png_set_write_fn(png_, &file, appendPngBytes, nullptr);
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  /// `image`: of a type that toPng() takes; `rows`: its rows.
  bool write(const cv::Mat& image, png_bytep* rows) {
    if (info_ == nullptr || setjmp(png_jmpbuf(png_)) != 0) return false;
    const int color = image.channels() == 1   ? PNG_COLOR_TYPE_GRAY
                      : image.channels() == 3 ? PNG_COLOR_TYPE_RGB
                                              : PNG_COLOR_TYPE_RGB_ALPHA;
    png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(image.cols), static_cast<png_uint_32>(image.rows),
                 image.depth() == CV_8U ? 8 : 16, color, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png_, fastest);
    png_write_info(png_, info_);
    if (image.channels() != 1) png_set_bgr(png_);
    if (image.depth() == CV_16U && std::endian::native == std::endian::little) png_set_swap(png_);
    png_write_image(png_, rows);
    png_write_end(png_, nullptr);
    return true;
  }

 private:
  png_structp png_;
  png_infop info_;
};

class PngReader {
 public:
  explicit PngReader(std::span<const unsigned char> file)
      : rest_(file),
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, jumpBack, saySilently)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {
    if (info_ != nullptr) png_set_read_fn(png_, &rest_, takePngBytes);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  /// Whether it is gray, of 8 or 16 bits, and not larger than `most`.
  bool readHeader(const cv::Size& most) {
    if (info_ == nullptr || setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_user_limits(png_, static_cast<png_uint_32>(most.width), static_cast<png_uint_32>(most.height));
    // libpng only warns of a longer chunk, and then clears as much memory as the chunk's header declares.
    png_set_chunk_malloc_max(png_, maxChunkBytes);
    png_set_benign_errors(png_, 0);
    png_set_chunk_cache_max(png_, 1);  // none: texts are skipped, and not inflated
    png_read_info(png_, info_);
    return png_get_color_type(png_, info_) == PNG_COLOR_TYPE_GRAY && png_get_bit_depth(png_, info_) >= 8;
  }

  /// All zeros.
  cv::Mat emptyImage() const {
    return cv::Mat::zeros(static_cast<int>(png_get_image_height(png_, info_)),
                          static_cast<int>(png_get_image_width(png_, info_)),
                          png_get_bit_depth(png_, info_) == 8 ? CV_8U : CV_16U);
  }

  /// Fills the rows of emptyImage().
  bool readRows(png_bytep* rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    if (png_get_bit_depth(png_, info_) == 16 && std::endian::native == std::endian::little)
      png_set_swap(png_);
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }

 private:
  std::span<const unsigned char> rest_;
  png_structp png_;
  png_infop info_;
};

std::vector<png_bytep> rowsOf(const cv::Mat& image) {
  std::vector<png_bytep> rows(static_cast<std::size_t>(image.rows));
  for (int y = 0; y < image.rows; ++y)
    rows[static_cast<std::size_t>(y)] = const_cast<png_bytep>(image.ptr(y));
  return rows;
}

}  // namespace

std::vector<unsigned char> toPng(const cv::Mat& image) {
  const int channels = image.channels();
  const bool isKnown = (image.depth() == CV_8U || image.depth() == CV_16U) &&
                       (channels == 1 || channels == 3 || channels == 4);
  std::vector<unsigned char> file;
  std::vector<png_bytep> rows = rowsOf(image);
  if (image.empty() || !isKnown || !PngWriter(file).write(image, rows.data()))
    fail(ErrorCode::invalidInput,
         "an image of {} × {} pixels ({}) cannot be encoded as PNG; give it 8 or 16 unsigned bits "
         "in 1, 3 or 4 channels",
         image.cols, image.rows, cv::typeToString(image.type()));
  return file;
}

cv::Mat fromPng(std::span<const unsigned char> png, const cv::Size& most) {
  PngReader reader(png);
  if (most.width < 1 || most.height < 1 || !reader.readHeader(most)) return {};
  cv::Mat image = reader.emptyImage();
  return reader.readRows(rowsOf(image).data()) ? image : cv::Mat();
}

}  // namespace estancia
