// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/ply.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/scalar.hpp"

namespace estancia {
namespace {

/// A number of an element, or a list of them with a count before it.
struct Property {
  std::string name;
  io::Scalar scalar;
  /// Type of the length of a list.
  std::optional<io::Scalar> count;

  std::size_t minBytes() const { return count ? count->size : scalar.size; }
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

enum class Format { ascii, little, big };

struct PlyHeader {
  std::optional<Format> format;
  std::vector<Element> elements;
  std::size_t lines = 0;
};

/// The unread rest of the file.
struct Rest {
  std::string_view bytes;
  std::size_t line = 1;

  std::string_view takeLine() {
    if (bytes.empty()) throw Error(ErrorCode::truncatedFile, "truncated");
    ++line;
    return io::takeLine(bytes);
  }
  const char* take(std::size_t count) {
    if (count > bytes.size()) throw Error(ErrorCode::truncatedFile, "truncated");
    const char* taken = bytes.data();
    bytes.remove_prefix(count);
    return taken;
  }
};

io::Scalar scalarCalled(std::string_view name) {
  struct Type {
    std::string_view old, other;
    io::Scalar scalar;
  };
  static constexpr Type types[] = {{"char", "int8", {'I', 1}},     {"uchar", "uint8", {'U', 1}},
                                   {"short", "int16", {'I', 2}},   {"ushort", "uint16", {'U', 2}},
                                   {"int", "int32", {'I', 4}},     {"uint", "uint32", {'U', 4}},
                                   {"float", "float32", {'F', 4}}, {"double", "float64", {'F', 8}}};
  for (const Type& type : types)
    if (name == type.old || name == type.other) return type.scalar;
  fail(ErrorCode::malformedFile, "unknown type \"{}\"", io::printable(name));
}

Property propertyOf(const std::vector<std::string_view>& words) {
  if (words.size() == 5 && words[1] == "list") {
    const io::Scalar count = scalarCalled(words[2]);
    if (count.type == 'F') fail(ErrorCode::malformedFile, "a list is counted in {}", io::printable(words[2]));
    return {std::string(words[4]), scalarCalled(words[3]), count};
  }
  if (words.size() != 3)
    throw Error(ErrorCode::malformedFile, "a line \"property\" is not TYPE NAME or list TYPE TYPE NAME");
  return {std::string(words[2]), scalarCalled(words[1]), std::nullopt};
}

std::size_t countOf(std::string_view word) {
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (error != std::errc() || end != word.data() + word.size())
    fail(ErrorCode::malformedFile, "\"{}\" is not a number of elements", io::printable(word));
  return count;
}

PlyHeader readPlyHeader(Rest& rest) {
  constexpr std::size_t maxHeaderBytes = std::size_t{1} << 16U;
  const std::size_t all = rest.bytes.size();
  if (!rest.bytes.starts_with("ply") || rest.takeLine() != "ply")
    throw Error(ErrorCode::malformedFile, "the first line is not \"ply\"");
  PlyHeader header;
  for (;;) {
    if (rest.bytes.empty() || all - rest.bytes.size() > maxHeaderBytes)
      throw Error(ErrorCode::malformedFile, "the header has no line \"end_header\"");
    const auto words = io::wordsOf(rest.takeLine());
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() == 3) {
      static constexpr std::string_view names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
      const auto* const known = std::ranges::find(names, words[1]);
      if (known == std::end(names) || words[2] != "1.0")
        fail(ErrorCode::unsupportedFile,
             "format \"{} {}\"; known: ascii, binary_little_endian, binary_big_endian 1.0",
             io::printable(words[1]), io::printable(words[2]));
      header.format = static_cast<Format>(known - std::begin(names));
    } else if (words[0] == "element" && words.size() == 3) {
      header.elements.push_back({std::string(words[1]), countOf(words[2]), {}});
    } else if (words[0] == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(propertyOf(words));
    } else {
      fail(ErrorCode::malformedFile, "line {}: unknown header line \"{} …\"", rest.line - 1,
           io::printable(words[0].substr(0, 40)));
    }
  }
  if (!header.format) throw Error(ErrorCode::malformedFile, "the header has no line \"format\"");
  return header;
}

/// Calls use(property, value) for each number of an element, those of its lists one by one.
template <typename Use>
void readBinary(Rest& rest, const Element& element, bool swapped, const Use& use) {
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const Property& property = element.properties[p];
    if (!property.count) {
      use(p, io::numberAt(property.scalar, rest.take(property.scalar.size), swapped));
      continue;
    }
    const double count = io::numberAt(*property.count, rest.take(property.count->size), swapped);
    if (count < 0)
      fail(ErrorCode::malformedFile, "list {} of {} numbers", io::printable(property.name), count);
    const std::size_t size = property.scalar.size;
    const char* numbers = rest.take(static_cast<std::size_t>(count) * size);
    for (const char* end = rest.bytes.data(); numbers != end; numbers += size)
      use(p, io::numberAt(property.scalar, numbers, swapped));
  }
}

template <typename Use>
void readAscii(Rest& rest, const Element& element, const Use& use) {
  const std::size_t line = rest.line;
  const auto words = io::wordsOf(rest.takeLine());
  std::size_t next = 0;
  const auto number = [&] {
    if (next == words.size())
      fail(ErrorCode::malformedFile, "line {}: {} numbers, too few for a {}", line, words.size(),
           io::printable(element.name));
    const auto value = io::toNumber(words[next]);
    if (!value)
      fail(ErrorCode::malformedFile, "line {}: \"{}\" is not a number", line, io::printable(words[next]));
    ++next;
    return *value;
  };
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    if (!element.properties[p].count) {
      use(p, number());
      continue;
    }
    const double count = number();
    if (!(count >= 0) || count > static_cast<double>(words.size() - next))
      fail(ErrorCode::malformedFile, "line {}: list of {} numbers with {}", line, count, words.size() - next);
    for (double i = 0; i < count; ++i) use(p, number());
  }
  if (next != words.size())
    fail(ErrorCode::malformedFile, "line {}: {} numbers, too many for a {}", line, words.size(),
         io::printable(element.name));
}

/// Throws when the file is too short for the element.
void requireBytes(const Element& element, Format format, std::size_t bytes) {
  std::size_t min = 0;  // per element; a number as text has a separator, except the last one
  for (const Property& property : element.properties)
    min += format == Format::ascii ? 2 : property.minBytes();
  if (min > 0 && element.count > (bytes + 1) / min)
    fail(ErrorCode::truncatedFile, "truncated: {} bytes for {} × {}", bytes, element.count,
         io::printable(element.name));
}

/// Indices of the point, normal and color among the properties of a vertex.
struct VertexFields {
  explicit VertexFields(const Element& vertex) {
    static constexpr std::string_view names[] = {"x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"};
    for (std::size_t n = 0; n < std::size(names); ++n)
      for (std::size_t p = 0; p < vertex.properties.size(); ++p) {
        if (vertex.properties[p].name != names[n]) continue;
        if (at[n]) fail(ErrorCode::malformedFile, "repeated property {} of a vertex", names[n]);
        if (vertex.properties[p].count) fail(ErrorCode::malformedFile, "the property {} is a list", names[n]);
        at[n] = p;
      }
    if (!at[0] || !at[1] || !at[2]) throw Error(ErrorCode::malformedFile, "a vertex has no x, y and z");
    normals = at[3] && at[4] && at[5];
    colors = at[6] && at[7] && at[8];
  }
  std::array<std::optional<std::size_t>, 9> at;
  bool normals = false, colors = false;
};

/// A color channel scaled to 0 … 255.
uchar byteOf(const io::Scalar& scalar, double value) {
  const double scale = scalar.type == 'F' ? 255 : scalar.size == 2 ? 255.0 / 65535 : 1;
  const double byte = std::round(value * scale);
  return byte > 0 ? static_cast<uchar>(std::min(byte, 255.0)) : uchar{0};  // NaN is 0
}

template <typename ReadOne>
PointCloud readVertices(const Element& vertex, const ReadOne& readOne) {
  if (vertex.count == 0) throw Error(ErrorCode::malformedFile, "no points");
  const VertexFields fields(vertex);
  PointCloud cloud;
  cloud.width = vertex.count;
  cloud.height = 1;
  cloud.points.reserve(vertex.count);
  std::vector<double> values(vertex.properties.size());
  const auto triple = [&](std::size_t first) {
    const auto value = [&](std::size_t n) { return static_cast<float>(values[*fields.at[n]]); };
    return cv::Point3f(value(first), value(first + 1), value(first + 2));
  };
  const auto byte = [&](std::size_t n) {
    const std::size_t p = *fields.at[n];
    return byteOf(vertex.properties[p].scalar, values[p]);
  };
  for (std::size_t i = 0; i < vertex.count; ++i) {
    readOne([&](std::size_t property, double value) { values[property] = value; });
    cloud.points.push_back(triple(0));
    if (fields.normals) cloud.normals.push_back(asNormal(triple(3)));
    if (fields.colors) cloud.colors.emplace_back(byte(8), byte(7), byte(6));
  }
  return cloud;
}

/// Polygons as fans around their first corner.
template <typename ReadOne>
void readFaces(const Element& face, std::size_t vertices, const ReadOne& readOne,
               std::vector<PlyMesh::Triangle>& triangles) {
  const auto isIndices = [](const Property& p) {
    return p.count && (p.name == "vertex_indices" || p.name == "vertex_index");
  };
  const auto list = std::ranges::find_if(face.properties, isIndices);
  if (list == face.properties.end())
    throw Error(ErrorCode::malformedFile, "a face has no list vertex_indices");
  const auto indices = static_cast<std::size_t>(list - face.properties.begin());
  std::vector<std::uint32_t> corners;
  for (std::size_t i = 0; i < face.count; ++i) {
    corners.clear();
    readOne([&](std::size_t property, double value) {
      if (property != indices) return;
      if (!(value >= 0 && value < static_cast<double>(vertices)))
        fail(ErrorCode::malformedFile, "face {}: there is no vertex {} before it", i, value);
      corners.push_back(static_cast<std::uint32_t>(value));
    });
    for (std::size_t k = 2; k < corners.size(); ++k)
      triangles.push_back({corners[0], corners[k - 1], corners[k]});
  }
}

/// Faces are left out without `triangles`.
PointCloud read(std::string_view bytes, std::vector<PlyMesh::Triangle>* triangles) {
  Rest rest{bytes};
  const PlyHeader header = readPlyHeader(rest);
  const bool swapped = header.format == Format::big;
  std::optional<PointCloud> cloud;
  for (const Element& element : header.elements) {
    requireBytes(element, *header.format, rest.bytes.size());
    const auto readOne = [&](const auto& use) {
      if (header.format == Format::ascii)
        readAscii(rest, element, use);
      else
        readBinary(rest, element, swapped, use);
    };
    if (element.name == "vertex") {
      if (cloud) throw Error(ErrorCode::malformedFile, "repeated element vertex");
      cloud = readVertices(element, readOne);
    } else if (element.name == "face" && triangles != nullptr) {
      readFaces(element, cloud ? cloud->points.size() : 0, readOne, *triangles);
    } else if (!element.properties.empty()) {
      for (std::size_t i = 0; i < element.count; ++i) readOne([](std::size_t, double) {});
    }
  }
  if (!cloud) throw Error(ErrorCode::malformedFile, "no element vertex");
  return *std::move(cloud);
}

PointCloud readPlyFile(const std::filesystem::path& file, std::vector<PlyMesh::Triangle>* triangles) {
  const std::string bytes = io::readBytes(file, std::size_t{1} << 32U);
  try {
    return read(bytes, triangles);
  } catch (const Error& error) {
    fail(error.code(), "{}: {}", io::printable(file), error.what());
  }
}

}  // namespace

PointCloud readPly(const std::filesystem::path& file) {
  return readPlyFile(file, nullptr);
}

PlyMesh readPlyMesh(const std::filesystem::path& file) {
  PlyMesh mesh;
  mesh.vertices = readPlyFile(file, &mesh.triangles);
  return mesh;
}

}  // namespace estancia
