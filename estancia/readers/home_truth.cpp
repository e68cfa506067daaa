// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/home_truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/readers/open_sequence.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

constexpr double maxMeters = 1e4;
constexpr double maxPixelCount = 1 << 26;  // images are not larger
constexpr std::size_t maxRows = 10'000'000;

/// A CSV file with a header, whose cells are asked for by the name of their column.
class HomeTable {
 public:
  explicit HomeTable(const fs::path& file) : file_(printable(file)), rows_(readCsv(file)) {
    if (rows_.empty())
      fail(ErrorCode::malformedFile, "{}: empty; write a line with the columns' names", file_);
    if (rows_.size() > maxRows)
      fail(ErrorCode::tooLarge, "{}: {} lines; at most {} are read", file_, rows_.size(), maxRows);
  }

  std::size_t size() const { return rows_.size() - 1; }

  [[noreturn]] void refuse(std::size_t row, std::string_view why) const {
    fail(ErrorCode::malformedFile, "{}:{}: {}", file_, rows_[row + 1].line, why);
  }

  /// Nothing when there is no such column.
  std::optional<std::string> findText(std::size_t row, const char* column) const {
    const auto at = findColumn(rows_.front().cells, column);
    if (!at) return std::nullopt;
    const auto& cells = rows_[row + 1].cells;
    if (cells.size() != rows_.front().cells.size())
      refuse(row, fmt::format("{} cells; the first line names {} columns", cells.size(),
                              rows_.front().cells.size()));
    return printable(cells[*at]);
  }

  std::string text(std::size_t row, const char* column) const {
    const auto found = findText(row, column);
    if (!found) fail(ErrorCode::malformedFile, "{}:1: no column \"{}\"; add it", file_, column);
    return *found;
  }

  double number(std::size_t row, const char* column, double least, double most) const {
    const std::string cell = text(row, column);
    const auto value = toNumber(cell);
    if (!value || !(*value >= least && *value <= most))  // NaN, too
      refuse(row, fmt::format("{} is \"{}\"; give a number from {} to {}", column, cell, least, most));
    return *value;
  }

  int count(std::size_t row, const char* column, double least, double most) const {
    const double value = number(row, column, least, most);
    if (value != std::floor(value)) refuse(row, fmt::format("{} is {}; give a whole number", column, value));
    return static_cast<int>(value);
  }

 private:
  std::string file_;
  std::vector<CsvRow> rows_;
};

HomeInstance instanceOf(const HomeTable& table, std::size_t row) {
  const auto meters = [&](const char* column) { return table.number(row, column, -maxMeters, maxMeters); };
  const auto length = [&](const char* column) { return table.number(row, column, 0, maxMeters); };
  return {table.count(row, "id", firstInstance, std::numeric_limits<std::uint16_t>::max()),
          table.text(row, "category"),
          table.text(row, "model"),
          table.text(row, "model_name"),
          table.text(row, "room"),
          {meters("x"), meters("y"), meters("z")},
          {length("size_x"), length("size_y"), length("size_z")},
          table.number(row, "yaw_degrees", -3600, 3600) * std::numbers::pi / 180,
          table.findText(row, "movable_name").value_or("")};
}

/// Spreads at most about 5,000 samples over an image: the step between them [pixels].
int sampleStep(const cv::Mat& image) {
  constexpr double samples = 5000;
  return std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(image.total()) / samples))));
}

/// Where a polygon is right on a wall, a surface that is seen is on the near side of it.
constexpr double nearSide = 0.01;  // [m]

/// The room that a frame sees by its depth; nothing when it lacks depth, camera or pose.
std::optional<std::size_t> roomSeenByDepth(const HomePlan& plan, const Sequence& sequence, std::size_t i) {
  const auto& pose = sequence.frame(i).pose;
  const auto& camera = sequence.intrinsics();
  if (!sequence.hasDepth() || !camera || !pose) return std::nullopt;
  try {
    return roomSeen(plan, sequence.depth(i), *camera, *pose);
  } catch (...) {
    frameFailure(sequence.frame(i).name);
    return std::nullopt;
  }
}

}  // namespace

std::vector<HomeInstance> readHomeInstances(const fs::path& file) {
  const HomeTable table(file);
  std::vector<HomeInstance> instances;
  std::set<int> ids;
  for (std::size_t row = 0; row < table.size(); ++row) {
    instances.push_back(instanceOf(table, row));
    if (!ids.insert(instances.back().id).second)
      table.refuse(row, fmt::format("the id {} stands in a line above, too; give each instance its own",
                                    instances.back().id));
  }
  return instances;
}

VisibleByImage readVisibleInstances(const fs::path& file, const std::vector<HomeInstance>& instances) {
  const HomeTable table(file);
  std::set<int> known;
  for (const HomeInstance& instance : instances) known.insert(instance.id);
  VisibleByImage visible;
  std::set<std::pair<std::string, int>> seen;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const std::string image = table.text(row, "image");
    VisibleInstance instance;
    instance.id = table.count(row, "id", firstInstance, std::numeric_limits<std::uint16_t>::max());
    instance.pixels = table.count(row, "pixels", 0, maxPixelCount);
    instance.pixelsWithDepth = table.count(row, "pixels_with_depth", 0, instance.pixels);
    if (!known.contains(instance.id))
      table.refuse(row,
                   fmt::format("no instance has the id {}; give the instances of this drive", instance.id));
    if (!seen.emplace(image, instance.id).second)
      table.refuse(
          row, fmt::format("{} stands in a line above with {}, too; keep one of them", instance.id, image));
    visible[image].push_back(instance);
  }
  return visible;
}

cv::Mat readInstanceMask(const fs::path& file) {
  cv::Mat mask = decodeImage(file);
  if (mask.type() != CV_16UC1)
    fail(ErrorCode::unsupportedFile, "{}: not an instance mask; give an image of one channel with 16 bits",
         printable(file));
  return mask;
}

fs::path instanceMaskFile(const fs::path& folder, const Frame& frame) {
  return folder / "instance" / fs::path(frame.name).filename().replace_extension(".png");
}

bool hasHomeTruth(const fs::path& folder) {
  std::error_code unreadable;
  return fs::is_regular_file(folder / "home.json", unreadable);
}

HomeTruth readHomeTruth(const fs::path& folder) {
  HomeTruth truth;
  truth.plan = readHomePlan(folder / "home.json");
  if (fs::exists(folder / "instances.csv")) truth.instances = readHomeInstances(folder / "instances.csv");
  if (fs::exists(folder / "visible.csv"))
    truth.visible = readVisibleInstances(folder / "visible.csv", truth.instances);
  return truth;
}

std::optional<std::size_t> roomSeen(const HomePlan& plan, const cv::Mat& depth,
                                    const CameraIntrinsics& camera, const Pose& pose) {
  if (depth.empty() || depth.type() != CV_32FC1)
    fail(ErrorCode::invalidInput, "a depth image must be CV_32F with one channel, not empty");
  const CameraIntrinsics own =
      camera.width > 0 && camera.height > 0 ? camera.scaledTo(depth.cols, depth.rows) : camera;
  const cv::Affine3d toMap = rigidOf(pose);
  const int step = sampleStep(depth);
  std::vector<std::size_t> votes(plan.rooms.size(), 0);
  for (int v = step / 2; v < depth.rows; v += step)
    for (int u = step / 2; u < depth.cols; u += step) {
      const double z = depth.at<float>(v, u) - nearSide;
      if (!(z > 0 && z < maxMeters)) continue;
      const cv::Vec3d point = toMap * cv::Vec3d(own.slopeX(u) * z, own.slopeY(v) * z, z);
      if (const auto room = roomAt(plan, point[0], point[1])) ++votes[*room];
    }
  const auto most = std::ranges::max_element(votes);
  if (most == votes.end() || *most == 0) return std::nullopt;
  return static_cast<std::size_t>(most - votes.begin());
}

std::string roomSeen(const std::vector<VisibleInstance>& visible,
                     const std::vector<HomeInstance>& instances) {
  std::unordered_map<int, std::string_view> roomOf;
  for (const HomeInstance& instance : instances) roomOf.emplace(instance.id, instance.room);
  std::map<std::string_view, long> pixels;
  for (const VisibleInstance& seen : visible)
    if (const auto room = roomOf.find(seen.id); room != roomOf.end() && !room->second.empty())
      pixels[room->second] += seen.pixels;
  const auto most = std::ranges::max_element(pixels, {}, [](const auto& room) { return room.second; });
  return most == pixels.end() || most->second == 0 ? "" : std::string(most->first);
}

std::vector<std::string> roomsSeen(const HomeTruth& truth, const Sequence& sequence) {
  std::vector<std::string> rooms(sequence.size());
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    if (const auto room = roomSeenByDepth(truth.plan, sequence, i)) {
      rooms[i] = truth.plan.rooms[*room].name;
      continue;
    }
    const auto seen = truth.visible.find(fs::path(sequence.frame(i).name).filename().string());
    if (seen != truth.visible.end()) rooms[i] = roomSeen(seen->second, truth.instances);
  }
  return rooms;
}

std::vector<std::size_t> framesOfImages(const Sequence& drive, const fs::path& folder,
                                        const std::vector<std::string>& images) {
  std::unordered_map<std::string, std::size_t> byName;
  for (std::size_t i = 0; i < drive.size(); ++i) byName.emplace(fs::path(drive.frame(i).name).filename(), i);
  std::vector<std::size_t> frames;
  std::set<std::string> names;
  for (const std::string& image : images) {
    const std::string name = fs::path(image).filename();
    const auto frame = byName.find(name);
    if (frame == byName.end() || !names.insert(name).second)
      fail(ErrorCode::mismatch, "{}: {} the image {}; give the folder of the one drive that was taken",
           printable(folder), frame == byName.end() ? "has not" : "has only once", printable(image));
    frames.push_back(frame->second);
  }
  return frames;
}

std::vector<std::string> roomsSeen(const fs::path& folder, const std::vector<std::string>& images) {
  const HomeTruth truth = readHomeTruth(folder);
  const auto sequence = openSequence(folder);
  const std::vector<std::size_t> frames = framesOfImages(*sequence, folder, images);
  const std::vector<std::string> rooms = roomsSeen(truth, *sequence);
  std::vector<std::string> found;
  for (const std::size_t frame : frames) found.push_back(rooms[frame]);
  return found;
}

}  // namespace estancia::io
