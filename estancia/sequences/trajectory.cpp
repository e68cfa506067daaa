// SPDX-License-Identifier: Apache-2.0
#include "estancia/sequences/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/sequences/listed_sequence.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t tum = 8, kitti = 12;

/// Counts lines with the same problem and keeps the first.
struct Problem {
  std::size_t count = 0, firstLine = 0;
  void add(std::size_t line) {
    if (count++ == 0) firstLine = line;
  }
};

/// The length of the quaternion of a line.
double normOf(const std::vector<double>& n) {
  return std::hypot(std::hypot(n[4], n[5]), std::hypot(n[6], n[7]));
}

std::optional<Pose> poseOfTum(const std::vector<double>& n) {
  Pose pose{n[1], n[2], n[3], n[4], n[5], n[6], n[7]};
  const double norm = normOf(n);
  if (!pose.isPlausible() || !(norm > 1e-6) || !std::isfinite(norm)) return std::nullopt;
  for (double* q : {&pose.qx, &pose.qy, &pose.qz, &pose.qw}) *q /= norm;
  return pose;
}

std::string lineOf(double timestamp, const Pose& pose) {
  return fmt::format("{} {} {} {} {} {} {} {}\n", timestamp, pose.x, pose.y, pose.z, pose.qx, pose.qy,
                     pose.qz, pose.qw);
}

}  // namespace

Trajectory readTrajectory(const fs::path& file) {
  const std::string name = io::printable(file);
  const std::vector<std::string> lines = io::readLines(file);
  Trajectory trajectory;
  Problem unusable, unordered, doubled, unnormalized;
  double latest = -std::numeric_limits<double>::infinity();
  std::size_t columns = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::string_view line = lines[i];
    const auto words = io::wordsOf(line.substr(0, line.find('#')));
    if (words.empty()) continue;
    if (columns == 0) columns = words.size() == kitti ? kitti : tum;
    std::vector<double> numbers;
    for (const auto word : words)
      if (const auto number = io::toNumber(word)) numbers.push_back(*number);
    if (words.size() != columns || numbers.size() != columns)
      fail(ErrorCode::malformedFile,
           "{}:{}: {} of {} values are numbers; write `t x y z qx qy qz qw` (TUM) or the 12 numbers of a "
           "3×4 matrix (KITTI) on every line",
           name, i + 1, numbers.size(), words.size());
    TrajectoryPoint point;
    if (columns == tum) {
      point.pose = poseOfTum(numbers);
      if (point.pose && std::abs(normOf(numbers) - 1) > 0.01) unnormalized.add(i + 1);
      if (std::isfinite(numbers[0])) {
        point.timestamp = numbers[0];
        if (numbers[0] == latest) doubled.add(i + 1);
        if (numbers[0] < latest) unordered.add(i + 1);
        latest = std::max(latest, numbers[0]);
      }
    } else {
      std::array<double, 12> matrix{};
      std::copy(numbers.begin(), numbers.end(), matrix.begin());
      point.pose = io::poseOfMatrix(matrix);
    }
    if (!point.pose || (columns == tum && !point.timestamp)) unusable.add(i + 1);
    trajectory.points.push_back(point);
  }
  if (trajectory.points.empty()) fail(ErrorCode::insufficientData, "{}: no poses", name);
  const auto warn = [&](const Problem& problem, const char* what) {
    if (problem.count > 0)
      trajectory.warnings.push_back(fmt::format("{}: {} of {} poses {} (first: line {})", name, problem.count,
                                                trajectory.points.size(), what, problem.firstLine));
  };
  warn(unusable, "are ignored: NaN, no rotation, or a position beyond 10 000 km");
  warn(unnormalized,
       "have no unit quaternion and were normalized; check that the columns are t x y z qx qy qz qw");
  warn(doubled, "repeat the previous time stamp");
  warn(unordered, "are older than the previous one; poses are sorted by time");
  return trajectory;
}

void writeTrajectory(const std::vector<TrajectoryPoint>& points, const fs::path& file) {
  std::string text = "# timestamp x y z qx qy qz qw\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [timestamp, pose] = points[i];
    if (!timestamp || !std::isfinite(*timestamp) || !pose || !pose->isPlausible())
      fail(ErrorCode::invalidInput,
           "{}: point {} lacks its time stamp or pose, which TUM files need; leave it out",
           io::printable(file), i + 1);
    text += lineOf(*timestamp, *pose);
  }
  writeWhole(file, text);
}

void writePoses(const std::vector<Frame>& frames, const fs::path& file) {
  if (std::ranges::none_of(frames, [](const Frame& f) { return f.pose.has_value(); }))
    fail(ErrorCode::insufficientData, "{}: none of the {} frames has a pose", io::printable(file),
         frames.size());
  std::vector<TrajectoryPoint> points;
  if (std::ranges::all_of(frames, [](const Frame& f) { return f.timestamp.has_value(); })) {
    for (const Frame& frame : frames)
      if (frame.pose) points.push_back({frame.timestamp, frame.pose});
    return writeTrajectory(points, file);
  }
  std::string text =
      "# frame x y z qx qy qz qw: the frames have no time stamps and are numbered; nan has no pose\n";
  for (std::size_t i = 0; i < frames.size(); ++i)
    text += frames[i].pose ? lineOf(static_cast<double>(i), *frames[i].pose)
                           : fmt::format("{} nan nan nan nan nan nan nan\n", i);
  writeWhole(file, text);
}

std::optional<Pose> io::poseOfMatrix(const std::array<double, 12>& matrix) {
  constexpr double tolerance = 0.01;
  const auto r = [&matrix](std::size_t row, std::size_t column) { return matrix[4 * row + column]; };
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = a; b < 3; ++b) {
      const double dot = r(0, a) * r(0, b) + r(1, a) * r(1, b) + r(2, a) * r(2, b);
      if (!(std::abs(dot - (a == b ? 1 : 0)) <= tolerance)) return std::nullopt;
    }
  }
  const double determinant = r(0, 0) * (r(1, 1) * r(2, 2) - r(1, 2) * r(2, 1)) -
                             r(0, 1) * (r(1, 0) * r(2, 2) - r(1, 2) * r(2, 0)) +
                             r(0, 2) * (r(1, 0) * r(2, 1) - r(1, 1) * r(2, 0));
  if (determinant < 0) return std::nullopt;
  // Shepperd 1978: divide by the largest of the four, which is never near 0.
  const double trace = r(0, 0) + r(1, 1) + r(2, 2);
  const std::array<double, 4> squares = {1 + 2 * r(0, 0) - trace, 1 + 2 * r(1, 1) - trace,
                                         1 + 2 * r(2, 2) - trace, 1 + trace};
  const auto largest = static_cast<std::size_t>(std::ranges::max_element(squares) - squares.begin());
  std::array<double, 4> q{};  // x y z w
  if (largest == 3) {
    q = {r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1), squares[3]};
  } else {
    const std::size_t i = largest, j = (i + 1) % 3, k = (i + 2) % 3;
    q[i] = squares[i];
    q[j] = r(j, i) + r(i, j);
    q[k] = r(k, i) + r(i, k);
    q[3] = r(k, j) - r(j, k);
  }
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const Pose pose{matrix[3], matrix[7], matrix[11], q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
  return pose.isPlausible() ? std::optional(pose) : std::nullopt;
}

}  // namespace estancia
