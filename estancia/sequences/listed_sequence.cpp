// SPDX-License-Identifier: Apache-2.0
#include "estancia/sequences/listed_sequence.hpp"

#include <fmt/format.h>

#include <cmath>
#include <unordered_map>

#include "estancia/core/ascii.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/image_file.hpp"

namespace estancia {
namespace fs = std::filesystem;

cv::Mat Sequence::depth(std::size_t i) const {
  fail(ErrorCode::insufficientData, "{}: {} has no depth image", name(), frame(i).name);
}

bool hasPoses(const Sequence& sequence) {
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (sequence.frame(i).pose) return true;
  return false;
}

namespace io {
namespace {

/// Points with a time stamp, by it. Points without a pose stay: their frames must not take a neighbor's.
std::vector<TrajectoryPoint> sortedByTime(const Trajectory& trajectory) {
  std::vector<TrajectoryPoint> points;
  for (const auto& point : trajectory.points)
    if (point.timestamp) points.push_back(point);
  std::ranges::stable_sort(points, {}, [](const TrajectoryPoint& p) { return *p.timestamp; });
  return points;
}

/// Null when no point (there is one at least) is within `maxGap` of `time`.
const TrajectoryPoint* nearest(const std::vector<TrajectoryPoint>& points, double time, double maxGap) {
  const auto best = nearestInTime(points, time, [](const TrajectoryPoint& p) { return *p.timestamp; });
  return std::abs(*best->timestamp - time) <= maxGap ? &*best : nullptr;
}

constexpr std::size_t ambiguous = static_cast<std::size_t>(-1);

std::string lastComponent(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

}  // namespace

void attachPoses(ListedSequence& sequence, const Trajectory& trajectory, const fs::path& file,
                 double maxGap) {
  const std::string name = printable(file);
  for (const auto& warning : trajectory.warnings) sequence.warn(warning);
  auto& frames = sequence.frames();
  const std::vector<TrajectoryPoint> points = sortedByTime(trajectory);
  const bool timed =
      !points.empty() && std::ranges::all_of(frames, [](const Frame& f) { return f.timestamp.has_value(); });

  std::vector<const TrajectoryPoint*> matches(frames.size(), nullptr);
  if (timed)
    for (std::size_t i = 0; i < frames.size(); ++i)
      matches[i] = nearest(points, *frames[i].timestamp, maxGap);
  PoseSource source;
  std::size_t unmatched = static_cast<std::size_t>(std::ranges::count(matches, nullptr));
  if (unmatched == frames.size()) {
    if (trajectory.points.size() != frames.size())
      fail(ErrorCode::mismatch,
           "{}: {} poses match the {} frames of {} neither by time (at most {} s apart) nor by number; "
           "give the trajectory of these frames",
           name, trajectory.points.size(), frames.size(), sequence.name(), maxGap);
    if (timed) {
      sequence.warn(fmt::format("{}: no time stamp matches a frame; poses are matched by order", name));
      source.otherClock = {*points.front().timestamp, *points.back().timestamp};
    }
    for (std::size_t i = 0; i < frames.size(); ++i) matches[i] = &trajectory.points[i];
    unmatched = 0;
  }
  sequence.setPoseSource(source);
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].pose = matches[i] ? matches[i]->pose : std::nullopt;
  if (unmatched > 0)
    sequence.warn(
        fmt::format("{}: {} of {} frames have no pose within {} s", name, unmatched, frames.size(), maxGap));
}

void attachRooms(ListedSequence& sequence, const fs::path& file) {
  const std::string name = printable(file);
  auto& frames = sequence.frames();
  std::unordered_map<std::string, std::size_t> byName, byLastComponent;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    byName.emplace(frames[i].name, i);
    const auto [entry, isNew] = byLastComponent.emplace(lastComponent(frames[i].name), i);
    if (!isNew) entry->second = ambiguous;
  }
  const auto find = [&](const std::string& image) {
    if (const auto exact = byName.find(image); exact != byName.end()) return exact->second;
    const auto last = byLastComponent.find(lastComponent(image));
    return last == byLastComponent.end() ? ambiguous : last->second;
  };
  struct Place {
    std::string room, split;
  };
  std::unordered_map<std::size_t, Place> places;
  std::size_t unknown = 0, rowCount = 0;
  std::string firstUnknown;
  const auto rows = readCsv(file);
  const bool splits = !rows.empty() && rows.front().cells.size() == 3;
  for (const CsvRow& row : rows) {
    if (row.cells.size() != (splits ? 3 : 2))
      fail(ErrorCode::malformedFile,
           "{}:{}: {} cells; write `image,room` or `image,room,split` on every line", name, row.line,
           row.cells.size());
    const std::string image = printable(row.cells[0]), room = printable(row.cells[1]),
                      split = splits ? printable(row.cells[2]) : "";
    const std::size_t found = find(image);
    if (found == ambiguous) {
      if (&row == &rows.front() && lowerCase(room) == "room" && (!splits || lowerCase(split) == "split"))
        continue;  // the header
      if (unknown++ == 0) firstUnknown = image;
    } else {
      const auto [entry, isNew] = places.emplace(found, Place{room, split});
      const Place& above = entry->second;
      for (const auto& [own, other] : {std::pair{room, above.room}, {split, above.split}})
        if (own != other)
          fail(ErrorCode::malformedFile,
               "{}:{}: {} is in \"{}\", and in \"{}\" in a line above; keep one of them", name, row.line,
               image, own, other);
    }
    ++rowCount;
  }
  if (rowCount == 0)
    fail(ErrorCode::insufficientData,
         "{}: no images; write one line `image,room` per image with a known room", name);
  if (splits) sequence.splits().resize(frames.size());
  for (const auto& [i, place] : places) {
    frames[i].room = place.room;
    if (splits) sequence.splits()[i] = place.split;
  }
  if (unknown > 0)
    sequence.warn(fmt::format("{}: {} of {} lines name missing images (first: {})", name, unknown, rowCount,
                              firstUnknown));
}

/// Digits, a point, three digits or more.
std::optional<double> timestampOf(const fs::path& file) {
  const std::string stem = file.stem().string();
  const auto point = stem.find('.');
  const bool plain = stem.find_first_not_of("0123456789.") == std::string::npos;
  if (!plain || point == 0 || point == std::string::npos || stem.size() - point < 4) return std::nullopt;
  return toNumber(stem);
}

void ImageFiles::add(Frame frame, fs::path file, DepthFile depth) {
  entries_.push_back(std::move(frame));
  files_.push_back(std::move(file));
  hasDepth_ = hasDepth_ || !depth.file.empty();
  depths_.push_back(std::move(depth));
}

cv::Mat ImageFiles::image(std::size_t i) const {
  return readImage(files_.at(i));
}

cv::Mat ImageFiles::reducedImage(std::size_t i, int side) const {
  return readReducedImage(files_.at(i), side);
}

std::string ImageFiles::fingerprint(std::size_t i) const {
  return sha256OfFile(files_.at(i));
}

cv::Mat ImageFiles::depth(std::size_t i) const {
  const fs::path& file = depths_.at(i).file;
  if (file.empty())
    fail(ErrorCode::insufficientData, "{}: {} has no depth image; leave it out or add its depth", name_,
         frame(i).name);
  return readDepth(file, depthScale_);
}

std::string nameOf(const fs::path& path) {
  const fs::path whole = fs::absolute(path).lexically_normal();
  return printable((whole.has_filename() ? whole : whole.parent_path()).filename().string());
}

}  // namespace io
}  // namespace estancia
