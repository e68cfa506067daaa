// SPDX-License-Identifier: Apache-2.0
#include "recognition/filtered_clouds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <system_error>
#include <tuple>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/files.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr const char* magic = "ESTANCIA FILTERED CLOUD 2\n";
constexpr std::size_t digestBytes = 64, maxFileBytes = std::size_t{1} << 32;
constexpr const char* ending = ".cloud";

std::vector<float> coordinatesOf(const std::vector<cv::Point3f>& points) {
  std::vector<float> coordinates;
  for (const cv::Point3f& p : points) coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
  return coordinates;
}

std::vector<cv::Point3f> pointsOf(const std::vector<float>& coordinates) {
  std::vector<cv::Point3f> points;
  for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3)
    points.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
  return points;
}

std::vector<std::uint8_t> levelsOf(const std::vector<cv::Vec3b>& colors) {
  std::vector<std::uint8_t> levels;
  for (const cv::Vec3b& c : colors) levels.insert(levels.end(), {c[0], c[1], c[2]});
  return levels;
}

std::vector<cv::Vec3b> colorsOf(const std::vector<std::uint8_t>& levels) {
  std::vector<cv::Vec3b> colors;
  for (std::size_t i = 0; i + 2 < levels.size(); i += 3)
    colors.emplace_back(levels[i], levels[i + 1], levels[i + 2]);
  return colors;
}

std::string toBytes(const FilteredClouds::Filtered& filtered, const std::string& key) {
  ByteWriter writer;
  writer.text(key);
  writer.number(filtered.seconds);
  writer.numbers(coordinatesOf(filtered.cloud.points));
  writer.numbers(coordinatesOf(filtered.cloud.normals));
  writer.numbers(levelsOf(filtered.cloud.colors));
  return magic + sha256(writer.bytes()) + writer.bytes();
}

std::optional<FilteredClouds::Filtered> fromFile(const fs::path& file, const std::string& key) {
  try {
    if (!fs::is_regular_file(file)) return std::nullopt;
    const std::string bytes = io::readBytes(file, maxFileBytes);
    const std::string_view all = bytes, start = magic;
    if (!all.starts_with(start) || all.size() < start.size() + digestBytes) return std::nullopt;
    const std::string_view payload = all.substr(start.size() + digestBytes);
    if (all.substr(start.size(), digestBytes) != sha256(payload)) return std::nullopt;
    ByteReader reader(payload, file.string(), "remove it");
    if (reader.text() != key) return std::nullopt;
    FilteredClouds::Filtered filtered;
    filtered.seconds = reader.number<double>();
    filtered.cloud.points = pointsOf(reader.numbers<float>());
    filtered.cloud.normals = pointsOf(reader.numbers<float>());
    filtered.cloud.colors = colorsOf(reader.numbers<std::uint8_t>());
    filtered.cloud.width = filtered.cloud.points.size();
    filtered.cloud.height = 1;
    return filtered;
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

FilteredClouds::FilteredClouds(fs::path folder, std::uint64_t maxBytes)
    : folder_(std::move(folder)), maxBytes_(maxBytes) {}

std::string FilteredClouds::describe(const FilterOptions& filter) {
  if (filter.method == "none") return filter.method;
  std::string text = fmt::format("{} {} {}", filter.method, filter.points, filter.leaf);
  if (filter.method == "gng") {
    const GngOptions& g = filter.gng;
    text += fmt::format(" {} {} {} {} {} {} {} {} {} {}", g.signalsPerInsertion, g.winnerRate, g.neighborRate,
                        g.insertionDecay, g.errorDecay, g.maxAge, g.colorWeight, g.seed, g.quantizationError,
                        g.seconds);
  }
  return text;
}

FilteredClouds::Filtered FilteredClouds::get(const std::string& origin, const FilterOptions& filter,
                                             const std::function<PointCloud()>& source) const {
  if (filter.method == "none") return {source(), 0};
  const std::string key = origin + "\n" + describe(filter);
  const fs::path file = folder_ / (sha256(key).substr(0, 32) + ending);
  if (auto kept = fromFile(file, key)) return std::move(*kept);
  const PointCloud cloud = source();
  Progress silent;
  const auto start = std::chrono::steady_clock::now();
  Filtered filtered{filterCloud(cloud, filter, silent), 0};
  filtered.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (maxBytes_ == 0) return filtered;
  std::error_code problem;
  fs::create_directories(folder_, problem);
  if (problem)
    throw Error(ErrorCode::fileUnwritable,
                fmt::format("{}: the folder cannot be made ({})", folder_.string(), problem.message()));
  writeWhole(file, toBytes(filtered, key));
  makeRoom();
  return filtered;
}

void FilteredClouds::makeRoom() const {
  std::vector<std::tuple<fs::file_time_type, fs::path, std::uint64_t>> files;
  std::uint64_t bytes = 0;
  std::error_code gone;  // another process may be making room, too
  for (fs::directory_iterator it(folder_, gone), end; it != end; it.increment(gone)) {
    if (it->path().extension() != ending) continue;
    const std::uint64_t size = it->file_size(gone);
    if (gone) continue;
    files.emplace_back(it->last_write_time(gone), it->path(), size);
    bytes += size;
  }
  if (bytes <= maxBytes_) return;
  std::sort(files.begin(), files.end());
  for (const auto& [time, file, size] : files) {
    if (bytes <= maxBytes_) return;
    fs::remove(file, gone);
    bytes -= size;
  }
}

}  // namespace estancia::experiments
