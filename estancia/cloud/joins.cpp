#include "estancia/cloud/joins.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <tuple>

#include "estancia/cloud/facet.hpp"
#include "estancia/core/cores.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr double kLeastShape = 100, kLeastWall = 600;          // [square pixels]
constexpr std::size_t kMostSurface = 1500, kMostBorder = 256;  // points that stand for a piece
constexpr std::size_t kContacts = 3;                           // points of the border that must be near
constexpr double kConcave = -0.2;                              // how concave a contact may be
constexpr float kAroundContact = 0.03F;                        // [m]
constexpr double kWidestGap = 0.20;                            // behind something nearer [m]
constexpr float kAroundGap = 0.05F;                            // what of either side is looked at [m]
constexpr double kSameWay = 20, kOffset = 0.025;               // of two parts of one surface [°], [m]
constexpr double kHidden = 0.9, kInFront = 0.3;                // shares of the gap
constexpr float kNearer = 0.01F;                               // what is in front of the gap is so much [m]

/// Some points of a piece, and of its border in the picture.
struct Shape {
  std::uint32_t piece;
  std::vector<cv::Point3f> surface, border;
  cv::Point3f low, high;       ///< of the border
  std::vector<float> x, y, z;  ///< the border by coordinate, so that many points are compared at once
};

void thin(std::vector<cv::Point3f>& points, std::size_t most) {
  if (points.size() <= most) return;
  for (std::size_t i = 0; i < most; ++i) points[i] = points[i * points.size() / most];
  points.resize(most);
}

/// Of all pieces that are not too small, in their order.
std::vector<Shape> shapesOf(const InverseDepth& grid, const Mask& mask, const Pieces& pieces) {
  std::vector<Shape> shapes;
  std::vector<std::uint32_t> shapeOf(pieces.sizes.size()), skip(pieces.sizes.size());
  for (std::uint32_t i = 1; i < pieces.sizes.size(); ++i) {
    if (pieces.sizes[i] < grid.area(kLeastShape)) continue;
    shapes.emplace_back().piece = i;
    shapeOf[i] = static_cast<std::uint32_t>(shapes.size());
  }
  const auto stride = static_cast<std::size_t>(grid.stride);
  mask.eachPixel([&](std::size_t i) {
    const std::uint32_t label = pieces.labels[i];
    if (shapeOf[label] == 0) return;
    Shape& shape = shapes[shapeOf[label] - 1];
    if (skip[label]-- == 0) {
      skip[label] = pieces.sizes[label] / kMostSurface;
      shape.surface.push_back(grid.point(i));
    }
    if (pieces.labels[i - 1] != label || pieces.labels[i + 1] != label ||
        pieces.labels[i - stride] != label || pieces.labels[i + stride] != label)
      shape.border.push_back(grid.point(i));
  });
  for (Shape& shape : shapes) {
    thin(shape.border, kMostBorder);
    shape.low = shape.high = shape.border.front();
    for (const cv::Point3f& p : shape.border) {
      shape.x.push_back(p.x);
      shape.y.push_back(p.y);
      shape.z.push_back(p.z);
      shape.low = {std::min(shape.low.x, p.x), std::min(shape.low.y, p.y), std::min(shape.low.z, p.z)};
      shape.high = {std::max(shape.high.x, p.x), std::max(shape.high.y, p.y), std::max(shape.high.z, p.z)};
    }
  }
  return shapes;
}

float squared(const cv::Point3f& v) {
  return v.dot(v);
}

/// Squared, as the bits of the float: those of floats that are not negative order as they do.
ESTANCIA_MULTIVERSION
std::int32_t nearestOf(const float* x, const float* y, const float* z, std::size_t count, float px, float py,
                       float pz) {
  std::int32_t least = std::numeric_limits<std::int32_t>::max();
  for (std::size_t i = 0; i < count; ++i) {
    const float dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    least = std::min(least, std::bit_cast<std::int32_t>(dx * dx + dy * dy + dz * dz));
  }
  return least;
}

double distanceOfBoxes(const Shape& a, const Shape& b) {
  const auto apart = [](float lowA, float highA, float lowB, float highB) {
    return std::max({0.F, lowB - highA, lowA - highB});
  };
  return cv::norm(cv::Point3f(apart(a.low.x, a.high.x, b.low.x, b.high.x),
                              apart(a.low.y, a.high.y, b.low.y, b.high.y),
                              apart(a.low.z, a.high.z, b.low.z, b.high.z)));
}

/// The points of the one within `radius` of a point of the other.
std::vector<cv::Point3f> near(std::span<const cv::Point3f> points, std::span<const cv::Point3f> others,
                              float radius) {
  std::vector<cv::Point3f> result;
  for (const cv::Point3f& p : points)
    if (std::ranges::any_of(others, [&](const cv::Point3f& q) { return squared(p - q) < radius * radius; }))
      result.push_back(p);
  return result;
}

/// The plane of what is seen of a surface, looking towards the camera.
std::optional<Facet> seenFacet(std::span<const cv::Point3f> points, std::size_t fewest) {
  auto facet = facetOf(points, fewest);
  if (facet && facet->normal.dot(facet->centre) > 0) facet->normal = -facet->normal;
  return facet;
}

/// Whether the surfaces meet flat or convexly where they touch (Stein et al., CVPR 2014, equation 4).
bool meetConvexly(const Shape& a, const Shape& b, std::span<const cv::Point3f> contactA,
                  std::span<const cv::Point3f> contactB) {
  constexpr float reach = 2 * kAroundContact;
  const auto atA =
      seenFacet(near(near(a.surface, contactB, reach), near(b.surface, contactA, reach), kAroundContact), 3);
  const auto atB =
      seenFacet(near(near(b.surface, contactA, reach), near(a.surface, contactB, reach), kAroundContact), 3);
  if (!atA || !atB) return true;  // too small to tell
  const cv::Vec3d between = atA->centre - atB->centre;
  const double length = cv::norm(between);
  return length == 0 || (atA->normal - atB->normal).dot(between) > kConcave * length;
}

/// Whether something nearer hides what lies between two points of these pieces.
bool isHidden(const InverseDepth& grid, const Pieces& pieces, const Shape& a, const Shape& b,
              const cv::Point3f& from, const cv::Point3f& to) {
  constexpr int steps = 39;
  int covered = 0, front = 0;
  for (int i = 1; i < steps; ++i) {
    const cv::Point3f p = from + (to - from) * (static_cast<float>(i) / steps);
    const int u = static_cast<int>(std::lround(grid.camera.fx * p.x / p.z + grid.camera.cx));
    const int v = static_cast<int>(std::lround(grid.camera.fy * p.y / p.z + grid.camera.cy));
    const std::size_t at =
        grid.at(std::clamp(u, 0, grid.camera.width - 1), std::clamp(v, 0, grid.camera.height - 1));
    const float w = grid.raw[at];
    const bool nearer = w > 0 && 1 / w < p.z - kNearer;
    const bool own = pieces.labels[at] == a.piece || pieces.labels[at] == b.piece;
    front += nearer ? 1 : 0;
    covered += nearer || own || w == 0 ? 1 : 0;
  }
  return covered > kHidden * (steps - 1) && front > kInFront * (steps - 1);
}

bool continueEachOther(const Shape& a, const Shape& b, const cv::Point3f& endA, const cv::Point3f& endB) {
  constexpr std::size_t fewest = 15;
  const auto atA = seenFacet(near(a.surface, {&endA, 1}, kAroundGap), fewest);
  const auto atB = seenFacet(near(b.surface, {&endB, 1}, kAroundGap), fewest);
  if (!atA || !atB) return false;
  const cv::Vec3d between = atB->centre - atA->centre;
  const double off = std::max(std::abs(between.dot(atA->normal)), std::abs(between.dot(atB->normal)));
  return off < kOffset && atA->normal.dot(atB->normal) > std::cos(kSameWay * CV_PI / 180);
}

bool belongTogether(const InverseDepth& grid, const Pieces& pieces, const Shape& a, const Shape& b,
                    double contact) {
  const auto close = static_cast<float>(contact * contact);
  std::vector<cv::Point3f> contactA, contactB;
  float nearest = std::numeric_limits<float>::infinity();
  cv::Point3f endA, endB;
  for (const cv::Point3f& p : b.border) {
    const auto least =
        std::bit_cast<float>(nearestOf(a.x.data(), a.y.data(), a.z.data(), a.x.size(), p.x, p.y, p.z));
    if (!(least < std::max(close, nearest))) continue;
    const cv::Point3f& other =
        *std::ranges::min_element(a.border, {}, [&](const cv::Point3f& q) { return squared(p - q); });
    if (least < close) {
      contactB.push_back(p);
      contactA.push_back(other);
    }
    if (least < nearest) std::tie(nearest, endA, endB) = std::tuple(least, other, p);
  }
  if (contactB.size() >= kContacts) return meetConvexly(a, b, contactA, contactB);
  return nearest <= kWidestGap * kWidestGap && isHidden(grid, pieces, a, b, endB, endA) &&
         continueEachOther(a, b, endA, endB);
}

/// A circle (Kåsa 1976) through most of some points of a plane.
struct Circle {
  cv::Point2d centre;
  double radius = 0;
  double share = 0;  ///< of the points that lie on it
  double arc = 0;    ///< what they see of it [°]
};

std::optional<Circle> circleOf(const std::vector<cv::Point2d>& points, double tolerance) {
  constexpr double trimmed = 0.7, least = 0.75;  // of the points; of the tolerance
  Circle circle;
  std::vector<double> off(points.size(), 0), sorted;
  double most = 0;
  const auto rank = static_cast<std::size_t>(trimmed * static_cast<double>(points.size() - 1));
  for (int round = 0; round < 6; ++round) {
    cv::Matx33d squares = cv::Matx33d::zeros();
    cv::Vec3d products, x;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (off[i] > most) continue;
      const cv::Vec3d row(points[i].x, points[i].y, 1);
      squares += row * row.t();
      products += row * points[i].dot(points[i]);
    }
    if (!cv::solve(squares, products, x, cv::DECOMP_CHOLESKY)) return {};
    circle.centre = {x[0] / 2, x[1] / 2};
    circle.radius = std::sqrt(std::max(1e-9, x[2] + circle.centre.dot(circle.centre)));
    for (std::size_t i = 0; i < points.size(); ++i)
      off[i] = std::abs(cv::norm(points[i] - circle.centre) - circle.radius);
    sorted = off;
    std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(rank));
    most = std::max(least * tolerance, sorted[rank]);
  }
  std::vector<double> angles;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Point2d d = points[i] - circle.centre;
    if (off[i] < tolerance) angles.push_back(std::atan2(d.y, d.x));
  }
  if (angles.empty()) return {};
  circle.share = static_cast<double>(angles.size()) / static_cast<double>(points.size());
  std::ranges::sort(angles);
  double gap = angles.front() + 2 * CV_PI - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  circle.arc = 360 - gap * 180 / CV_PI;
  return circle;
}

/// How a piece stands on a plane.
struct Standing {
  std::vector<cv::Point2d> footprint;
  std::vector<double> heights;
};

Standing standing(const Shape& shape, const Plane& plane, std::size_t step) {
  const cv::Vec3d& n = plane.normal;
  const cv::Vec3d side = std::abs(n[0]) < 0.9 ? cv::Vec3d(1, 0, 0) : cv::Vec3d(0, 1, 0);
  const cv::Vec3d e1 = cv::normalize(n.cross(side)), e2 = n.cross(e1);
  Standing result;
  for (std::size_t i = 0; i < shape.surface.size(); i += step) {
    const cv::Vec3d p(shape.surface[i].x, shape.surface[i].y, shape.surface[i].z);
    result.footprint.emplace_back(p.dot(e1), p.dot(e2));
    result.heights.push_back(p.dot(n) - plane.offset);
  }
  return result;
}

double quantile(std::vector<double> values, double share) {
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + rank);
  return values[static_cast<std::size_t>(rank)];
}

constexpr std::size_t kStep = 5;  // every fifth point of a surface tells its footprint

/// The plane that the piece stands on, or over: the nearest below it.
const Plane* supportOf(const Shape& shape, const std::vector<Plane>& planes) {
  constexpr double sunk = -0.02;  // [m]
  const Plane* support = nullptr;
  double least = HUGE_VAL;
  for (const Plane& plane : planes) {
    const double height = quantile(standing(shape, plane, kStep).heights, 0.05);
    if (height > sunk && height < least) std::tie(least, support) = std::tuple(height, &plane);
  }
  return support;
}

/// The circle of a round wall, or of its rim where it leans.
std::optional<Circle> wallOf(const Standing& piece, double rim) {
  constexpr double tolerance = 0.008, belowRim = 0.02;  // [m]
  constexpr double narrowest = 0.02, widest = 0.20;     // radius [m]
  constexpr double mostly = 0.6, leastArc = 90;
  constexpr std::size_t fewest = 30, mostUpper = 300;
  std::vector<cv::Point2d> all, upper;
  std::size_t above = 0;
  for (const double height : piece.heights) above += height > rim - belowRim ? 1 : 0;
  const std::size_t every = 1 + above / mostUpper;
  for (std::size_t i = 0; i < piece.footprint.size(); ++i) {
    if (i % kStep == 0) all.push_back(piece.footprint[i]);
    if (piece.heights[i] > rim - belowRim && above-- % every == 0) upper.push_back(piece.footprint[i]);
  }
  for (const auto* points : {&all, &upper}) {
    if (points->size() < fewest) continue;
    const auto circle = circleOf(*points, tolerance);
    if (circle && circle->radius >= narrowest && circle->radius <= widest && circle->share > mostly &&
        circle->arc > leastArc)
      return circle;
  }
  return {};
}

/// Joins each piece with what partners(its shape) names; asks on several threads.
template <class Partners>
void join(const std::vector<Shape>& shapes, const Mask& mask, int threads, const Partners& partners,
          Pieces& pieces) {
  std::vector<std::vector<std::uint32_t>> found(shapes.size());
  inParallel(shapes.size(), static_cast<std::size_t>(threads > 0 ? threads : usableCores()),
             [&](std::size_t i) { found[i] = partners(shapes[i]); });
  DisjointSets sets(pieces.sizes.size());
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (const std::uint32_t other : found[i]) sets.join(shapes[i].piece, other);
  renumber(mask, pieces, sets);
}

}  // namespace

void joinPieces(const InverseDepth& grid, const Mask& mask, double contact, int threads, Pieces& pieces) {
  const std::vector<Shape> shapes = shapesOf(grid, mask, pieces);
  const auto partners = [&](const Shape& a) {
    std::vector<std::uint32_t> result;
    for (const Shape& b : shapes)
      if (b.piece > a.piece && distanceOfBoxes(a, b) <= std::max(kWidestGap, contact) &&
          !std::ranges::binary_search(pieces.touching, std::pair(a.piece, b.piece)) &&
          belongTogether(grid, pieces, a, b, contact))
        result.push_back(b.piece);
    return result;
  };
  join(shapes, mask, threads, partners, pieces);
}

void joinVessels(const InverseDepth& grid, const Mask& mask, const std::vector<Plane>& planes, int threads,
                 Pieces& pieces) {
  constexpr double beside = 0.015;  // [m]
  constexpr double inside = 0.85;
  constexpr double largest = 0.8;  // no vessel is [m]
  if (planes.empty()) return;
  const std::vector<Shape> shapes = shapesOf(grid, mask, pieces);
  const auto partners = [&](const Shape& wall) {
    std::vector<std::uint32_t> result;
    if (pieces.sizes[wall.piece] < grid.area(kLeastWall) || cv::norm(wall.high - wall.low) > largest)
      return result;
    const Plane* support = supportOf(wall, planes);
    if (support == nullptr) return result;
    const Standing round = standing(wall, *support, 1);
    const double rim = quantile(round.heights, 0.98);
    const auto circle = wallOf(round, rim);
    if (!circle) return result;
    for (const Shape& other : shapes) {
      if (&other == &wall || pieces.sizes[other.piece] > 3 * pieces.sizes[wall.piece]) continue;
      const Standing within = standing(other, *support, kStep);
      std::size_t count = 0;
      for (std::size_t i = 0; i < within.footprint.size(); ++i)
        count += cv::norm(within.footprint[i] - circle->centre) < circle->radius + beside &&
                 within.heights[i] < rim + beside;
      if (static_cast<double>(count) > inside * static_cast<double>(within.footprint.size()))
        result.push_back(other.piece);
    }
    return result;
  };
  join(shapes, mask, threads, partners, pieces);
}

}  // namespace estancia
