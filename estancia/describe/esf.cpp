// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/esf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

// ---- lines through a voxelized surface

constexpr int gridSide = 64;
constexpr int wordCount = gridSide * gridSide * gridSide / 32;
constexpr std::size_t lineLanes = 16;

/// Voxels reach up to whole numbers above 0 and from them below, as in PCL; rounding must not lead outside.
int indexOf(float coordinate) {
  const float floor = std::floor(coordinate), ceil = std::ceil(coordinate);
  return std::clamp(static_cast<int>(coordinate < 0 ? floor : ceil - 1) + gridSide / 2, 0, gridSide - 1);
}

/// Marks the neighbors of all that is marked; a row is 64 voxels along z.
void spread(std::vector<std::uint64_t>& rows) {
  for (std::uint64_t& row : rows) row |= row << 1 | row >> 1;
  const auto along = [&](std::size_t stride, std::size_t across) {
    for (std::size_t line = 0; line < gridSide; ++line) {
      std::uint64_t before = 0;
      for (std::size_t i = 0; i < gridSide; ++i) {
        std::uint64_t& row = rows[line * across + i * stride];
        const std::uint64_t own = row;
        row |= before | (i + 1 < gridSide ? rows[line * across + (i + 1) * stride] : 0);
        before = own;
      }
    }
  };
  along(1, gridSide);
  along(gridSide, 1);
}

/// From one voxel to another, the last one excluded (PCL's lci()).
struct VoxelLine {
  std::int32_t from, to;
  /// Voxels that it passes, at least 1, and how many of them are marked.
  std::int32_t voxels, marked;
};

using Lane = std::array<std::int32_t, lineLanes>;

/// Bresenham's lines in three dimensions, lineLanes at a time and without a branch: in every step the longest
/// axis advances, and the others where their error is above 0.
ESTANCIA_MULTIVERSION void traceLanes(const std::uint32_t* bits, VoxelLine* lines) {
  Lane voxel, voxels, marked{}, error2, error3, step1, step2, step3, twice1, twice2, twice3;
  int longest = 0;
  for (std::size_t l = 0; l < lineLanes; ++l) {
    const int from = lines[l].from, to = lines[l].to;
    const int dx = (to >> 12) - (from >> 12), dy = (to >> 6 & 63) - (from >> 6 & 63),
              dz = (to & 63) - (from & 63);
    int n1 = std::abs(dx), n2 = std::abs(dy), n3 = std::abs(dz);
    int s1 = dx < 0 ? -gridSide * gridSide : gridSide * gridSide, s2 = dy < 0 ? -gridSide : gridSide,
        s3 = dz < 0 ? -1 : 1;
    const bool swap2 = n2 > n1;  // the longest first
    const int n = swap2 ? n2 : n1, s = swap2 ? s2 : s1;
    n2 = swap2 ? n1 : n2;
    s2 = swap2 ? s1 : s2;
    const bool swap3 = n3 > n;
    n1 = swap3 ? n3 : n;
    s1 = swap3 ? s3 : s;
    n3 = swap3 ? n : n3;
    s3 = swap3 ? s : s3;
    voxel[l] = from;
    voxels[l] = std::max(n1, 1);
    error2[l] = 2 * n2 - n1;
    error3[l] = 2 * n3 - n1;
    step1[l] = s1;
    step2[l] = s2;
    step3[l] = s3;
    twice1[l] = 2 * n1;
    twice2[l] = 2 * n2;
    twice3[l] = 2 * n3;
    longest = std::max(longest, voxels[l]);
  }
  for (int i = 0; i < longest; ++i) {
#pragma omp simd
    for (std::size_t l = 0; l < lineLanes; ++l) {
      // Finished lines may leave the grid; they read any voxel, which is not counted.
      const std::uint32_t word = bits[voxel[l] >> 5 & (wordCount - 1)];
      marked[l] += static_cast<std::int32_t>(word >> (voxel[l] & 31) & 1U) & (i < voxels[l] ? 1 : 0);
      const std::int32_t over2 = error2[l] > 0 ? -1 : 0, over3 = error3[l] > 0 ? -1 : 0;
      voxel[l] += step1[l] + (over2 & step2[l]) + (over3 & step3[l]);
      error2[l] += twice2[l] - (over2 & twice1[l]);
      error3[l] += twice3[l] - (over3 & twice1[l]);
    }
  }
  for (std::size_t l = 0; l < lineLanes; ++l) {
    lines[l].voxels = voxels[l];
    lines[l].marked = marked[l];
  }
}

/// 64³ voxels, one bit each: 32 KB, which fit the L1 cache.
class VoxelGrid {
 public:
  /// Marks the voxel of every point, and its 26 neighbors. Coordinates lie within ±32.
  explicit VoxelGrid(std::span<const cv::Point3f> points) : bits_(wordCount) {
    std::vector<std::uint64_t> rows(static_cast<std::size_t>(gridSide) * gridSide);
    voxels_.reserve(points.size());
    for (const cv::Point3f& p : points) {
      const int row = indexOf(p.x) * gridSide + indexOf(p.y), z = indexOf(p.z);
      rows[static_cast<std::size_t>(row)] |= 1ULL << z;
      voxels_.push_back(row * gridSide + z);
    }
    spread(rows);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      bits_[2 * i] = static_cast<std::uint32_t>(rows[i]);
      bits_[2 * i + 1] = static_cast<std::uint32_t>(rows[i] >> 32);
    }
  }

  /// The number of a point's voxel.
  std::int32_t voxelOf(std::size_t point) const { return voxels_[point]; }

  /// Fills in `voxels` and `marked`.
  void trace(std::span<VoxelLine> lines) const {
    std::size_t done = 0;
    for (; done + lineLanes <= lines.size(); done += lineLanes) traceLanes(bits_.data(), &lines[done]);
    if (done == lines.size()) return;
    std::array<VoxelLine, lineLanes> last{};  // the rest are lines of one voxel
    std::copy(lines.begin() + static_cast<std::ptrdiff_t>(done), lines.end(), last.begin());
    traceLanes(bits_.data(), last.data());
    std::copy_n(last.begin(), lines.size() - done, lines.begin() + static_cast<std::ptrdiff_t>(done));
  }

 private:
  std::vector<std::int32_t> voxels_;  // voxels of the points: (x · 64 + y) · 64 + z
  std::vector<std::uint32_t> bits_;   // in that order
};

// ---- shape functions

constexpr int bins = 64;
constexpr float sphereRadius = gridSide / 2;  // radius of the sphere that the cloud is scaled to [voxels]
constexpr float minArea = 0.001F;             // smaller squared areas are degenerate [voxels⁴]
// PCL's limits, in voxels: a line with so few marked is outside, a triangle with at most so many, too …
constexpr int outsideBin = 7, triangleOutsideBin = 21;
// … and one with so few that are not marked is inside.
constexpr int insideBin = 1, triangleInsideBin = 3;
constexpr std::array<float, 10> histogramWeights{0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 1, 0.5F, 2, 2, 1};

enum Where : std::size_t { inside, outside, mixed };
using Histogram = std::array<float, bins>;

/// Random numbers that are the same everywhere (splitmix64, Steele et al. 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// Below n.
  std::size_t below(std::size_t n) {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15ULL;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ z >> 27) * 0x94d049bb133111ebULL;
    return static_cast<std::size_t>(((z ^ z >> 31) >> 32) * n >> 32);
  }

 private:
  std::uint64_t state_;
};

void requireValid(const EsfOptions& options) {
  validate(options);
  if (options.points == 1 || options.points == 2)
    fail(ErrorCode::invalidOption, "esf.points is {}; give at least 3, or 0 for all", options.points);
}

/// At most `maxPoints` of the finite points: one random point of each of as many equal runs.
std::vector<cv::Point3f> thinned(const PointCloud& cloud, std::size_t maxPoints, Random& random) {
  std::vector<cv::Point3f> points;
  points.reserve(cloud.points.size());
  for (const cv::Point3f& p : cloud.points)
    if (isFinite(p)) points.push_back(p);
  if (maxPoints == 0 || points.size() <= maxPoints) return points;
  const std::size_t all = points.size();
  for (std::size_t i = 0; i < maxPoints; ++i) {
    const std::size_t begin = i * all / maxPoints, end = (i + 1) * all / maxPoints;
    points[i] = points[begin + random.below(end - begin)];  // begin ≥ i: not yet overwritten
  }
  points.resize(maxPoints);
  return points;
}

/// Moves the center of gravity to the origin and the furthest point to the distance sphereRadius.
void scale(std::vector<cv::Point3f>& points) {
  cv::Point3d center;
  for (const cv::Point3f& p : points) center += cv::Point3d(p);
  center *= 1.0 / static_cast<double>(points.size());
  cv::Point3d furthest;
  for (const cv::Point3f& p : points)
    if (const cv::Point3d d = cv::Point3d(p) - center; d.dot(d) > furthest.dot(furthest)) furthest = d;
  const double radius = std::sqrt(furthest.dot(furthest));
  if (!(radius > 0))
    fail(ErrorCode::insufficientData, "esf: all points are equal; give a cloud with some extent");
  double thickness = 0;
  for (cv::Point3f& p : points) {
    const cv::Point3d d = (cv::Point3d(p) - center) * (1 / radius), off = d.cross(furthest * (1 / radius));
    thickness = std::max(thickness, off.dot(off));
    p = cv::Point3f(d * sphereRadius);
  }
  if (thickness < 1e-10)
    fail(ErrorCode::insufficientData, "esf: the points are collinear; give a cloud with some extent");
}

std::size_t binOf(float share) {
  return std::min(static_cast<std::size_t>(share * (bins - 1) + 0.5F), static_cast<std::size_t>(bins - 1));
}

/// Histogram bin of an angle, 0 to 90 degrees, given by its cosine.
std::size_t binOfAngle(float cosine) {
  return binOf(std::acos(std::min(std::abs(cosine), 1.0F)) * static_cast<float>(2 / std::numbers::pi));
}

Where whereOf(const VoxelLine& side) {
  return side.marked >= side.voxels - insideBin ? inside : side.marked <= outsideBin ? outside : mixed;
}

Where whereOf(std::span<const VoxelLine, 3> sides) {
  const int marked = sides[0].marked + sides[1].marked + sides[2].marked,
            voxels = sides[0].voxels + sides[1].voxels + sides[2].voxels;
  return marked <= triangleOutsideBin ? outside : voxels - marked <= triangleInsideBin ? inside : mixed;
}

/// Three points that are not collinear.
struct Triangle {
  std::array<float, 3> lengths;  ///< from the first point to the second, first to third, second to third
  std::array<float, 3> cosines;  ///< cosines of the angles opposite of these sides
  float area;                    ///< its square root [voxels]
};

/// Three random points.
struct Draw {
  std::size_t i, j, k;

  Draw(const std::vector<cv::Point3f>& points, Random& random)
      : i(random.below(points.size())), j(random.below(points.size())), k(random.below(points.size())) {
#ifdef __GNUC__
    for (const std::size_t at : {i, j, k}) __builtin_prefetch(&points[at]);
#endif
  }
};

std::optional<Triangle> triangleOf(const std::vector<cv::Point3f>& points, const Draw& draw) {
  if (draw.i == draw.j || draw.i == draw.k || draw.j == draw.k) return std::nullopt;
  const cv::Point3f &p = points[draw.i], &q = points[draw.j], &r = points[draw.k];
  const cv::Point3f pq = q - p, pr = r - p, rq = q - r;
  const float a = std::sqrt(pq.dot(pq)), b = std::sqrt(pr.dot(pr)), c = std::sqrt(rq.dot(rq));
  const float s = (a + b + c) * 0.5F, square = s * (s - a) * (s - b) * (s - c);  // Heron
  if (!(square > minArea)) return std::nullopt;
  return Triangle{{a, b, c},
                  {rq.dot(pr) / (c * b), rq.dot(pq) / (c * a), pq.dot(pr) / (a * b)},
                  std::sqrt(std::sqrt(square))};
}

struct Triangles {
  std::vector<Triangle> shapes;
  std::vector<VoxelLine> sides;  ///< three each, as their lengths
};

Triangles drawTriangles(const std::vector<cv::Point3f>& points, std::size_t count, Random& random) {
  const VoxelGrid grid(points);
  Triangles triangles;
  triangles.shapes.reserve(count);
  triangles.sides.reserve(3 * count);
  Draw next(points, random);
  for (std::size_t tries = 0; triangles.shapes.size() < count; ++tries) {
    if (tries >= 100 * count + 1000)
      fail(ErrorCode::insufficientData, "esf: nearly all points are equal; give a cloud with some extent");
    const Draw draw = next;
    next = Draw(points, random);  // prefetches its points
    const auto triangle = triangleOf(points, draw);
    if (!triangle) continue;
    triangles.shapes.push_back(*triangle);
    const std::int32_t p = grid.voxelOf(draw.i), q = grid.voxelOf(draw.j), r = grid.voxelOf(draw.k);
    triangles.sides.insert(triangles.sides.end(), {{p, q, 0, 0}, {p, r, 0, 0}, {q, r, 0, 0}});
  }
  grid.trace(triangles.sides);
  return triangles;
}

}  // namespace

OptionGroup declare(EsfOptions& options) {
  OptionGroup group("esf", "ESF: ensemble of shape functions of a point cloud.");
  group.add("samples", &options.samples, "Triples of points that are drawn.")
      .range(1, 1'000'000)
      .why("fewer are faster and noisier");
  group
      .add("points", &options.points, "Larger clouds are subsampled evenly to this size; 0 takes all points.")
      .range(0, 100'000'000);
  group.add("seed", &options.seed, "Seed of the triples and the subsampling.");
  return group;
}

std::vector<float> esf(const PointCloud& cloud, const EsfOptions& options) {
  requireValid(options);
  Random random(options.seed);
  std::vector<cv::Point3f> points = thinned(cloud, static_cast<std::size_t>(options.points), random);
  if (points.size() < 3)
    fail(ErrorCode::insufficientData, "esf: {} finite points; give at least 3", points.size());
  scale(points);
  const auto [triangles, lines] = drawTriangles(points, static_cast<std::size_t>(options.samples), random);

  float longest = 0, largest = 0;
  for (const Triangle& t : triangles) {
    longest = std::max({longest, t.lengths[0], t.lengths[1], t.lengths[2]});
    largest = std::max(largest, t.area);
  }
  std::array<Histogram, 10> histograms{};
  Histogram *angles = &histograms[0], *areas = &histograms[3], *distances = &histograms[6],
            &ratios = histograms[9];
  for (std::size_t n = 0; n < triangles.size(); ++n) {
    const Triangle& t = triangles[n];
    const std::span<const VoxelLine, 3> sides(&lines[3 * n], 3);
    const Where where = whereOf(sides);
    ++areas[where][binOf(t.area / largest)];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto voxels = static_cast<float>(sides[i].voxels), marked = static_cast<float>(sides[i].marked);
      angles[where][binOfAngle(t.cosines[i])] += voxels / 32;
      ++distances[whereOf(sides[i])][binOf(t.lengths[i] / longest)];
      if (whereOf(sides[i]) == mixed) ++ratios[binOf(marked / voxels)];
    }
  }

  std::vector<float> descriptor;
  for (std::size_t h = 0; h < histograms.size(); ++h)
    for (const float v : histograms[h]) descriptor.push_back(v * histogramWeights[h]);
  const float sum = std::accumulate(descriptor.begin(), descriptor.end(), 0.0F);
  for (float& v : descriptor) v /= sum;
  return descriptor;
}

Esf::Esf(const EsfOptions& options) : options_(options) {
  requireValid(options);
}

std::vector<DescriptorPart> Esf::parts() const {
  DescriptorPart part{"esf",
                      PartKind::histogram,
                      {},
                      fmt::format("esf 1, {} samples of {} points, seed {}", options_.samples,
                                  options_.points, options_.seed)};
  for (const char* what : {"angle inside", "angle outside", "angle mixed", "area inside", "area outside",
                           "area mixed", "distance inside", "distance outside", "distance mixed", "ratio"})
    for (int bin = 0; bin < bins; ++bin) part.columns.push_back(fmt::format("esf {} {}", what, bin));
  return {std::move(part)};
}

std::vector<float> Esf::describe(const View& view) const {
  if (view.depth.empty()) fail(ErrorCode::invalidInput, "esf: the view has no depth; give a depth image");
  if (!view.camera) fail(ErrorCode::invalidInput, "esf: the depth camera is unknown; give its intrinsics");
  return esf(backProject(view.depth, *view.camera), options_);
}

}  // namespace estancia
