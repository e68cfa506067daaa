// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/drive_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estancia/core/bytes.hpp"
#include "estancia/core/rigid.hpp"

namespace estancia {
namespace {

constexpr std::size_t mostPairs = 256, fewestAgreeing = 5;
constexpr double newShare = 0.25;  // of what is near: a step that shows something else

}  // namespace

DriveAlignment::DriveAlignment(double nearDistance, double nearAngle)
    : nearDistance_(nearDistance), nearAngle_(nearAngle * std::numbers::pi / 180) {}

bool DriveAlignment::add(const Pose& own, const Pose& inMap) {
  const Pair pair{rigidOf(own), rigidOf(inMap)};
  if (!pairs_.empty()) {
    const cv::Affine3d step = pairs_.back().own.inv() * pair.own;
    if (cv::norm(step.translation()) < newShare * nearDistance_ && angleOf(step) < newShare * nearAngle_)
      return false;
  }
  if (pairs_.size() == mostPairs) pairs_.erase(pairs_.begin());
  pairs_.push_back(pair);
  ++taken_;
  return true;
}

std::string DriveAlignment::state(std::size_t next) const {
  ByteWriter out;
  out.number<std::uint64_t>(next);
  out.number<std::uint64_t>(taken_);
  out.number<std::uint64_t>(pairs_.size());
  for (const Pair& pair : pairs_)
    for (const cv::Affine3d& transform : {pair.own, pair.inMap})
      for (const double value : transform.matrix.val) out.number(value);
  return out.bytes();
}

std::size_t DriveAlignment::restore(const std::string& state) {
  ByteReader in(state, "the saved alignment of the last drive is damaged", "map the sequence again");
  const std::size_t next = in.number<std::uint64_t>();
  taken_ = in.number<std::uint64_t>();
  pairs_.clear();
  for (std::size_t count = in.count(32 * sizeof(double)); count > 0; --count) {
    Pair& pair = pairs_.emplace_back();
    for (cv::Affine3d* transform : {&pair.own, &pair.inMap})
      for (double& value : transform->matrix.val)
        if (value = in.number<double>(); !std::isfinite(value))
          in.fail("a number is not finite", ErrorCode::corruptFile);
  }
  if (in.remaining() > 0) in.fail("it is too long", ErrorCode::corruptFile);
  return next;
}

bool DriveAlignment::agrees(const cv::Affine3d& transform, const Pair& pair) const {
  const cv::Affine3d apart = pair.inMap.inv() * transform * pair.own;
  return cv::norm(apart.translation()) <= nearDistance_ && angleOf(apart) <= nearAngle_;
}

/// Least squares over positions, and over directions as points `lever` ahead, above and beside (Kabsch 1976):
/// a near distance weighs as much as a near angle.
cv::Affine3d DriveAlignment::fit(const std::vector<const Pair*>& pairs) const {
  const double lever = nearDistance_ / nearAngle_;
  cv::Vec3d ownMean, mapMean;
  for (const Pair* pair : pairs) {
    ownMean += pair->own.translation();
    mapMean += pair->inMap.translation();
  }
  ownMean *= 1.0 / static_cast<double>(pairs.size());
  mapMean *= 1.0 / static_cast<double>(pairs.size());
  cv::Matx33d covariance = cv::Matx33d::zeros();
  for (const Pair* pair : pairs) {
    const cv::Vec3d q = pair->inMap.translation() - mapMean, p = pair->own.translation() - ownMean;
    covariance += q * p.t() + lever * lever * (pair->inMap.rotation() * pair->own.rotation().t());
  }
  cv::Matx31d w;
  cv::Matx33d u, vt;
  cv::SVD::compute(covariance, w, u, vt);
  const cv::Matx33d mirror = cv::Matx33d::diag(cv::Vec3d(1, 1, cv::determinant(u * vt) < 0 ? -1 : 1));
  const cv::Matx33d rotation = u * mirror * vt;
  return {rotation, mapMean - rotation * ownMean};
}

std::optional<DriveAlignment::Estimate> DriveAlignment::estimate() const {
  std::vector<const Pair*> best;
  const auto agreeing = [this](const cv::Affine3d& transform) {
    std::vector<const Pair*> found;
    for (const Pair& pair : pairs_)
      if (agrees(transform, pair)) found.push_back(&pair);
    return found;
  };
  for (const Pair& pair : pairs_)
    if (auto found = agreeing(pair.inMap * pair.own.inv()); found.size() > best.size())
      best = std::move(found);
  if (best.size() < fewestAgreeing) return std::nullopt;
  cv::Affine3d transform = fit(best);
  for (int round = 0; round < 3; ++round) {
    auto found = agreeing(transform);
    if (found.size() < fewestAgreeing || found == best) break;
    best = std::move(found);
    transform = fit(best);
  }
  if (best.size() < fewestAgreeing || 2 * best.size() < pairs_.size()) return std::nullopt;
  double extent = 0;
  for (const Pair* a : best)
    for (const Pair* b : best)
      extent = std::max(extent, cv::norm(a->own.translation() - b->own.translation()));
  return Estimate{transform, best.size(), extent};
}

}  // namespace estancia
