// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/pcd.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/scalar.hpp"

namespace estancia {
namespace {

/// Largest compression factor of LZF (format of Marc Lehmann's LibLZF): three bytes stand for at most 264.
constexpr std::size_t maxLzfGain = 88;

/// Decompresses `packed` to `size` bytes. Throws Error when it is damaged or of another size.
std::string unpackLzf(std::string_view packed, std::size_t size) {
  const auto damaged = [] { return Error(ErrorCode::corruptFile, "damaged compressed data"); };
  if (size / maxLzfGain > packed.size()) throw damaged();
  std::string bytes;
  bytes.reserve(size);
  std::size_t i = 0;
  const auto next = [&] {
    if (i == packed.size()) throw damaged();
    return static_cast<unsigned char>(packed[i++]);
  };
  while (i < packed.size()) {
    const std::size_t control = next();
    if (control < 32) {  // literal: that many bytes and one
      const std::size_t count = control + 1;
      if (count > packed.size() - i || count > size - bytes.size()) throw damaged();
      bytes += packed.substr(i, count);
      i += count;
      continue;
    }
    std::size_t count = control >> 5U;  // a match: how long …
    if (count == 7) count += next();
    count += 2;
    const std::size_t back = ((control & 31U) << 8U) + next() + 1;  // … and how far behind
    if (back > bytes.size() || count > size - bytes.size()) throw damaged();
    for (std::size_t k = 0; k < count; ++k) bytes += bytes[bytes.size() - back];  // it may overlap itself
  }
  if (bytes.size() != size) throw damaged();
  return bytes;
}

static_assert(std::endian::native == std::endian::little, "PCD files are little-endian");

/// One column of a cloud: `count` numbers a point.
struct Field {
  std::string name;
  io::Scalar scalar;
  std::size_t count = 1;
  std::size_t offset = 0;  ///< offset of its first byte in a point

  std::size_t bytes() const { return scalar.size * count; }
};

struct PcdHeader {
  std::vector<Field> fields;
  std::size_t width = 0, height = 0;
  std::optional<Pose> viewpoint;
  std::string data;       ///< ascii, binary or binary_compressed
  std::size_t begin = 0;  ///< start of the data in the file

  std::size_t points() const { return width * height; }
  std::size_t stride() const { return fields.back().offset + fields.back().bytes(); }
  const Field* find(std::string_view name) const {
    const auto found = std::ranges::find(fields, name, &Field::name);
    return found == fields.end() ? nullptr : &*found;
  }
};

std::size_t wholeNumber(std::string_view word, std::string_view key) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value > (std::size_t{1} << 31U))
    fail(ErrorCode::malformedFile, "{} is \"{}\", not a whole number", key, io::printable(word));
  return value;
}

/// Gives each field its value of a line like "SIZE 4 4 4".
template <typename Use>
void forEachField(std::vector<Field>& fields, const std::vector<std::string_view>& words, const Use& use) {
  if (words.size() != fields.size() + 1)
    fail(ErrorCode::malformedFile, "{} has {} values for {} fields", io::printable(words[0]),
         words.size() - 1, fields.size());
  for (std::size_t i = 0; i < fields.size(); ++i) use(fields[i], words[i + 1]);
}

/// Checks the header as a whole, and sets the offsets of the fields.
void finish(PcdHeader& header, bool sized, bool typed, std::optional<std::size_t> points) {
  constexpr std::size_t maxPointBytes = std::size_t{1} << 16U;
  if (header.fields.empty() || !sized || !typed)
    throw Error(ErrorCode::malformedFile, "FIELDS, SIZE or TYPE is missing");
  std::size_t offset = 0;
  for (Field& field : header.fields) {
    if (!field.scalar.exists())
      fail(ErrorCode::malformedFile, "unknown type {} of {} bytes", field.scalar.type, field.scalar.size);
    field.offset = offset;
    offset += field.bytes();
    if (field.count > maxPointBytes || offset > maxPointBytes)
      throw Error(ErrorCode::malformedFile, "a point is larger than 64 kB");
  }
  for (const char* name : {"x", "y", "z", "rgb", "rgba", "normal_x", "normal_y", "normal_z"}) {
    const auto same = [name](const Field& field) { return field.name == name; };
    if (std::ranges::count_if(header.fields, same) > 1)
      fail(ErrorCode::malformedFile, "repeated field {}", name);
    const Field* field = header.find(name);
    const bool color = *name == 'r', coordinate = name[1] == '\0';
    if (field == nullptr && coordinate) fail(ErrorCode::malformedFile, "no field {}", name);
    if (field != nullptr && (field->count != 1 || (color && field->scalar.size != 4)))
      fail(ErrorCode::malformedFile, "the field {} must be one number{} per point", name,
           color ? " of 4 bytes" : "");
  }
  if (header.width == 0 || header.height == 0) throw Error(ErrorCode::malformedFile, "no points");
  if (points && *points != header.points())
    fail(ErrorCode::malformedFile, "{} × {} does not equal POINTS {}", header.width, header.height, *points);
}

/// x y z qw qx qy qz; nothing for the origin and for values that are no pose.
std::optional<Pose> viewpointOf(const std::vector<std::string_view>& words) {
  std::array<double, 7> n;
  if (words.size() != n.size() + 1)
    fail(ErrorCode::malformedFile, "VIEWPOINT has {} values instead of {}", words.size() - 1, n.size());
  bool known = true;
  for (std::size_t i = 0; i < n.size(); ++i) {
    const auto value = io::toNumber(words[i + 1]);
    if (!value)
      fail(ErrorCode::malformedFile, "VIEWPOINT: \"{}\" is not a number", io::printable(words[i + 1]));
    n[i] = *value;
    known = known && std::abs(n[i]) <= std::numeric_limits<float>::max();
  }
  const double turn = std::hypot(std::hypot(n[3], n[4], n[5]), n[6]);
  if (!known || !(turn > 0) || n == std::array<double, 7>{0, 0, 0, 1, 0, 0, 0}) return std::nullopt;
  return Pose{n[0], n[1], n[2], n[4] / turn, n[5] / turn, n[6] / turn, n[3] / turn};
}

PcdHeader readPcdHeader(std::string_view file) {
  constexpr std::size_t maxHeaderBytes = std::size_t{1} << 16U;
  PcdHeader header;
  bool sized = false, typed = false;
  std::optional<std::size_t> points;
  for (std::size_t begin = 0; header.data.empty();) {
    const std::size_t end = file.substr(0, maxHeaderBytes).find('\n', begin);
    if (end == std::string_view::npos) throw Error(ErrorCode::malformedFile, "the header has no line DATA");
    std::string_view line = file.substr(begin, end - begin);
    begin = end + 1;
    const auto words = io::wordsOf(io::takeLine(line));
    if (words.empty() || words[0].starts_with('#')) continue;
    const std::string_view key = words[0];
    const auto only = [&] {
      if (words.size() != 2)
        fail(ErrorCode::malformedFile, "{} has {} values instead of one", key, words.size() - 1);
      return words[1];
    };
    if (key == "VERSION") {
      if (const auto version = only(); version != "0.7" && version != ".7")
        fail(ErrorCode::unsupportedFile, "version {}; save it as version 0.7 with PCL's tools",
             io::printable(version));
    } else if (key == "FIELDS") {
      if (!header.fields.empty()) throw Error(ErrorCode::malformedFile, "repeated FIELDS");
      for (std::size_t i = 1; i < words.size(); ++i) header.fields.emplace_back().name = words[i];
    } else if (key == "SIZE") {
      forEachField(header.fields, words,
                   [&](Field& f, auto word) { f.scalar.size = wholeNumber(word, key); });
      sized = true;
    } else if (key == "TYPE") {
      forEachField(header.fields, words, [&](Field& f, auto word) {
        if (word != "I" && word != "U" && word != "F")
          fail(ErrorCode::malformedFile, "unknown type {}", io::printable(word));
        f.scalar.type = word[0];
      });
      typed = true;
    } else if (key == "COUNT") {
      forEachField(header.fields, words, [&](Field& f, auto word) { f.count = wholeNumber(word, key); });
    } else if (key == "WIDTH") {
      header.width = wholeNumber(only(), key);
    } else if (key == "HEIGHT") {
      header.height = wholeNumber(only(), key);
    } else if (key == "POINTS") {
      points = wholeNumber(only(), key);
    } else if (key == "DATA") {
      header.data = only();
    } else if (key == "VIEWPOINT") {
      header.viewpoint = viewpointOf(words);
    } else {
      fail(ErrorCode::malformedFile, "unknown header line \"{}\"", io::printable(key));
    }
    header.begin = begin;
  }
  finish(header, sized, typed, points);
  return header;
}

template <typename T>
T valueAt(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

cv::Vec3b colorOf(std::uint32_t packed) {
  return {static_cast<uchar>(packed & 0xFFU), static_cast<uchar>(packed >> 8U & 0xFFU),
          static_cast<uchar>(packed >> 16U & 0xFFU)};
}

/// The fields of points, normals and colors.
struct PointFields {
  explicit PointFields(const PcdHeader& header)
      : xyz{header.find("x"), header.find("y"), header.find("z")},
        normal{header.find("normal_x"), header.find("normal_y"), header.find("normal_z")},
        color(header.find("rgb") != nullptr ? header.find("rgb") : header.find("rgba")) {}

  bool normals() const {
    return std::ranges::all_of(normal, [](const Field* field) { return field != nullptr; });
  }

  std::array<const Field*, 3> xyz, normal;
  const Field* color;
};

/// The point of three fields, whose values `number` gives.
template <typename Number>
cv::Point3f pointOf(const std::array<const Field*, 3>& fields, const Number& number) {
  return {static_cast<float>(number(*fields[0])), static_cast<float>(number(*fields[1])),
          static_cast<float>(number(*fields[2]))};
}

/// Adds a point; `number(field)` is the value of a field, `color(field)` the bits of a color.
template <typename Number, typename Color>
void add(PointCloud& cloud, const PointFields& wanted, const Number& number, const Color& color) {
  cloud.points.push_back(pointOf(wanted.xyz, number));
  if (wanted.normals()) cloud.normals.push_back(asNormal(pointOf(wanted.normal, number)));
  if (wanted.color != nullptr) cloud.colors.push_back(colorOf(color(*wanted.color)));
}

/// Fills the cloud; `at(field, i)` points to the bytes of a value.
template <typename At>
void fill(PointCloud& cloud, const PcdHeader& header, const At& at) {
  const PointFields wanted(header);
  cloud.points.reserve(header.points());
  for (std::size_t i = 0; i < header.points(); ++i)
    add(
        cloud, wanted, [&](const Field& field) { return io::numberAt(field.scalar, at(field, i)); },
        [&](const Field& field) { return valueAt<std::uint32_t>(at(field, i)); });
}

Error truncated(const PcdHeader& header, std::size_t bytes) {
  return Error(ErrorCode::truncatedFile,
               fmt::format("truncated: {} bytes for {} × {} points", bytes, header.width, header.height));
}

void readBinary(PointCloud& cloud, const PcdHeader& header, std::string_view data) {
  const std::size_t stride = header.stride();
  if (data.size() / stride < header.points()) throw truncated(header, data.size());
  fill(cloud, header,
       [&](const Field& field, std::size_t i) { return data.data() + i * stride + field.offset; });
}

/// Two sizes, then all x, all y, …, compressed by LZF.
void readCompressed(PointCloud& cloud, const PcdHeader& header, std::string_view data) {
  constexpr std::size_t sizes = 2 * sizeof(std::uint32_t);
  if (data.size() < sizes) throw truncated(header, data.size());
  const std::size_t packed = valueAt<std::uint32_t>(data.data());
  const std::size_t size = valueAt<std::uint32_t>(data.data() + sizeof(std::uint32_t));
  data.remove_prefix(sizes);
  if (packed > data.size()) throw truncated(header, data.size());
  if (size % header.stride() != 0 || size / header.stride() != header.points())
    fail(ErrorCode::corruptFile, "{} uncompressed bytes do not match {} × {} points", size, header.width,
         header.height);
  const std::string all = unpackLzf(data.substr(0, packed), size);
  fill(cloud, header, [&](const Field& field, std::size_t i) {
    return all.data() + field.offset * header.points() + i * field.bytes();
  });
}

void readAscii(PointCloud& cloud, const PcdHeader& header, std::string_view data, std::size_t firstLine) {
  std::size_t columns = 0;
  for (const Field& field : header.fields) columns += field.count;
  if (data.size() / (2 * columns) + 1 < header.points()) throw truncated(header, data.size());
  const PointFields wanted(header);
  const auto columnOf = [&](const Field& wantedField) {
    std::size_t column = 0;
    for (const Field* field = header.fields.data(); field != &wantedField; ++field) column += field->count;
    return column;
  };
  cloud.points.reserve(header.points());
  for (std::size_t line = firstLine; cloud.points.size() < header.points(); ++line) {
    if (data.empty())
      fail(ErrorCode::truncatedFile, "truncated: {} of {} points", cloud.points.size(), header.points());
    const auto words = io::wordsOf(io::takeLine(data));
    if (words.empty()) continue;
    if (words.size() != columns)
      fail(ErrorCode::malformedFile, "line {}: {} numbers instead of {}", line, words.size(), columns);
    const auto number = [&](const Field& field) {
      const std::string_view word = words[columnOf(field)];
      const auto value = io::toNumber(word);
      if (!value)
        fail(ErrorCode::malformedFile, "line {}: \"{}\" is not a number", line, io::printable(word));
      return *value;
    };
    add(cloud, wanted, number, [&](const Field& field) {  // a whole number, or the float with its bits
      const double color = number(field);
      if (field.scalar.type == 'F') return std::bit_cast<std::uint32_t>(static_cast<float>(color));
      if (!(std::abs(color) <= std::numeric_limits<std::uint32_t>::max()))
        fail(ErrorCode::malformedFile, "line {}: {} is not a color", line, color);
      return static_cast<std::uint32_t>(static_cast<std::int64_t>(color));
    });
  }
}

}  // namespace

PointCloud readPcd(const std::filesystem::path& file) {
  const std::string bytes = io::readBytes(file, std::size_t{1} << 32U);
  try {
    const PcdHeader header = readPcdHeader(bytes);
    const std::string_view data = std::string_view(bytes).substr(header.begin);
    PointCloud cloud;
    cloud.width = header.width;
    cloud.height = header.height;
    cloud.viewpoint = header.viewpoint;
    if (header.data == "binary")
      readBinary(cloud, header, data);
    else if (header.data == "binary_compressed")
      readCompressed(cloud, header, data);
    else if (header.data == "ascii")
      readAscii(cloud, header, data,
                1 + static_cast<std::size_t>(std::count(
                        bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(header.begin), '\n')));
    else
      fail(ErrorCode::unsupportedFile, "DATA is \"{}\"; known: ascii, binary, binary_compressed",
           io::printable(header.data));
    return cloud;
  } catch (const Error& error) {
    fail(error.code(), "{}: {}", io::printable(file), error.what());
  }
}

cv::Mat depthOf(const PointCloud& cloud) {
  if (!cloud.organized())
    fail(ErrorCode::invalidInput, "an unorganized cloud of {} points has no depth image; save it organized",
         cloud.points.size());
  cv::Mat depth(static_cast<int>(cloud.height), static_cast<int>(cloud.width), CV_32F);
  auto* pixels = depth.ptr<float>();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const float z = cloud.points[i].z;
    pixels[i] = std::isfinite(z) && z > 0 ? z : 0;
  }
  return depth;
}

}  // namespace estancia
