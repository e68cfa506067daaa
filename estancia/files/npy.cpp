// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/npy.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <string_view>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

static_assert(std::endian::native == std::endian::little, "values are copied as they are");

constexpr std::string_view magic = "\x93NUMPY";
constexpr std::size_t maxHeaderBytes = 65536;

/// The value of 'KEY': in the header, a Python dictionary as NumPy writes it.
std::string_view valueOf(std::string_view header, std::string_view key) {
  for (const char quote : {'\'', '"'}) {
    const std::string quoted = quote + std::string(key) + quote;
    const auto found = header.find(quoted);
    if (found == std::string_view::npos) continue;
    header.remove_prefix(found + quoted.size());
    const auto begin = header.find_first_not_of(" :");
    return begin == std::string_view::npos ? "" : header.substr(begin);
  }
  return "";
}

/// (12, 34) or (12, 34, )
std::vector<std::size_t> shapeOf(std::string_view text) {
  std::vector<std::size_t> shape;
  if (!text.starts_with('(')) return shape;
  text = text.substr(1, text.find(')') - 1);
  while (shape.size() < 8) {
    const auto begin = text.find_first_not_of(" ,L");  // Python 2 wrote 12L
    if (begin == std::string_view::npos) break;
    text.remove_prefix(begin);
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return {};
    shape.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return shape;
}

}  // namespace

NpyFile::NpyFile(const fs::path& file) : name_(printable(file)) {
  const auto refuse = [this](const std::string& what, ErrorCode code = ErrorCode::unsupportedFile) {
    throw Error(code, fmt::format("{}: {}", name_, what));
  };
  std::error_code error;
  if (!fs::is_regular_file(file, error)) refuse("no such file", ErrorCode::fileNotFound);
  const std::uintmax_t size = fs::file_size(file, error);
  stream_.open(file, std::ios::binary);
  if (error || !stream_) refuse("cannot be read; check its permissions", ErrorCode::fileUnreadable);

  unsigned char start[12] = {};
  stream_.read(reinterpret_cast<char*>(start), 10);
  if (!stream_ || std::memcmp(start, magic.data(), magic.size()) != 0)
    refuse("not a .npy file; write it with numpy.save");
  const int version = start[6];
  if (version < 1 || version > 3)
    refuse(fmt::format(".npy file of version {}; versions 1 to 3 are read", version));
  std::size_t length = start[8] | static_cast<std::size_t>(start[9]) << 8U, begin = 10;
  if (version > 1) {
    stream_.read(reinterpret_cast<char*>(start) + 10, 2);
    length |= static_cast<std::size_t>(start[10]) << 16U | static_cast<std::size_t>(start[11]) << 24U;
    begin = 12;
  }
  if (!stream_ || length > maxHeaderBytes || begin + length > size)
    refuse(fmt::format("the header of {} bytes is truncated", length), ErrorCode::truncatedFile);
  std::string header(length, '\0');
  if (!stream_.read(header.data(), static_cast<std::streamsize>(length)))
    refuse("the header cannot be read", ErrorCode::truncatedFile);

  const std::string_view type = valueOf(header, "descr");
  const std::string kind(type.substr(0, type.find_first_of(",}")));
  if (kind == "'<f4'")
    bytesPerValue_ = 4;
  else if (kind == "'<f8'")
    bytesPerValue_ = 8;
  else
    refuse(fmt::format("numbers of type {}; write float32: numpy.save(file, array.astype('<f4'))",
                       printable(kind)));
  if (!valueOf(header, "fortran_order").starts_with("False"))
    refuse("Fortran order; write it with numpy.save(file, numpy.ascontiguousarray(array))");
  const auto shape = shapeOf(valueOf(header, "shape"));
  if (shape.size() != 2 || shape[0] == 0 || shape[1] == 0)
    refuse("the shape must be (images, labels), neither of them 0");
  const std::uintmax_t held = (size - begin - length) / bytesPerValue_;
  // By division: a hostile shape overflows the product.
  const bool whole = shape[1] <= held && held / shape[1] == shape[0] && held % shape[1] == 0 &&
                     (size - begin - length) % bytesPerValue_ == 0;
  if (!whole)
    refuse(fmt::format("shape ({}, {}), but {} bytes of numbers; it is truncated or damaged", shape[0],
                       shape[1], size - begin - length),
           ErrorCode::truncatedFile);
  rows_ = shape[0];
  columns_ = shape[1];
  bytes_.resize(columns_ * bytesPerValue_);
  row_.resize(columns_);
}

const std::vector<double>& NpyFile::next() {
  if (!stream_.read(bytes_.data(), static_cast<std::streamsize>(bytes_.size())))
    fail(ErrorCode::fileUnreadable, "{}: cannot be read to its end", name_);
  for (std::size_t i = 0; i < columns_; ++i) {
    if (bytesPerValue_ == 8) {
      std::memcpy(&row_[i], bytes_.data() + 8 * i, 8);
    } else {
      float value = 0;
      std::memcpy(&value, bytes_.data() + 4 * i, 4);
      row_[i] = static_cast<double>(value);
    }
  }
  return row_;
}

std::string npyBytes(const DescriptorMatrix& matrix) {
  std::string header = fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}",
                                   matrix.size(), matrix.labels());
  header.append(64 - (10 + header.size() + 1) % 64, ' ');  // so that the numbers are aligned, as by NumPy
  header += '\n';
  std::string bytes(magic);
  bytes += {'\x01', '\x00', static_cast<char>(header.size() & 0xFFU), static_cast<char>(header.size() >> 8U)};
  bytes += header;
  const auto& values = matrix.values();
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  return bytes;
}

}  // namespace estancia::io
