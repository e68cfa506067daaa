// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/segmentation_stages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::size_t maxSamples = 3000;
constexpr int hypotheses = 150, refits = 10, maxPlanes = 8, maxTries = 16;
constexpr float minCosine = 0.94F;    // cosine between normals of samples and their plane's: 20°
constexpr float facesLoosely = 0.9F;  // 25°
constexpr float grazing = 0.1F;       // cosine below which the area of a pixel is unreliable
constexpr float farther = 0.5F;       // growth of the tolerance with the square of depth, beyond 1.4 m
constexpr double sampleSlack = 0.7;   // share of minPlaneArea: the estimate from samples may be too small
constexpr double imageMargin = 10;    // margin in which cameras often measure no depth [pixels]
constexpr double maxReach = 4;        // pixels of the plane beyond its patches that it takes [pixels]

/// Adds the slope of 1/z between two opposite neighbors where both are on the same surface.
ESTANCIA_MULTIVERSION
void addSlope(const float* middle, const float* a, const float* b, float weight, int width, float* sum,
              float* count) {
  constexpr float sameSurfaceShare = 0.06F;
  for (int u = 0; u < width; ++u) {
    const float c = middle[u];
    const bool surface = std::max(std::abs(a[u] - c), std::abs(b[u] - c)) < sameSurfaceShare * c;
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

/// `tolerance` [m at 1 m] is the distance within which a pixel lies on a plane.
HalfImage halve(const InverseDepth& grid, double tolerance, int threads) {
  HalfImage half;
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
            w[2 * u] > 0 ? static_cast<float>(tolerance) * std::max(w[2 * u], farther / w[2 * u]) : 0;
      }
    }
  });
  return half;
}

using Coefficients = cv::Vec3d;  // w = a x + b y + c over the slopes x, y

/// Samples by coordinate, for SIMD.
struct Samples {
  std::array<float, maxSamples> x, y, w, near, nx, ny, nz, area;
  double scale = 0;  ///< area of samples → area of all candidates [m²]
};

void draw(const HalfImage& half, const std::vector<std::uint32_t>& candidates, cv::RNG& random, Samples& s) {
  for (std::size_t i = 0; i < maxSamples; ++i) {
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
    s.area[i] = 1 / (w * w * std::max(cosine, grazing));
  }
  s.scale = half.pixelArea * static_cast<double>(candidates.size()) / static_cast<double>(maxSamples);
}

/// The votes of a hypothesis: the area of the samples on it, summed in 16 columns so that the order is the
/// same everywhere.
ESTANCIA_MULTIVERSION
float areaOn(const Samples& s, float a, float b, float c, float length) {
  float sums[16] = {};
  for (std::size_t i = 0; i + 16 <= maxSamples; i += 16)
    for (std::size_t k = 0; k < 16; ++k) {
      const std::size_t j = i + k;
      const float off = std::abs(a * s.x[j] + b * s.y[j] + c - s.w[j]);
      const float faces = a * s.nx[j] + b * s.ny[j] + c * s.nz[j];
      const bool on = (off < length * s.near[j]) & (faces > length * minCosine);
      sums[k] += on ? s.area[j] : 0.F;
    }
  float sum = 0;
  for (const float part : sums) sum += part;
  return sum;
}

struct Hypothesis {
  Coefficients plane;
  double area = 0;  ///< area of all candidates on it, estimated from the samples [m²]
};

/// Fits the plane to the samples on it by least squares in 1/z, where noise is uniform. Returns the number of
/// samples on it, or 0 when they are too few.
int refit(const Samples& s, Coefficients& plane) {
  const auto a = static_cast<float>(plane[0]), b = static_cast<float>(plane[1]),
             c = static_cast<float>(plane[2]), length = static_cast<float>(cv::norm(plane));
  constexpr int minPoints = 50;
  cv::Matx33d squares = cv::Matx33d::zeros();
  cv::Vec3d products;
  int count = 0;
  for (std::size_t i = 0; i < maxSamples; ++i) {
    const float off = std::abs(a * s.x[i] + b * s.y[i] + c - s.w[i]);
    if (!(off < length * s.near[i]) || !(a * s.nx[i] + b * s.ny[i] + c * s.nz[i] > length * minCosine))
      continue;
    const cv::Vec3d row(s.x[i], s.y[i], 1);
    squares += row * row.t();
    products += row * static_cast<double>(s.w[i]);
    ++count;
  }
  Coefficients fitted;
  if (count < minPoints || !cv::solve(squares, products, fitted, cv::DECOMP_CHOLESKY)) return 0;
  plane = fitted;
  return count;
}

Hypothesis bestHypothesis(const Samples& s, cv::RNG& random) {
  Hypothesis best;
  for (int h = 0; h < hypotheses; ++h) {
    const int i = random.uniform(0, static_cast<int>(maxSamples));
    const auto k = static_cast<std::size_t>(i);
    const float along = s.nx[k] * s.x[k] + s.ny[k] * s.y[k] + s.nz[k];
    if (!(along > 0)) continue;  // seen from behind: noise
    const float scale = s.w[k] / along;
    const double area = areaOn(s, s.nx[k] * scale, s.ny[k] * scale, s.nz[k] * scale, scale) * s.scale;
    if (area > best.area) best = {{s.nx[k] * scale, s.ny[k] * scale, s.nz[k] * scale}, area};
  }
  // The normal of one pixel is noisy: refit while the plane gains samples.
  for (int round = 0, before = 0; round < refits && best.area > 0; ++round) {
    const int on = refit(s, best.plane);
    if (on <= before) break;
    before = on;
  }
  return best;
}

ESTANCIA_MULTIVERSION
void markOn(const float* w, const float* x, const float* near, const float* nx, const float* ny,
            const float* nz, float a, float b, float c, float y, float length, const std::uint8_t* candidates,
            int width, std::uint8_t* out) {
  const float constant = b * y + c;
  for (int u = 0; u < width; ++u) {
    const float off = std::abs(a * x[u] + constant - w[u]);
    const float faces = a * nx[u] + b * ny[u] + c * nz[u];
    out[u] =
        static_cast<std::uint8_t>(candidates[u] & (off < length * near[u]) & (faces > length * facesLoosely));
  }
}

ESTANCIA_MULTIVERSION
void takeNear(const float* w, const float* x, float a, float constant, float tolerance, int width,
              const std::uint8_t* reached, std::uint8_t number, std::uint8_t* rest, std::uint8_t* of) {
  for (int u = 0; u < width; ++u) {
    const float off = std::abs(a * x[u] + constant - w[u]);
    const bool on =
        off < tolerance * std::max(w[u], farther / w[u]);  // true where w is 0, which `rest` does not have
    const bool taken = (rest[u] & reached[u] & static_cast<std::uint8_t>(on)) != 0;
    of[u] = taken ? number : of[u];
    rest[u] = static_cast<std::uint8_t>(rest[u] & !taken);
  }
}

/// The area of a plane that each pixel of a row covers [m²].
ESTANCIA_MULTIVERSION
void areaRow(const float* w, const float* x, float y, float length, float pixelArea, int width, float* area) {
  for (int u = 0; u < width; ++u) {
    const float cosine = w[u] / (length * std::sqrt(1 + x[u] * x[u] + y * y));
    area[u] = pixelArea / std::max(w[u] * w[u] * std::max(cosine, grazing), 1e-12F);
  }
}

/// The connected components of the pixels on a plane.
struct Patches {
  cv::Mat labels;             ///< CV_32S, 0: none
  std::vector<double> areas;  ///< visible [m²]
  std::vector<double> whole;  ///< estimated [m²]: twice the visible area at the edge of the image

  std::size_t largest() const {
    return static_cast<std::size_t>(std::ranges::max_element(whole) - whole.begin());
  }
};

/// Searches the pixels that `candidates` marks; marks the pixels of patches in `on`.
Patches patchesOn(const HalfImage& half, const Coefficients& plane, const cv::Mat& candidates, int edge,
                  cv::Mat& on) {
  const auto a = static_cast<float>(plane[0]), b = static_cast<float>(plane[1]),
             c = static_cast<float>(plane[2]), length = static_cast<float>(cv::norm(plane));
  on.create(half.height, half.width, CV_8U);
  for (int v = 0; v < half.height; ++v) {
    const std::size_t at = half.row(v);
    markOn(&half.w[at], half.x.data(), &half.near[at], &half.nx[at], &half.ny[at], &half.nz[at], a, b, c,
           half.y[static_cast<std::size_t>(v)], length, candidates.ptr(v), half.width, on.ptr(v));
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
  patches.whole = patches.areas;
  for (int i = 1; i < count; ++i) {
    const int x = boxes.at<int>(i, cv::CC_STAT_LEFT), y = boxes.at<int>(i, cv::CC_STAT_TOP);
    const bool cut = x <= edge || y <= edge || x + boxes.at<int>(i, cv::CC_STAT_WIDTH) >= half.width - edge ||
                     y + boxes.at<int>(i, cv::CC_STAT_HEIGHT) >= half.height - edge;
    if (cut) patches.whole[static_cast<std::size_t>(i)] *= 2;
  }
  return patches;
}

/// Fits the plane to one patch by least squares in 1/z.
Coefficients fitToPatch(const HalfImage& half, const Patches& patches, std::size_t patch,
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

/// Clears the pixels near the plane in `rest`, where `reached` marks its patches and their surroundings.
void clearPlane(const InverseDepth& grid, const cv::Mat& reached, const Coefficients& plane, double tolerance,
                int threads, std::uint8_t number, std::vector<std::uint8_t>& rest,
                std::vector<std::uint8_t>& of) {
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
               constant, bound, width, row.data(), number, &rest[at], &of[at]);
    }
  });
}

/// The indices of the marked pixels.
void listMarked(const cv::Mat& marks, std::vector<std::uint32_t>& indices) {
  indices.resize(marks.total());
  std::size_t count = 0;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    indices[count] = static_cast<std::uint32_t>(i);
    count += marks.data[i];
  }
  indices.resize(count);
}

/// Marks the patches of at least `minArea` in `on`. Returns their visible area.
double markLargePatches(const Patches& patches, double minArea, cv::Mat& on) {
  double area = 0;
  std::vector<std::uint8_t> large(patches.areas.size());
  for (std::size_t i = 1; i < large.size(); ++i) {
    large[i] = patches.whole[i] >= minArea;
    area += large[i] != 0 ? patches.areas[i] : 0;
  }
  for (int v = 0; v < on.rows; ++v) {
    const auto* label = patches.labels.ptr<int>(v);
    for (int u = 0; u < on.cols; ++u) on.ptr(v)[u] = large[static_cast<std::size_t>(label[u])];
  }
  return area;
}

}  // namespace

// Sequential RANSAC (Fischler and Bolles, CACM 1981):
//   repeat
//     samples := random candidates, the pixels with a normal that lie on no plane yet
//     for some of the samples:
//       hypothesis := the plane through the sample with its normal
//       votes      := area of all samples on the hypothesis that face as it does
//     plane := the best hypothesis, refitted while it gains samples; stop if it is clearly too small
//     patches := connected candidates on the plane; refit it to the largest patch
//     the candidates on the plane are candidates no longer
//     if the largest patch is large enough, keep the plane and remove all pixels near its large patches
PlaneRemoval removePlanes(const InverseDepth& grid, const ClusterOptions& options) {
  std::vector<Plane> planes;
  std::vector<std::uint8_t> rest(grid.size());
  std::ranges::transform(grid.raw, rest.begin(), [](float w) { return std::uint8_t{w > 0}; });
  std::vector<std::uint8_t> of(grid.size());
  HalfImage half = halve(grid, options.planeTolerance, options.threads);
  cv::Mat candidates(half.height, half.width, CV_8U);
  std::ranges::transform(half.nz, candidates.begin<std::uint8_t>(),
                         [](float nz) { return std::uint8_t{nz != 0}; });
  const int reach = grid.pixels(maxReach / 2), edge = grid.pixels(imageMargin / 2);
  const cv::Mat around = cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1});
  cv::RNG random(options.seed);
  cv::Mat on;
  Samples samples;
  std::vector<std::uint32_t> indices;
  for (int t = 0; t < maxTries && planes.size() < maxPlanes; ++t) {
    listMarked(candidates, indices);
    if (indices.empty()) break;
    draw(half, indices, random, samples);
    auto [plane, area] = bestHypothesis(samples, random);
    if (area < sampleSlack * options.minPlaneArea) break;
    Patches patches = patchesOn(half, plane, candidates, edge, on);
    if (patches.whole[patches.largest()] >= options.minPlaneArea) {
      plane = fitToPatch(half, patches, patches.largest(), plane);
      patches = patchesOn(half, plane, candidates, edge, on);
    }
    candidates -= on;
    if (patches.whole[patches.largest()] < options.minPlaneArea) continue;
    const double visible = markLargePatches(patches, options.minPlaneArea / 2, on);
    cv::dilate(on, on, around);
    clearPlane(grid, on, plane, options.planeTolerance, options.threads,
               static_cast<std::uint8_t>(planes.size() + 1), rest, of);
    candidates.setTo(0, on & (candidates > 0));
    const double norm = cv::norm(plane);
    planes.push_back({-plane / norm, -1 / norm, visible});
  }
  return {std::move(planes), std::move(of), Mask(grid, std::move(rest)), std::move(half)};
}

}  // namespace estancia
