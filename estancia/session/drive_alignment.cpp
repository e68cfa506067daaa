// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/drive_alignment.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "estancia/core/bytes.hpp"

namespace estancia {
namespace {

constexpr std::size_t maxPairs = 256, minAgreeing = 5;
constexpr double newShare = 0.25;  // share of nearby area that is new: a step that shows something else

constexpr std::size_t enoughAgreeing = 8;
/// [m]: further than a room is long. What looks alike in another room agrees as well over a shorter way, and
/// the direction is wrong by 10°.
constexpr double enoughExtent = 4;

}  // namespace

bool DriveAlignment::Estimate::isCertain() const {
  return agreeing >= enoughAgreeing && extent >= enoughExtent;
}

DriveAlignment::DriveAlignment(double nearDistance, double nearAngle)
    : nearDistance_(nearDistance), nearAngle_(nearAngle * std::numbers::pi / 180) {}

bool DriveAlignment::add(const Pose& own, const Pose& inMap) {
  const Pair pair{rigidOf(own), rigidOf(inMap)};
  if (!pairs_.empty()) {
    const cv::Affine3d step = pairs_.back().own.inv() * pair.own;
    if (cv::norm(step.translation()) < newShare * nearDistance_ && angleOf(step) < newShare * nearAngle_)
      return false;
  }
  if (pairs_.size() == maxPairs) pairs_.erase(pairs_.begin());
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

/// Least squares over six points around each camera (Umeyama 1991), so far away that a near angle moves them
/// as much as a near distance.
cv::Affine3d DriveAlignment::fit(const std::vector<const Pair*>& pairs) const {
  const double lever = std::numbers::sqrt3 * nearDistance_ / nearAngle_;
  Eigen::Matrix3Xd from(3, 6 * pairs.size()), to = from;
  Eigen::Index column = 0;
  for (const Pair* pair : pairs)
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-lever, lever}) {
        cv::Vec3d at;
        at[axis] = side;
        const cv::Vec3d own = pair->own * at, inMap = pair->inMap * at;
        from.col(column) << own[0], own[1], own[2];
        to.col(column++) << inMap[0], inMap[1], inMap[2];
      }
  const Eigen::Matrix4d found = Eigen::umeyama(from, to, false);
  cv::Affine3d transform;
  for (int row = 0; row < 4; ++row)
    for (int i = 0; i < 4; ++i) transform.matrix(row, i) = found(row, i);
  return transform;
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
  if (best.size() < minAgreeing) return std::nullopt;
  cv::Affine3d transform = fit(best);
  for (int round = 0; round < 3; ++round) {
    auto found = agreeing(transform);
    if (found.size() < minAgreeing || found == best) break;
    best = std::move(found);
    transform = fit(best);
  }
  if (best.size() < minAgreeing || 2 * best.size() < pairs_.size()) return std::nullopt;
  double extent = 0;
  for (const Pair* a : best)
    for (const Pair* b : best)
      extent = std::max(extent, cv::norm(a->own.translation() - b->own.translation()));
  return Estimate{transform, best.size(), extent};
}

}  // namespace estancia
