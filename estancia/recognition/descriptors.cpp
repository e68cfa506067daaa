// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/descriptors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "estancia/core/fail.hpp"
#include "estancia/core/simd.hpp"
#include "estancia/stats/products.hpp"

namespace estancia {
namespace {

struct Method {
  const char *name, *explanation;
  std::size_t length;
};
constexpr Method methods[] = {
    {"shot", "signatures of histograms of normals in a local frame, 352 numbers", 352},
    {"shot-color", "shot, and histograms of color differences, 1344 numbers; needs colors", 1344},
    {"fpfh", "fast point feature histograms: angles between normals, 33 numbers", 33},
    {"spin-image", "distances and heights of points around the normal, 153 numbers", 153},
};

constexpr int spinWidth = 8, spinRows = spinWidth + 1, spinColumns = 2 * spinWidth + 1;
constexpr int spinLength = spinRows * spinColumns;
constexpr float supportCosine = 0.5F;

/// Cylindrical coordinates of the neighbors around the normal: distance from it, and height. Each point is
/// interpolated between four cells.
void spin(const Surface& surface, std::uint32_t keypoint, float radius, std::vector<Neighbor>& buffer,
          float* image) {
  constexpr std::size_t minNeighbors = 5;
  const cv::Point3f &p = surface.points()[keypoint], &axis = surface.normals()[keypoint];
  const auto near = surface.neighbors().within(p, radius, buffer);
  if (near.size() < minNeighbors) {
    std::fill_n(image, spinLength, std::numeric_limits<float>::quiet_NaN());
    return;
  }
  // The cylinder that fits into the ball is as high as it is wide.
  const float cell = radius / spinWidth / std::sqrt(2.F), edge = cell * spinWidth;
  std::array<double, spinLength> sums{};
  double total = 0;
  for (const Neighbor& n : near) {
    if (n.squared == 0 || std::abs(axis.dot(surface.normals()[n.index])) < supportCosine) continue;
    const float height = axis.dot(surface.points()[n.index] - p);
    const float away = std::sqrt(std::max(n.squared - height * height, 0.F));
    if (std::abs(height) >= edge || away >= edge) continue;
    const float column = height / cell + spinWidth, row = away / cell;
    const int c = std::min(static_cast<int>(column), spinColumns - 2),
              r = std::min(static_cast<int>(row), spinRows - 2);
    const double b = column - static_cast<float>(c), a = row - static_cast<float>(r);
    double* const at = sums.data() + r * spinColumns + c;
    at[0] += (1 - a) * (1 - b);
    at[spinColumns] += a * (1 - b);
    at[1] += (1 - a) * b;
    at[spinColumns + 1] += a * b;
    total += 1;
  }
  for (int i = 0; i < spinLength; ++i)
    image[i] = total > 0 ? static_cast<float>(sums[static_cast<std::size_t>(i)] / total) : 0;
}

float squaredDistance(DescriptorView a, DescriptorView b) {
  float sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

/// |b|² − 2 a·b of all b, which orders them by their distance to a, from the products a·b.
ESTANCIA_MULTIVERSION void toSquared(const float* __restrict norms, float* __restrict products,
                                     std::size_t count) {
#pragma omp simd
  for (std::size_t j = 0; j < count; ++j) products[j] = norms[j] - 2 * products[j];
}

ESTANCIA_MULTIVERSION bool anyBelow(const float* values, std::size_t count, float limit) {
  int below = 0;
#pragma omp simd reduction(| : below)
  for (std::size_t j = 0; j < count; ++j) below |= values[j] < limit ? 1 : 0;
  return below != 0;
}

}  // namespace

Choices descriptorMethods() {
  Choices choices;
  for (const Method& m : methods) choices.push_back({m.name, m.explanation});
  return choices;
}

void SurfaceFeatures::append(const SurfaceFeatures& others) {
  const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  add(keypoints, others.keypoints);
  add(points, others.points);
  add(normals, others.normals);
  add(frames, others.frames);
  descriptors.reserve(size());
  for (std::size_t i = 0; i < others.size(); ++i) descriptors.append(others.descriptors.row(i));
}

SurfaceFeatures describe(const Surface& surface, std::span<const std::uint32_t> keypoints,
                         const std::string& method, double radius, int threads, FrameSigns signs) {
  requireChoice("surface descriptor", method, descriptorMethods());
  const std::size_t length = std::ranges::find(methods, method, &Method::name)->length;
  requireRadius(surface.name(), surface.points(), surface.neighbors(), radius, "descriptor radius");
  const bool colored = method == "shot-color";
  if (colored && surface.lab().empty())
    fail(ErrorCode::invalidInput, "{}: the cloud has no colors, which shot-color describes; use shot",
         surface.name());
  const std::vector<cv::Matx33f> frames = localFrames(surface, keypoints, radius, threads, signs);
  std::vector<float> values;
  if (method == "shot" || colored)
    describeShot(surface, keypoints, frames, radius, colored, threads, values);
  else if (method == "fpfh")
    describeFpfh(surface, keypoints, radius, threads, values);
  else
    describeSpinImage(surface, keypoints, radius, threads, values);

  SurfaceFeatures features;
  features.descriptors = DescriptorMatrix(length);
  features.descriptors.reserve(keypoints.size());
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const DescriptorView row(values.data() + i * length, length);
    float sum = frames[i](0, 0);
    for (const float v : row) sum += v;
    if (!std::isfinite(sum)) continue;
    features.descriptors.append(row);
    features.frames.push_back(frames[i]);
    features.keypoints.push_back(keypoints[i]);
    features.points.push_back(surface.points()[keypoints[i]]);
    features.normals.push_back(surface.normals()[keypoints[i]]);
  }
  return features;
}

void describeSpinImage(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius,
                       int threads, std::vector<float>& values) {
  values.resize(keypoints.size() * spinLength);
  inChunks(keypoints.size(), 32, threads, "stopped while a surface was described",
           [&](std::size_t first, std::size_t last) {
             std::vector<Neighbor> buffer;
             for (std::size_t i = first; i < last; ++i)
               spin(surface, keypoints[i], static_cast<float>(radius), buffer,
                    values.data() + i * spinLength);
           });
}

std::vector<std::vector<NearRow>> nearestRows(const DescriptorMatrix& rows, const DescriptorMatrix& others,
                                              std::size_t count, int threads) {
  std::vector<std::vector<NearRow>> found(rows.size());
  count = std::min(count, others.size());
  if (count == 0) return found;
  // A few more than needed, because rounding of the product may swap near rows; the exact distance decides.
  const std::size_t kept = std::min(count + 3, others.size());
  const std::vector<float> norms = squaredNorms(others);
  rowProducts(rows, PackedRows(others), threads, [&](std::size_t i, std::span<float> products) {
    std::vector<NearRow>& best = found[i];
    best.reserve(kept + 1);
    toSquared(norms.data(), products.data(), products.size());
    constexpr std::size_t together = 64;  // are mostly all farther
    for (std::size_t first = 0; first < products.size(); first += together) {
      const std::size_t last = std::min(first + together, products.size());
      if (best.size() == kept && !anyBelow(&products[first], last - first, best.back().squared)) continue;
      for (std::size_t j = first; j < last; ++j) {
        const float squared = products[j];
        if (best.size() == kept && !(squared < best.back().squared)) continue;
        const auto after = std::upper_bound(best.begin(), best.end(), squared,
                                            [](float s, const NearRow& n) { return s < n.squared; });
        best.insert(after, {static_cast<std::uint32_t>(j), squared});
        if (best.size() > kept) best.pop_back();
      }
    }
    for (NearRow& n : best) n.squared = squaredDistance(rows.row(i), others.row(n.other));
    std::sort(best.begin(), best.end(), [](const NearRow& a, const NearRow& b) {
      return a.squared < b.squared || (a.squared == b.squared && a.other < b.other);
    });
    best.resize(count);
  });
  return found;
}

std::vector<Match> matchDescriptors(const DescriptorMatrix& model, const DescriptorMatrix& scene,
                                    MatchEach each, std::size_t count, double distance, int threads) {
  const bool fromScene = each == MatchEach::scene;
  const auto found =
      fromScene ? nearestRows(scene, model, count, threads) : nearestRows(model, scene, count, threads);
  std::vector<Match> matches;
  for (std::uint32_t i = 0; i < found.size(); ++i)
    for (const NearRow& n : found[i])
      matches.push_back(fromScene ? Match{n.other, i, n.squared} : Match{i, n.other, n.squared});
  if (distance > 0) {
    const std::vector<float> norms = squaredNorms(scene);
    const auto share = static_cast<float>(distance * distance);
    std::erase_if(matches, [&](const Match& m) { return m.squared > share * norms[m.scene]; });
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& a, const Match& b) { return a.squared < b.squared; });
  return matches;
}

}  // namespace estancia
