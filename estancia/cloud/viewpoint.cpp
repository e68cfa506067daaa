// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/viewpoint.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"

namespace estancia {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t drawnPoints = 8000;  // points by which the sensor's position is found

/// Directions that are spread evenly over the sphere (Fibonacci's lattice).
std::vector<cv::Vec3d> directions(std::size_t count) {
  std::vector<cv::Vec3d> all(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double turn = static_cast<double>(i) * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    all[i] = {r * std::cos(turn), r * std::sin(turn), z};
  }
  return all;
}

cv::Vec3d meanOf(std::span<const cv::Point3f> points) {
  cv::Vec3d sum;
  for (const cv::Point3f& p : points) sum += cv::Vec3d(p.x, p.y, p.z);
  return sum * (1 / static_cast<double>(points.size()));
}

/// Distance from `center` within which most points lie [m].
double radiusOf(std::span<const cv::Point3f> points, const cv::Vec3d& center) {
  constexpr double most = 0.9;
  std::vector<double> away;
  for (const cv::Point3f& p : points) away.push_back(cv::norm(cv::Vec3d(p.x, p.y, p.z) - center));
  const auto at = away.begin() + static_cast<std::ptrdiff_t>(most * static_cast<double>(away.size() - 1));
  std::nth_element(away.begin(), at, away.end());
  return *at;
}

/// Rows: right, down, forward, of a camera with that forward direction.
cv::Matx33d cameraLooking(const cv::Vec3d& forward) {
  const cv::Vec3d aside = std::abs(forward[1]) < 0.9 ? cv::Vec3d(0, 1, 0) : cv::Vec3d(1, 0, 0);
  const cv::Vec3d right = cv::normalize(aside.cross(forward)), down = forward.cross(right);
  return {right[0], right[1], right[2], down[0], down[1], down[2], forward[0], forward[1], forward[2]};
}

/// Numbers of values in equal cells of a rectangle.
struct Cells {
  int columns = 0, rows = 0;
  std::vector<float> values;
  float& at(int column, int row) { return values[static_cast<std::size_t>(row * columns + column)]; }
};

/// The coefficient of variation of the cells that are not empty, and have no empty ones beside them if there
/// are enough such.
double variationOf(Cells& cells) {
  constexpr int enough = 20;
  double sums[2] = {}, squares[2] = {};
  int counts[2] = {};
  for (int r = 0; r < cells.rows; ++r)
    for (int c = 0; c < cells.columns; ++c) {
      const auto n = static_cast<double>(cells.at(c, r));
      if (n == 0) continue;
      const bool inner = r > 0 && c > 0 && r + 1 < cells.rows && c + 1 < cells.columns &&
                         cells.at(c - 1, r) > 0 && cells.at(c + 1, r) > 0 && cells.at(c, r - 1) > 0 &&
                         cells.at(c, r + 1) > 0;
      for (int which = 0; which <= (inner ? 1 : 0); ++which)
        sums[which] += n, squares[which] += n * n, ++counts[which];
    }
  const int which = counts[1] > enough ? 1 : 0;
  const double mean = sums[which] / counts[which];
  return std::sqrt(std::max(0.0, squares[which] / counts[which] - mean * mean)) / mean;
}

/// A start moved in steps that shrink, while that lowers the value.
cv::Point3d descend(cv::Point3d at, const cv::Point3d& center,
                    const std::function<double(const cv::Point3d&)>& value) {
  constexpr double firstStep = 0.25, lastStep = 0.01;  // steps, as shares of the distance to the center
  const auto ways = directions(14);
  double here = value(at);
  const double away = cv::norm(at - center);
  for (double step = firstStep * away; step > lastStep * away;) {
    bool moved = false;
    for (const cv::Vec3d& way : ways) {
      const cv::Point3d next = at + cv::Point3d(way * step);
      if (const double there = value(next); there < here) here = there, at = next, moved = true;
    }
    if (!moved) step /= 2;
  }
  return at;
}

/// Share of the cells of a view from afar in which two surfaces lie behind each other.
double hiddenShare(std::span<const cv::Point3f> points, const cv::Vec3d& from, double spacing) {
  constexpr float cell = 2.5, steep = 6;  // spacings; cells of depth within one cell, as of a surface at 80°
  const cv::Matx33f turn(cameraLooking(-from));
  const auto edge = cell * static_cast<float>(spacing);
  std::vector<cv::Point3f> turned;
  float left = std::numeric_limits<float>::infinity(), top = left, right = -left, bottom = -left;
  turned.reserve(points.size());
  for (const cv::Point3f& p : points) {
    const float* m = turn.val;  // cv's product is a loop
    turned.emplace_back(m[0] * p.x + m[1] * p.y + m[2] * p.z, m[3] * p.x + m[4] * p.y + m[5] * p.z,
                        m[6] * p.x + m[7] * p.y + m[8] * p.z);
    left = std::min(left, turned.back().x), right = std::max(right, turned.back().x);
    top = std::min(top, turned.back().y), bottom = std::max(bottom, turned.back().y);
  }
  constexpr float maxCells = 4096;  // to a side
  if (right - left > maxCells * edge || bottom - top > maxCells * edge) return 1;
  Cells nearest{static_cast<int>((right - left) / edge) + 1, static_cast<int>((bottom - top) / edge) + 1, {}};
  nearest.values.assign(static_cast<std::size_t>(nearest.columns) * static_cast<std::size_t>(nearest.rows),
                        std::numeric_limits<float>::infinity());
  Cells farthest = nearest;
  std::ranges::fill(farthest.values, -std::numeric_limits<float>::infinity());
  for (const cv::Point3f& p : turned) {
    const int c = static_cast<int>((p.x - left) / edge), r = static_cast<int>((p.y - top) / edge);
    nearest.at(c, r) = std::min(nearest.at(c, r), p.z);
    farthest.at(c, r) = std::max(farthest.at(c, r), p.z);
  }
  std::size_t seen = 0, twice = 0;
  for (std::size_t i = 0; i < nearest.values.size(); ++i) {
    if (nearest.values[i] > farthest.values[i]) continue;
    ++seen;
    if (farthest.values[i] - nearest.values[i] > steep * edge) ++twice;
  }
  return static_cast<double>(twice) / static_cast<double>(std::max<std::size_t>(seen, 1));
}

/// Whether the rim of the points lies further away than their middle, as seen from a direction. A shell of
/// one side hides nothing from its back either, but things bulge outwards.
bool bulges(std::span<const cv::Point3f> points, const cv::Vec3d& from) {
  const cv::Vec3d center = meanOf(points);
  double heights = 0, squares = 0, products = 0;
  for (const cv::Point3f& p : points) {
    const cv::Vec3d off = cv::Vec3d(p.x, p.y, p.z) - center;
    const double height = off.dot(from), squared = off.dot(off) - height * height;
    heights += height, squares += squared, products += height * squared;
  }
  return products * static_cast<double>(points.size()) < heights * squares;
}

struct Pixel {
  Eigen::Vector4d place;  // homogeneous, in units of the cloud's size around its mean
  double column, row;     // in units of half the width around the middle
};

std::vector<Pixel> pixelsOf(const PointCloud& cloud, Eigen::Vector3d& center, double& size) {
  constexpr std::size_t wanted = 4000;
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    if (isMeasured(cloud.points[i])) finite.push_back(i);
  const std::size_t step = std::max<std::size_t>(1, finite.size() / wanted);
  const auto placeOf = [&](std::size_t i) {
    const cv::Point3f& p = cloud.points[i];
    return Eigen::Vector3d(static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
  };
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < finite.size(); i += step) taken.push_back(finite[i]);
  center.setZero();
  for (const std::size_t i : taken) center += placeOf(i) / static_cast<double>(taken.size());
  size = 0;
  for (const std::size_t i : taken) size += (placeOf(i) - center).norm() / static_cast<double>(taken.size());
  std::vector<Pixel> pixels;
  if (!(size > 0)) return pixels;
  const double half = static_cast<double>(cloud.width) / 2, middle = static_cast<double>(cloud.height) / 2;
  for (const std::size_t i : taken) {
    const Eigen::Vector3d at = (placeOf(i) - center) / size;
    pixels.push_back({{at[0], at[1], at[2], 1},
                      (static_cast<double>(i % cloud.width) - half) / half,
                      (static_cast<double>(i / cloud.width) - middle) / half});
  }
  return pixels;
}

}  // namespace

cv::Affine3d viewFrom(const cv::Point3d& viewpoint, std::span<const cv::Point3f> points) {
  if (!std::isfinite(viewpoint.x) || !std::isfinite(viewpoint.y) || !std::isfinite(viewpoint.z))
    fail(ErrorCode::invalidOption, "the viewpoint is ({}, {}, {}); give finite coordinates", viewpoint.x,
         viewpoint.y, viewpoint.z);
  const cv::Vec3d forward = meanOf(points) - cv::Vec3d(viewpoint);
  if (!(cv::norm(forward) > 0))
    fail(ErrorCode::invalidOption,
         "the viewpoint ({}, {}, {}) is the center of the cloud; give that of the sensor", viewpoint.x,
         viewpoint.y, viewpoint.z);
  const cv::Matx33d turn = cameraLooking(cv::normalize(forward));
  return {turn, -(turn * cv::Vec3d(viewpoint))};
}

std::vector<cv::Point3f> drawnFrom(std::span<const cv::Point3f> points, std::size_t count) {
  std::vector<cv::Point3f> drawn;
  std::mt19937_64 random(1);
  // Knuth's selection sampling (Algorithm S)
  for (std::size_t i = 0; i < points.size() && drawn.size() < count; ++i)
    if (random() % (points.size() - i) < count - drawn.size()) drawn.push_back(points[i]);
  return drawn;
}

double unevenness(std::span<const cv::Point3f> points, const cv::Point3d& viewpoint) {
  constexpr double maxSlope = 4, perCell = 12, trimmed = 0.02;
  if (points.empty()) return infinity;
  const cv::Vec3d forward = meanOf(points) - cv::Vec3d(viewpoint);
  if (!(cv::norm(forward) > 0)) return infinity;
  const cv::Matx33d turn = cameraLooking(cv::normalize(forward));
  std::vector<cv::Point2f> slopes;
  slopes.reserve(points.size());
  for (const cv::Point3f& p : points) {
    const cv::Vec3d q = turn * (cv::Vec3d(p.x, p.y, p.z) - cv::Vec3d(viewpoint));
    if (!(q[2] > 0) || std::abs(q[0]) > maxSlope * q[2] || std::abs(q[1]) > maxSlope * q[2]) return infinity;
    slopes.emplace_back(static_cast<float>(q[0] / q[2]), static_cast<float>(q[1] / q[2]));
  }
  // The area without stray points, of which cells get their size.
  const auto span = [&](float cv::Point2f::*axis) {
    std::vector<float> values;
    for (const cv::Point2f& s : slopes) values.push_back(s.*axis);
    const auto cut = static_cast<std::ptrdiff_t>(trimmed * static_cast<double>(values.size()));
    std::nth_element(values.begin(), values.begin() + cut, values.end());
    const float low = values[static_cast<std::size_t>(cut)];
    std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
    return static_cast<double>(values[values.size() - 1 - static_cast<std::size_t>(cut)] - low);
  };
  const double area = span(&cv::Point2f::x) * span(&cv::Point2f::y);
  const double edge = std::sqrt(area * perCell / static_cast<double>(points.size()));
  constexpr double maxCells = 1024;  // to a side
  if (!(edge > 2 * maxSlope / maxCells)) return infinity;
  const auto inverse = static_cast<float>(1 / edge);
  const auto low = static_cast<float>(-maxSlope);
  const int side = static_cast<int>(2 * maxSlope / edge) + 1;
  Cells cells{side, side,
              std::vector<float>(static_cast<std::size_t>(side) * static_cast<std::size_t>(side))};
  for (const cv::Point2f& s : slopes)
    ++cells.at(std::min(side - 1, static_cast<int>((s.x - low) * inverse)),
               std::min(side - 1, static_cast<int>((s.y - low) * inverse)));
  return variationOf(cells) * std::sqrt(perCell);
}

std::vector<cv::Point3d> findViewpoints(std::span<const cv::Point3f> points, int threads) {
  constexpr std::size_t minPoints = 5000, starts = 6;  // fewer fill too few cells for a decision
  constexpr double apart = 0.7;                        // cosine of the directions of two starts
  if (points.size() < minPoints) return {};
  const std::vector<cv::Point3f> drawn = drawnFrom(points, drawnPoints);
  const cv::Vec3d center = meanOf(drawn);
  const double radius = radiusOf(drawn, center);
  if (!(radius > 0)) return {};
  const auto value = [&](const cv::Point3d& place) { return unevenness(drawn, place); };
  std::vector<cv::Point3d> places;
  for (const double away : {1.2, 2.0, 3.5})
    for (const cv::Vec3d& direction : directions(300))
      places.emplace_back(center + direction * (away * radius));
  std::vector<std::pair<double, std::size_t>> order(places.size());
  inParallel(places.size(), threads, Progress::none(), "stopped while the viewpoint was looked for",
             [&](std::size_t i) {
               order[i] = {value(places[i]), i};
             });
  std::ranges::sort(order);
  std::vector<cv::Vec3d> tried;
  std::vector<std::pair<double, cv::Point3d>> found;
  for (const auto& [start, i] : order) {
    const cv::Vec3d direction = cv::normalize(cv::Vec3d(places[i]) - center);
    if (std::ranges::any_of(tried, [&](const cv::Vec3d& t) { return t.dot(direction) > apart; })) continue;
    tried.push_back(direction);
    const cv::Point3d at = descend(places[i], cv::Point3d(center), value);
    if (const double here = value(at); here <= even) found.emplace_back(here, at);
    if (tried.size() == starts) break;
  }
  std::ranges::stable_sort(found, {}, &std::pair<double, cv::Point3d>::first);
  std::vector<cv::Point3d> all;
  for (const auto& [uneven, at] : found) all.push_back(at);
  return all;
}

std::optional<cv::Point3d> directionOfView(std::span<const cv::Point3f> points, double spacing, int threads) {
  constexpr double maxHidden = 0.25, similar = 0.02;
  if (points.empty() || !(spacing > 0)) return {};
  const auto all = directions(200);
  std::vector<double> hidden(all.size());
  inParallel(all.size(), threads, Progress::none(), "stopped while the viewpoint was looked for",
             [&](std::size_t i) { hidden[i] = hiddenShare(points, all[i], spacing); });
  const double least = *std::ranges::min_element(hidden);
  if (least > maxHidden) return {};
  cv::Vec3d sum;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (hidden[i] <= least + similar && bulges(points, all[i])) sum += all[i];
  return cv::norm(sum) > 0 ? std::optional(cv::Point3d(cv::normalize(sum))) : std::nullopt;
}

std::optional<cv::Point3d> viewpointOfGrid(const PointCloud& cloud) {
  constexpr std::size_t minPixels = 100;
  constexpr double maxError = 1;  // [pixels], median
  constexpr double clearly = 30;  // times the smallest eigenvalue: the points do not lie in a plane
  if (!cloud.organized() || cloud.width < 2) return {};
  Eigen::Vector3d center;
  double size = 0;
  const std::vector<Pixel> pixels = pixelsOf(cloud, center, size);
  if (pixels.size() < minPixels) return {};

  // Direct linear transform (Hartley and Zisserman, 7.1): a row x P₃ − P₁ = 0 and one y P₃ − P₂ = 0 a pixel
  Eigen::Matrix<double, 12, 12> sums = Eigen::Matrix<double, 12, 12>::Zero();
  for (const Pixel& p : pixels) {
    Eigen::Matrix<double, 2, 12> rows = Eigen::Matrix<double, 2, 12>::Zero();
    rows.block<1, 4>(0, 0) = rows.block<1, 4>(1, 4) = -p.place.transpose();
    rows.block<1, 4>(0, 8) = p.column * p.place.transpose();
    rows.block<1, 4>(1, 8) = p.row * p.place.transpose();
    sums.noalias() += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>> solver(sums);
  if (solver.info() != Eigen::Success) return {};
  const double rounding = 1e-13 * solver.eigenvalues()[11];
  if (!(solver.eigenvalues()[1] > clearly * std::max(solver.eigenvalues()[0], rounding))) return {};
  const Eigen::Matrix<double, 12, 1> best = solver.eigenvectors().col(0);
  Eigen::Matrix<double, 3, 4> projection;
  for (int r = 0; r < 3; ++r) projection.row(r) = best.segment<4>(4 * r).transpose();

  std::vector<double> errors;
  for (const Pixel& p : pixels) {
    const Eigen::Vector3d at = projection * p.place;
    errors.push_back(std::hypot(at[0] / at[2] - p.column, at[1] / at[2] - p.row));
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  if (!(*middle * static_cast<double>(cloud.width) / 2 <= maxError)) return {};

  // The center of projection is what the matrix maps to 0.
  const Eigen::JacobiSVD<Eigen::Matrix<double, 3, 4>> svd(projection, Eigen::ComputeFullV);
  const Eigen::Vector4d null = svd.matrixV().col(3);
  const Eigen::Vector3d at = center + size * null.head<3>() / null[3];
  if (!at.allFinite()) return {};
  return cv::Point3d(at[0], at[1], at[2]);
}

}  // namespace estancia
