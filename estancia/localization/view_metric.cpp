// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/view_metric.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "estancia/distances/distance.hpp"

namespace estancia {
namespace {

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using MutableRows = Eigen::Map<RowMajor>;
using ConstRows = Eigen::Map<const RowMajor>;

constexpr double farthest = 3;            // standard deviations; weights beyond, below .011, are 0
constexpr std::size_t maxNeighbors = 32;  // neighbors of one image: if there are more, evenly taken ones
constexpr double wayOfOneView = 0.25;     // standard deviation, in distances of unrelated images
constexpr double alike = 0.75;            // × that distance: images that differ more show different things
constexpr std::size_t maxResiduals = 500;
constexpr double least = 0.02;  // × σ²: directions of less variance would change lengths by less than 1 %

struct Images {
  std::span<const float> values;
  std::size_t count, labels;

  std::span<const float> row(std::size_t i) const { return values.subspan(i * labels, labels); }
  double distance(std::size_t a, std::size_t b) const { return 1 - dot(row(a), row(b)); }
  /// Mean distance of images half a drive apart.
  double unrelated() const {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += distance(i, (i + count / 2) % count);
    return std::max(0.0, sum / static_cast<double>(count));
  }
};

using Neighbors = std::vector<Neighborhoods::Neighbor>;

float weightAt(double deviations) {
  return static_cast<float>(std::exp(-0.5 * deviations * deviations));
}

/// Every so many of them, counted from the image itself.
template <class At>
std::vector<std::size_t> evenly(std::size_t count, std::size_t own, const At& at) {
  const std::size_t stride = (count + maxNeighbors - 1) / maxNeighbors;
  std::vector<std::size_t> taken;
  for (std::size_t k = own % stride; k < count; k += stride) taken.push_back(at(k));
  return taken;
}

/// Neighbors along the drive: the way is the sum of the distances of images that follow each other.
std::vector<Neighbors> alongTheWay(const Images& images, double unrelated) {
  std::vector<double> driven(images.count);
  for (std::size_t i = 1; i < images.count; ++i)
    driven[i] = driven[i - 1] + std::max(0.0, images.distance(i - 1, i));
  const double sigma = std::max(wayOfOneView * unrelated, 1e-9);
  std::vector<Neighbors> all(images.count);
  for (std::size_t i = 0; i < images.count; ++i) {
    const auto first = std::lower_bound(driven.begin(), driven.end(), driven[i] - farthest * sigma);
    const auto last = std::upper_bound(first, driven.end(), driven[i] + farthest * sigma);
    const auto from = static_cast<std::size_t>(first - driven.begin());
    for (const std::size_t j :
         evenly(static_cast<std::size_t>(last - first), i - from, [from](std::size_t k) { return from + k; }))
      all[i].push_back({static_cast<std::uint32_t>(j), weightAt((driven[j] - driven[i]) / sigma)});
  }
  return all;
}

/// The distance of two poses, in standard deviations.
double deviations(const Pose& a, const Pose& b, const Neighborhoods::Reach& reach) {
  const auto f = a.forward(), g = b.forward();
  const double cosine = std::inner_product(f.begin(), f.end(), g.begin(), 0.0);
  const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
  return std::hypot(distanceBetween(a, b) / reach.distance, angle / reach.angle);
}

/// For each image, the images that were taken near it according to the poses; at least itself.
std::vector<std::vector<std::size_t>> nearInSpace(std::span<const std::optional<Pose>> poses,
                                                  const Neighborhoods::Reach& reach) {
  std::vector<std::size_t> byX;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (poses[i]) byX.push_back(i);
  std::ranges::stable_sort(byX, {}, [&](std::size_t i) { return poses[i]->x; });
  std::vector<std::vector<std::size_t>> all(poses.size());
  std::size_t first = 0;
  for (const std::size_t i : byX) {
    while (poses[byX[first]]->x < poses[i]->x - farthest * reach.distance) ++first;
    std::vector<std::size_t>& near = all[i];
    for (std::size_t k = first; k < byX.size(); ++k) {
      const Pose& other = *poses[byX[k]];
      if (other.x > poses[i]->x + farthest * reach.distance) break;
      // Most are too far away for their angle to matter, which takes longer.
      if (byX[k] == i || (distanceBetween(*poses[i], other) <= farthest * reach.distance &&
                          deviations(*poses[i], other, reach) <= farthest))
        near.push_back(byX[k]);
    }
    std::ranges::sort(near);
    const auto own = static_cast<std::size_t>(std::ranges::lower_bound(near, i) - near.begin());
    near = evenly(near.size(), own, [&near](std::size_t k) { return near[k]; });
  }
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (!poses[i]) all[i] = {i};
  return all;
}

/// Neighbors by poses; none at all where these do not look alike, as with poses of another drive.
std::optional<std::vector<Neighbors>> byPoses(const Images& images,
                                              std::span<const std::optional<Pose>> poses,
                                              const Neighborhoods::Reach& reach, double unrelated) {
  const auto near = nearInSpace(poses, reach);
  std::vector<Neighbors> all(images.count);
  double weights = 0, different = 0;
  for (std::size_t i = 0; i < images.count; ++i)
    for (const std::size_t j : near[i]) {
      const float weight = i == j ? 1 : weightAt(deviations(*poses[i], *poses[j], reach));
      const double distance = i == j ? 0 : images.distance(i, j);
      if (i != j) weights += weight;
      different += weight * distance;
      if (i == j || distance <= alike * unrelated) all[i].push_back({static_cast<std::uint32_t>(j), weight});
    }
  if (different > alike * unrelated * weights) return std::nullopt;
  return all;
}

}  // namespace

Neighborhoods::Neighborhoods(std::span<const float> values, std::span<const std::optional<Pose>> poses,
                             const Reach& reach) {
  const Images images{values, poses.size(), poses.empty() ? 0 : values.size() / poses.size()};
  const double unrelated = images.unrelated();
  const auto posed = std::ranges::count_if(poses, [](const auto& pose) { return pose.has_value(); });
  std::optional<std::vector<Neighbors>> all;
  if (2 * static_cast<std::size_t>(posed) >= poses.size()) all = byPoses(images, poses, reach, unrelated);
  if (!all) all = alongTheWay(images, unrelated);
  for (const Neighbors& neighbors : *all) {
    float sum = 0;
    for (const Neighbor& neighbor : neighbors) sum += neighbor.weight;
    for (const Neighbor& neighbor : neighbors) neighbors_.push_back({neighbor.image, neighbor.weight / sum});
    first_.push_back(neighbors_.size());
  }
}

std::vector<float> Neighborhoods::mean(std::span<const float> images, std::size_t image) const {
  const std::size_t labels = images.size() / size();
  std::vector<float> result(labels);
  for (const Neighbor& neighbor : of(image))
    for (std::size_t l = 0; l < labels; ++l)
      result[l] += neighbor.weight * images[neighbor.image * labels + l];
  return result;
}

ViewMetric::ViewMetric(std::span<const float> images, const Neighborhoods& around)
    : labels_(images.size() / around.size()) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < around.size(); ++i)
    if (around.of(i).size() > 1) chosen.push_back(i);
  const std::size_t stride = (chosen.size() + maxResiduals - 1) / maxResiduals;
  std::vector<float> residuals;
  for (std::size_t k = 0; k < chosen.size(); k += stride) {
    const std::vector<float> mean = around.mean(images, chosen[k]);
    for (std::size_t l = 0; l < labels_; ++l) residuals.push_back(images[chosen[k] * labels_ + l] - mean[l]);
  }
  const auto count = static_cast<Eigen::Index>(residuals.size() / labels_);
  const ConstRows e(residuals.data(), count, static_cast<Eigen::Index>(labels_));
  // The directions of Σ = EᵀE / n, of which L×L are many, from the eigenvectors of EEᵀ / n.
  const Eigen::MatrixXd products = (e * e.transpose()).cast<double>() / static_cast<double>(count);
  const double typical = count > 0 ? products.squaredNorm() / products.trace() : 0;
  if (!(typical > 0)) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved(products);
  for (Eigen::Index k = count; k-- > 0;) {
    const double variance = solved.eigenvalues()[k];
    if (variance < least * typical) break;
    const Eigen::VectorXf direction =
        (e.transpose() * solved.eigenvectors().col(k).cast<float>()).normalized();
    directions_.insert(directions_.end(), direction.begin(), direction.end());
    changes_.push_back(static_cast<float>(1 / std::sqrt(1 + variance / typical) - 1));
  }
}

void ViewMetric::apply(std::span<float> values) const {
  constexpr Eigen::Index block = 256;  // rows; bounds the memory
  const auto labels = static_cast<Eigen::Index>(labels_);
  const auto kept = static_cast<Eigen::Index>(changes_.size());
  if (kept == 0) return;
  MutableRows rows(values.data(), static_cast<Eigen::Index>(values.size()) / labels, labels);
  const ConstRows directions(directions_.data(), kept, labels);
  const Eigen::Map<const Eigen::VectorXf> changes(changes_.data(), kept);
  for (Eigen::Index first = 0; first < rows.rows(); first += block) {
    auto some = rows.middleRows(first, std::min(block, rows.rows() - first));
    const RowMajor along = some * directions.transpose() * changes.asDiagonal();
    some += along * directions;
    some.rowwise().normalize();
  }
}

}  // namespace estancia
