#include "estancia/cloud/planes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::size_t kSamples = 3000;
constexpr int kHypotheses = 150, kRefits = 10, kMostPlanes = 8, kMostTries = 16;
constexpr float kFaces = 0.94F;        // cosine between normals of samples and their plane's: 20°
constexpr float kFacesLoosely = 0.9F;  // 25°
constexpr float kGrazing = 0.1F;       // cosine below which the area of a pixel means nothing
constexpr double kHopeful = 0.7;       // of planeArea: what the samples may be short of
constexpr double kEdge = 10;           // cameras often see no depth so near to the edge [pixels]
constexpr double kReach = 4;           // so far beyond its patches a plane takes what lies on it [pixels]

using Coefficients = cv::Vec3d;  // w = a x + b y + c over the slopes x, y

/// Every second pixel of every second row, and which way the surface faces there.
struct Half {
  int width, height;
  double pixelArea;               ///< at 1 m, face to face [m²]
  std::vector<float> x, y;        ///< slopes of the columns and rows
  std::vector<float> w;           ///< 1/z, 0: none
  std::vector<float> nx, ny, nz;  ///< unit vectors away from the camera; 0 where none is known
  std::vector<float> near;        ///< of w: how far off the plane a pixel may be, times its |(a, b, c)|
  std::size_t row(int v) const { return static_cast<std::size_t>(v) * static_cast<std::size_t>(width); }
};

/// Adds the slope of 1/z between two opposite neighbors where both lie near.
ESTANCIA_MULTIVERSION
void addSlope(const float* middle, const float* a, const float* b, float weight, int width, float* sum,
              float* count) {
  constexpr float nearSurface = 0.06F;
  for (int u = 0; u < width; ++u) {
    const float c = middle[u];
    const bool surface = std::max(std::abs(a[u] - c), std::abs(b[u] - c)) < nearSurface * c;
    sum[u] += surface ? 0.5F * (a[u] - b[u]) : 0.F;
    count[u] += surface ? weight : 0.F;
  }
}

ESTANCIA_MULTIVERSION
void normalRow(const float* w, const float* x, float y, const float* across, const float* countAcross,
               const float* down, const float* countDown, float fx, float fy, int width, float* nx, float* ny,
               float* nz) {
  for (int u = 0; u < width; ++u) {
    const bool known = (countAcross[u] > 0) & (countDown[u] > 0);
    const float a = across[u] / std::max(countAcross[u], 1.F) * fx;
    const float b = down[u] / std::max(countDown[u], 1.F) * fy;
    const float c = w[u] - a * x[u] - b * y;
    const float scale = known ? 1 / std::sqrt(std::max(a * a + b * b + c * c, 1e-30F)) : 0.F;
    nx[u] = a * scale;
    ny[u] = b * scale;
    nz[u] = c * scale;
  }
}

Half halve(const InverseDepth& grid, double tolerance, int threads) {
  Half half;
  half.width = (grid.camera.width + 1) / 2;
  half.height = (grid.camera.height + 1) / 2;
  half.pixelArea = 4 / (grid.camera.fx * grid.camera.fy);
  for (int u = 0; u < grid.camera.width; u += 2) half.x.push_back(grid.slopeX[static_cast<std::size_t>(u)]);
  for (int v = 0; v < grid.camera.height; v += 2) half.y.push_back(grid.slopeY[static_cast<std::size_t>(v)]);
  const std::size_t n = half.row(half.height);
  for (auto* image : {&half.w, &half.nx, &half.ny, &half.nz, &half.near}) image->resize(n);
  const auto width = static_cast<std::size_t>(half.width);
  const auto fx = static_cast<float>(grid.camera.fx), fy = static_cast<float>(grid.camera.fy);
  inBands(half.height, threads, [&](int first, int last) {
    const auto full = static_cast<std::size_t>(grid.camera.width);
    std::vector<float> across(full), countAcross(full), down(full), countDown(full), normals[3];
    for (auto& n3 : normals) n3.resize(full);
    for (int v = first; v < last; ++v) {
      const float* w = &grid.smooth[grid.at(0, 2 * v)];
      for (auto* sums : {&across, &countAcross, &down, &countDown}) std::ranges::fill(*sums, 0.F);
      for (const int radius : {2, 5}) {
        const int steps = grid.pixels(radius);
        const std::ptrdiff_t below = steps * grid.stride;
        const auto weight = static_cast<float>(steps);
        addSlope(w, w + steps, w - steps, weight, grid.camera.width, across.data(), countAcross.data());
        addSlope(w, w + below, w - below, weight, grid.camera.width, down.data(), countDown.data());
      }
      normalRow(w, grid.slopeX.data(), grid.slopeY[2 * static_cast<std::size_t>(v)], across.data(),
                countAcross.data(), down.data(), countDown.data(), fx, fy, grid.camera.width,
                normals[0].data(), normals[1].data(), normals[2].data());
      const std::size_t at = half.row(v);
      for (std::size_t u = 0; u < width; ++u) {
        half.w[at + u] = w[2 * u];
        half.nx[at + u] = normals[0][2 * u];
        half.ny[at + u] = normals[1][2 * u];
        half.nz[at + u] = normals[2][2 * u];
        half.near[at + u] =
            w[2 * u] > 0 ? static_cast<float>(tolerance) * std::max(w[2 * u], 1 / w[2 * u]) : 0;
      }
    }
  });
  return half;
}

/// Samples by coordinate, so that many are compared at once.
struct Samples {
  std::array<float, kSamples> x, y, w, near, nx, ny, nz, area;
  double whole = 0;  ///< samples' area → all candidates' [m²]
};

void draw(const Half& half, const std::vector<std::uint32_t>& candidates, cv::RNG& random, Samples& s) {
  for (std::size_t i = 0; i < kSamples; ++i) {
    const std::uint32_t at = candidates[random.uniform(0, static_cast<int>(candidates.size()))];
    const std::size_t u = at % static_cast<std::size_t>(half.width),
                      v = at / static_cast<std::size_t>(half.width);
    const float x = half.x[u], y = half.y[v], w = half.w[at];
    s.x[i] = x;
    s.y[i] = y;
    s.w[i] = w;
    s.near[i] = half.near[at];
    s.nx[i] = half.nx[at];
    s.ny[i] = half.ny[at];
    s.nz[i] = half.nz[at];
    const float cosine = std::abs(x * s.nx[i] + y * s.ny[i] + s.nz[i]) / std::sqrt(1 + x * x + y * y);
    s.area[i] = 1 / (w * w * std::max(cosine, kGrazing));
  }
  s.whole = half.pixelArea * static_cast<double>(candidates.size()) / static_cast<double>(kSamples);
}

/// Sums the area of the samples on a plane into eight columns (that the order is the same everywhere).
ESTANCIA_MULTIVERSION
float areaOn(const Samples& s, float a, float b, float c, float length) {
  float sums[16] = {};
  for (std::size_t i = 0; i + 16 <= kSamples; i += 16)
    for (std::size_t k = 0; k < 16; ++k) {
      const std::size_t j = i + k;
      const float off = std::abs(a * s.x[j] + b * s.y[j] + c - s.w[j]);
      const float faces = a * s.nx[j] + b * s.ny[j] + c * s.nz[j];
      const bool on = (off < length * s.near[j]) & (faces > length * kFaces);
      sums[k] += on ? s.area[j] : 0.F;
    }
  float sum = 0;
  for (const float part : sums) sum += part;
  return sum;
}

struct Hypothesis {
  Coefficients plane;
  double area = 0;  ///< of all candidates on it, as far as the samples tell [m²]
};

/// The plane of the samples near this one, by least squares in 1/z, in which their noise is even; how many
/// there were, or 0 when they were too few.
int refit(const Samples& s, Coefficients& plane) {
  const auto a = static_cast<float>(plane[0]), b = static_cast<float>(plane[1]),
             c = static_cast<float>(plane[2]), length = static_cast<float>(cv::norm(plane));
  constexpr int fewest = 50;
  cv::Matx33d squares = cv::Matx33d::zeros();
  cv::Vec3d products;
  int count = 0;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const float off = std::abs(a * s.x[i] + b * s.y[i] + c - s.w[i]);
    if (!(off < length * s.near[i]) || !(a * s.nx[i] + b * s.ny[i] + c * s.nz[i] > length * kFaces)) continue;
    const cv::Vec3d row(s.x[i], s.y[i], 1);
    squares += row * row.t();
    products += row * static_cast<double>(s.w[i]);
    ++count;
  }
  Coefficients fitted;
  if (count < fewest || !cv::solve(squares, products, fitted, cv::DECOMP_CHOLESKY)) return 0;
  plane = fitted;
  return count;
}

Hypothesis bestOf(const Samples& s, cv::RNG& random) {
  Hypothesis best;
  for (int h = 0; h < kHypotheses; ++h) {
    const int i = random.uniform(0, static_cast<int>(kSamples));
    const auto k = static_cast<std::size_t>(i);
    const float along = s.nx[k] * s.x[k] + s.ny[k] * s.y[k] + s.nz[k];
    if (!(along > 0)) continue;  // seen from behind: noise
    const float scale = s.w[k] / along;
    const double area = areaOn(s, s.nx[k] * scale, s.ny[k] * scale, s.nz[k] * scale, scale) * s.whole;
    if (area > best.area) best = {{s.nx[k] * scale, s.ny[k] * scale, s.nz[k] * scale}, area};
  }
  // One pixel's normal is noisy: its plane may leave the surface, and finds to it as it takes more of it in.
  for (int round = 0, before = 0; round < kRefits && best.area > 0; ++round) {
    const int on = refit(s, best.plane);
    if (on <= before) break;
    before = on;
  }
  return best;
}

ESTANCIA_MULTIVERSION
void markOn(const float* w, const float* x, const float* near, const float* nx, const float* ny,
            const float* nz, float a, float b, float c, float y, float length, const std::uint8_t* left,
            int width, std::uint8_t* out) {
  const float constant = b * y + c;
  for (int u = 0; u < width; ++u) {
    const float off = std::abs(a * x[u] + constant - w[u]);
    const float faces = a * nx[u] + b * ny[u] + c * nz[u];
    out[u] = static_cast<std::uint8_t>(left[u] & (off < length * near[u]) & (faces > length * kFacesLoosely));
  }
}

ESTANCIA_MULTIVERSION
void takeNear(const float* w, const float* x, float a, float constant, float tolerance, int width,
              const std::uint8_t* reached, std::uint8_t* rest) {
  for (int u = 0; u < width; ++u) {
    const float off = std::abs(a * x[u] + constant - w[u]);
    const bool on = off < tolerance * std::max(w[u], 1 / w[u]);  // 1/0 is never more than…
    rest[u] = static_cast<std::uint8_t>(rest[u] & !(reached[u] & on));
  }
}

/// What each pixel of a row shows of a plane that faces (a, b, c) [m²].
ESTANCIA_MULTIVERSION
void areaRow(const float* w, const float* x, float y, float length, float pixelArea, int width, float* area) {
  for (int u = 0; u < width; ++u) {
    const float cosine = w[u] / (length * std::sqrt(1 + x[u] * x[u] + y * y));
    area[u] = pixelArea / std::max(w[u] * w[u] * std::max(cosine, kGrazing), 1e-12F);
  }
}

/// The connected patches of what lies on a plane.
struct Patches {
  cv::Mat labels;             ///< CV_32S, 0: none
  std::vector<double> areas;  ///< of them that is seen [m²]
  std::vector<double> least;  ///< of them there is [m²]: twice that where the edge of the image cuts

  std::size_t largest() const {
    return static_cast<std::size_t>(std::ranges::max_element(least) - least.begin());
  }
};

/// Of the pixels that `left` marks; marks in `on` which they are.
Patches patchesOn(const Half& half, const Coefficients& plane, const cv::Mat& left, int edge, cv::Mat& on) {
  const auto a = static_cast<float>(plane[0]), b = static_cast<float>(plane[1]),
             c = static_cast<float>(plane[2]), length = static_cast<float>(cv::norm(plane));
  on.create(half.height, half.width, CV_8U);
  for (int v = 0; v < half.height; ++v) {
    const std::size_t at = half.row(v);
    markOn(&half.w[at], half.x.data(), &half.near[at], &half.nx[at], &half.ny[at], &half.nz[at], a, b, c,
           half.y[static_cast<std::size_t>(v)], length, left.ptr(v), half.width, on.ptr(v));
  }
  Patches patches;
  cv::Mat boxes, centroids;
  const int count = cv::connectedComponentsWithStats(on, patches.labels, boxes, centroids, 8, CV_32S);
  patches.areas.resize(static_cast<std::size_t>(count));
  std::vector<float> area(static_cast<std::size_t>(half.width));
  for (int v = 0; v < half.height; ++v) {
    areaRow(&half.w[half.row(v)], half.x.data(), half.y[static_cast<std::size_t>(v)], length,
            static_cast<float>(half.pixelArea), half.width, area.data());
    const auto* label = patches.labels.ptr<int>(v);
    for (std::size_t u = 0; u < area.size(); ++u)
      if (label[u] != 0) patches.areas[static_cast<std::size_t>(label[u])] += area[u];
  }
  patches.least = patches.areas;
  for (int i = 1; i < count; ++i) {
    const int x = boxes.at<int>(i, cv::CC_STAT_LEFT), y = boxes.at<int>(i, cv::CC_STAT_TOP);
    const bool cut = x <= edge || y <= edge || x + boxes.at<int>(i, cv::CC_STAT_WIDTH) >= half.width - edge ||
                     y + boxes.at<int>(i, cv::CC_STAT_HEIGHT) >= half.height - edge;
    if (cut) patches.least[static_cast<std::size_t>(i)] *= 2;
  }
  return patches;
}

/// The plane of one patch alone, by least squares in 1/z: others near it no longer tilt it.
Coefficients planeOf(const Half& half, const Patches& patches, std::size_t patch,
                     const Coefficients& before) {
  double n = 0, x = 0, y = 0, w = 0, xx = 0, xy = 0, yy = 0, xw = 0, yw = 0;
  for (int v = 0; v < half.height; ++v) {
    const auto* label = patches.labels.ptr<int>(v);
    double rn = 0, rx = 0, rw = 0, rxx = 0, rxw = 0;
    for (std::size_t u = 0; u < half.x.size(); ++u) {
      if (static_cast<std::size_t>(label[u]) != patch) continue;
      const double hx = half.x[u], hw = half.w[half.row(v) + u];
      ++rn, rx += hx, rw += hw, rxx += hx * hx, rxw += hx * hw;
    }
    const double hy = half.y[static_cast<std::size_t>(v)];
    n += rn, x += rx, y += rn * hy, w += rw, xx += rxx, xy += rx * hy, yy += rn * hy * hy, xw += rxw,
        yw += rw * hy;
  }
  Coefficients fitted;
  return cv::solve(cv::Matx33d(xx, xy, x, xy, yy, y, x, y, n), cv::Vec3d(xw, yw, w), fitted,
                   cv::DECOMP_CHOLESKY)
             ? fitted
             : before;
}

/// Takes what is near the plane in and around its patches out of `rest`.
void take(const InverseDepth& grid, const cv::Mat& reached, const Coefficients& plane, double tolerance,
          int threads, std::vector<std::uint8_t>& rest) {
  const auto bound = static_cast<float>(tolerance * cv::norm(plane));
  const cv::Rect box = cv::boundingRect(reached);
  const int left = 2 * box.x, width = std::min(grid.camera.width, 2 * box.br().x) - left;
  const int top = 2 * box.y, height = std::min(grid.camera.height, 2 * box.br().y) - top;
  inBands(height, threads, [&](int first, int last) {
    std::vector<std::uint8_t> row(static_cast<std::size_t>(2 * box.width));
    for (int v = top + first; v < top + last; ++v) {
      const auto* half = reached.ptr<std::uint8_t>(v / 2) + box.x;
      for (std::size_t u = 0; u < row.size() / 2; ++u) row[2 * u] = row[2 * u + 1] = half[u];
      const std::size_t at = grid.at(left, v);
      const auto constant =
          static_cast<float>(plane[1] * grid.slopeY[static_cast<std::size_t>(v)] + plane[2]);
      takeNear(&grid.smooth[at], &grid.slopeX[static_cast<std::size_t>(left)], static_cast<float>(plane[0]),
               constant, bound, width, row.data(), &rest[at]);
    }
  });
}

}  // namespace

WithoutPlanes removePlanes(const InverseDepth& grid, const ClusterOptions& options) {
  std::vector<Plane> planes;
  std::vector<std::uint8_t> rest(grid.size());
  std::ranges::transform(grid.raw, rest.begin(), [](float w) { return std::uint8_t{w > 0}; });
  const Half half = halve(grid, options.planeTolerance, options.threads);
  cv::Mat left(half.height, half.width, CV_8U);  // what may still become a plane
  std::ranges::transform(half.nz, left.begin<std::uint8_t>(), [](float nz) { return std::uint8_t{nz != 0}; });
  const int reach = grid.pixels(kReach / 2);
  const cv::Mat around = cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1});
  const int edge = grid.pixels(kEdge / 2);
  cv::RNG random(options.seed);
  cv::Mat on;
  Samples samples;
  std::vector<std::uint32_t> candidates;
  for (int t = 0; t < kMostTries && planes.size() < kMostPlanes; ++t) {
    candidates.resize(half.w.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      candidates[count] = static_cast<std::uint32_t>(i);
      count += left.data[i];
    }
    candidates.resize(count);
    if (candidates.empty()) break;
    draw(half, candidates, random, samples);
    auto [plane, area] = bestOf(samples, random);
    if (area < kHopeful * options.planeArea) break;  // nor is there any larger
    Patches patches = patchesOn(half, plane, left, edge, on);
    if (patches.least[patches.largest()] >= options.planeArea) {
      plane = planeOf(half, patches, patches.largest(), plane);
      patches = patchesOn(half, plane, left, edge, on);
    }
    left -= on;  // a plane that is none, after all, is set aside: others may still be there
    if (patches.least[patches.largest()] < options.planeArea) continue;
    double seen = 0;
    std::vector<std::uint8_t> large(patches.areas.size());
    for (std::size_t i = 1; i < large.size(); ++i) {
      large[i] = patches.least[i] >= options.planeArea / 2;
      seen += large[i] != 0 ? patches.areas[i] : 0;
    }
    for (int v = 0; v < half.height; ++v) {
      const auto* label = patches.labels.ptr<int>(v);
      for (int u = 0; u < half.width; ++u) on.ptr(v)[u] = large[static_cast<std::size_t>(label[u])];
    }
    cv::dilate(on, on, around);
    take(grid, on, plane, options.planeTolerance, options.threads, rest);
    left.setTo(0, on & (left > 0));
    const double norm = cv::norm(plane);
    planes.push_back({-plane / norm, -1 / norm, seen});
  }
  return {std::move(planes), Mask(grid, std::move(rest))};
}

}  // namespace estancia
