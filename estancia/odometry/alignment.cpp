// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/alignment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "estancia/core/simd.hpp"

namespace estancia::odometry {
namespace {

constexpr float freedom = 5;               // degrees of freedom of the t-distribution (Kerl et al. 2013)
constexpr float minPlaneSpread = 0.5e-3F;  // [m] at 1 m; depth comes in millimeters
constexpr float minGraySpread = 0.01F;     // images come in 8 bits, compressed
// A pixel; less may be light on a bare wall, the shade of a lens or noise, none of which moves with the wall.
constexpr float minGradient = 2 * minGraySpread;
constexpr float unregistered = 2;  // [pixels of the finest level] between color and depth
constexpr float facing = 0.7F;     // cosine: surfaces that face other ways are not the same
constexpr float near = 4;  // [m]; beyond, noise grows with the square of depth, and so may differences
constexpr double textured = 4e-4;   // variance of gray values (0 to 1); below, there is no texture
constexpr double converged = 1e-4;  // [m] and [rad]: a smaller step is the last of its level
constexpr double maxTurn = 0.3;     // [rad] of one step
constexpr double correlated = 25;   // pixels that count as one independent observation
// Prior: a motion is within a radian and a meter. It keeps directions that nothing shows as they were
// guessed.
const cv::Matx66d room = cv::Matx66d::eye();
constexpr double cameraTurn = 1e-3,
                 cameraShift = 2e-3;  // [rad], [m]: what no number of pixels makes exacter

/// One residual, and how it changes with a motion of the source in the frame of the first target.
struct Observation {
  /// The derivatives by rotation (3) and translation (3), the residual, and 0.
  alignas(32) std::array<float, 8> row;
  float spread;  ///< expected, beside that of the others of its kind

  float& residual() { return row[6]; }
};

/// Gray values of corresponding pixels, for the exposure: target ≈ gain · source + bias.
struct GrayPairs {
  std::size_t count = 0;
  double a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  void add(double source, double target) {
    ++count;
    a += source, b += target, aa += source * source, bb += target * target, ab += source * target;
  }
  double varianceA() const { return aa / n() - a / n() * (a / n()); }
  double varianceB() const { return bb / n() - b / n() * (b / n()); }
  double covariance() const { return ab / n() - a / n() * (b / n()); }
  double n() const { return static_cast<double>(count); }
};

struct Exposure {
  float gain = 1, bias = 0;
};

Exposure exposureOf(const GrayPairs& pairs) {
  Exposure exposure;
  if (pairs.count == 0) return exposure;
  if (pairs.varianceA() > textured)
    exposure.gain = static_cast<float>(std::clamp(pairs.covariance() / pairs.varianceA(), 0.5, 2.0));
  exposure.bias = static_cast<float>((pairs.b - exposure.gain * pairs.a) / pairs.n());
  return exposure;
}

float sampled(const cv::Mat& image, float u, float v) {
  const int x = static_cast<int>(u), y = static_cast<int>(v);
  const float du = u - static_cast<float>(x), dv = v - static_cast<float>(y);
  const float *above = image.ptr<float>(y) + x, *below = image.ptr<float>(y + 1) + x;
  return (1 - dv) * ((1 - du) * above[0] + du * above[1]) + dv * ((1 - du) * below[0] + du * below[1]);
}

/// The point of the source in column x and row y as a target sees it.
struct Projection {
  cv::Vec3f point;  ///< in the target's frame
  float u, v;       ///< where the target sees it
  int column, row;  ///< the nearest pixel
};

/// False outside of the target's image, and where it has no depth.
inline bool project(const cv::Matx33f& rotation, const cv::Vec3f& translation, const cv::Vec3f& point,
                    const PyramidLevel& target, Projection& p) {
  if (!(point[2] > 0)) return false;
  p.point = rotation * point + translation;
  if (!(p.point[2] > 0.05F)) return false;
  const CameraIntrinsics& c = target.camera;
  p.u = static_cast<float>(c.fx) * p.point[0] / p.point[2] + static_cast<float>(c.cx);
  p.v = static_cast<float>(c.fy) * p.point[1] / p.point[2] + static_cast<float>(c.cy);
  if (!(p.u >= 0 && p.v >= 0 && p.u < static_cast<float>(target.depth.cols - 1) &&
        p.v < static_cast<float>(target.depth.rows - 1)))
    return false;
  p.column = static_cast<int>(p.u + 0.5F), p.row = static_cast<int>(p.v + 0.5F);
  return target.depth.at<float>(p.row, p.column) > 0;  // false for NaN
}

/// Gauss–Newton steps on one level of the pyramids. Life cycle: constructed for one level, then step() until
/// it converges. Invariant: observations are made anew at each step, for all targets in the frame of the
/// first.
class Level {
 public:
  Level(const Pyramid& source, std::span<const AlignmentTarget> targets, std::size_t level,
        const AlignmentOptions& options)
      : source_(source[level]),
        targets_(targets),
        level_(level),
        beyond_(static_cast<float>(0.10 * std::pow(2.0, level))),
        byDepth_(options.term != AlignmentTerm::color),
        byColor_(options.term != AlignmentTerm::depth),
        unregistered_(options.term == AlignmentTerm::automatic
                          ? unregistered / static_cast<float>(std::pow(2.0, level))
                          : 0) {}

  /// Moves `transform` by one step; the length of the step [m or rad, the larger], or nothing when the system
  /// is singular.
  std::optional<double> step(cv::Affine3d& transform, cv::Matx66d& information);

  const Exposure& exposure() const { return exposure_; }

 private:
  void observe(const AlignmentTarget& target, const cv::Affine3d& transform);
  void addPlane(const PyramidLevel& target, const Projection& p, const cv::Vec3f& sourceNormal);
  void addGray(const PyramidLevel& target, const Projection& p, float gray);
  /// The residual falls by `direction` times the motion of `point` (both in the target's frame).
  Observation observation(const cv::Vec3f& point, const cv::Vec3f& direction, float residual,
                          float spread) const {
    const cv::Vec3f d = toFirst_ * direction, turn = (toFirst_ * point + firstShift_).cross(d);
    return {{turn[0], turn[1], turn[2], d[0], d[1], d[2], residual, 0}, spread};
  }

  const PyramidLevel& source_;
  std::span<const AlignmentTarget> targets_;
  std::size_t level_;
  float beyond_;  ///< difference in depth up to which points correspond [m]
  bool byDepth_, byColor_;
  float unregistered_;
  cv::Matx33f toFirst_;  ///< rotation of the target in turn into the first
  cv::Vec3f firstShift_;
  std::vector<Observation> planes_, grays_;
  std::vector<float> sourceGrays_;  ///< subset of grays_
  GrayPairs pairs_;
  Exposure exposure_;
};

void Level::addPlane(const PyramidLevel& target, const Projection& p, const cv::Vec3f& sourceNormal) {
  const cv::Vec3f& normal = target.normals.at<cv::Vec3f>(p.row, p.column);
  if (!(normal[2] <= 1) || sourceNormal.dot(normal) < facing) return;  // no normal at an edge
  const float distance = normal.dot(p.point - target.points.at<cv::Vec3f>(p.row, p.column));
  const float z = p.point[2];
  // noise of triangulation
  planes_.push_back(observation(p.point, normal, distance, std::max(0.25F, z * z)));
}

void Level::addGray(const PyramidLevel& target, const Projection& p, float gray) {
  const float dx = sampled(target.grayDx, p.u, p.v) / 8, dy = sampled(target.grayDy, p.u, p.v) / 8;  // Sobel
  const float value = sampled(target.gray, p.u, p.v);
  pairs_.add(gray, value);
  if (dx * dx + dy * dy < minGradient * minGradient) return;
  sourceGrays_.push_back(gray);
  const float z = p.point[2], gu = dx * static_cast<float>(target.camera.fx) / z,
              gv = dy * static_cast<float>(target.camera.fy) / z;
  const cv::Vec3f direction(gu, gv, -(gu * p.point[0] + gv * p.point[1]) / z);
  const float blur = unregistered_ / (2 * minGraySpread);
  grays_.push_back(observation(p.point, direction, value, std::sqrt(1 + blur * blur * (dx * dx + dy * dy))));
}

void Level::observe(const AlignmentTarget& target, const cv::Affine3d& transform) {
  const PyramidLevel& seen = (*target.pyramid)[level_];
  const cv::Affine3d motion = target.pose.inv() * transform,
                     first = targets_.front().pose.inv() * target.pose;
  const cv::Matx33f rotation = motion.rotation();
  const cv::Vec3f translation = motion.translation();
  toFirst_ = first.rotation(), firstShift_ = first.translation();
  Projection p;
  for (int y = 0; y < source_.points.rows; ++y) {
    const cv::Vec3f *points = source_.points.ptr<cv::Vec3f>(y), *normals = source_.normals.ptr<cv::Vec3f>(y);
    const float* grays = source_.gray.ptr<float>(y);
    for (int x = 0; x < source_.points.cols; ++x) {
      if (!project(rotation, translation, points[x], seen, p)) continue;
      if (std::abs(seen.depth.at<float>(p.row, p.column) - p.point[2]) > beyond_) continue;
      if (byDepth_) addPlane(seen, p, rotation * normals[x]);
      if (byColor_) addGray(seen, p, grays[x]);
    }
  }
}

/// The median deviation of some of them, as that of a normal distribution.
float spreadOf(std::span<const Observation> observations, float least) {
  if (observations.empty()) return least;
  std::vector<float> sizes;
  for (std::size_t i = 0; i < observations.size(); i += 1 + observations.size() / 4096)
    sizes.push_back(std::abs(observations[i].row[6]) / observations[i].spread);
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return std::max(least, 1.4826F * *middle);
}

/// Adds w · row · rowᵀ of every observation to `products`, 6 × 8: Σ w JᵀJ beside Σ w Jᵀr.
ESTANCIA_MULTIVERSION
void addProducts(const Observation* observations, std::size_t count, float spread, float* products) {
  for (std::size_t n = 0; n < count; ++n) {
    const Observation& o = observations[n];
    const float scale = 1 / (o.spread * spread), e = o.row[6] * scale;
    const float weight = (freedom + 1) / (freedom + e * e) * scale * scale;
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 8; ++j) products[8 * i + j] += weight * o.row[i] * o.row[j];
  }
}

/// The system of one kind of observations; in float for a few, in double for their sums.
void addNormalEquations(std::span<const Observation> observations, float least, cv::Matx66d& matrix,
                        cv::Matx61d& vector) {
  constexpr std::size_t block = 256;
  const float spread = spreadOf(observations, least);
  for (std::size_t first = 0; first < observations.size(); first += block) {
    alignas(32) std::array<float, 48> products{};
    addProducts(&observations[first], std::min(block, observations.size() - first), spread, products.data());
    for (int i = 0; i < 6; ++i) {
      const float* row = &products[static_cast<std::size_t>(8 * i)];
      for (int j = 0; j < 6; ++j) matrix(i, j) += static_cast<double>(row[j]);
      vector(i) += static_cast<double>(row[6]);
    }
  }
}

std::optional<double> Level::step(cv::Affine3d& transform, cv::Matx66d& information) {
  planes_.clear(), grays_.clear(), sourceGrays_.clear();
  pairs_ = {};
  for (const AlignmentTarget& target : targets_) observe(target, transform);
  if (planes_.size() + grays_.size() < 100) return std::nullopt;
  exposure_ = exposureOf(pairs_);
  for (std::size_t i = 0; i < grays_.size(); ++i)
    grays_[i].residual() -= exposure_.gain * sourceGrays_[i] + exposure_.bias;
  information = cv::Matx66d::zeros();
  cv::Matx61d slope = cv::Matx61d::zeros();
  addNormalEquations(planes_, minPlaneSpread, information, slope);
  addNormalEquations(grays_, minGraySpread, information, slope);
  const cv::Matx66d damped = information + correlated * room;
  cv::Matx61d motion;
  if (!cv::solve(damped, -1 * slope, motion, cv::DECOMP_CHOLESKY)) return std::nullopt;
  cv::Vec3d turn(motion.val), shift(motion.val + 3);
  const double angle = cv::norm(turn);
  if (!std::isfinite(angle + cv::norm(shift))) return std::nullopt;
  if (angle > maxTurn) turn *= maxTurn / angle, shift *= maxTurn / angle;
  const cv::Affine3d& first = targets_.front().pose;
  transform = first * cv::Affine3d(turn, shift) * first.inv() * transform;
  return std::max(cv::norm(turn), cv::norm(shift));
}

/// Overlap of the source with one target.
struct Shared {
  std::size_t points = 0, same = 0;
  double squares = 0;
  GrayPairs grays;
};

/// Marks in `agreed` the points that agree in depth and gray value.
Shared sharedWith(const PyramidLevel& source, const PyramidLevel& target, const cv::Affine3d& motion,
                  const Exposure& exposure, cv::Mat& agreed) {
  const cv::Matx33f rotation = motion.rotation();
  const cv::Vec3f translation = motion.translation();
  Shared shared;
  Projection p;
  for (int y = 0; y < source.points.rows; ++y)
    for (int x = 0; x < source.points.cols; ++x) {
      const cv::Vec3f& point = source.points.at<cv::Vec3f>(y, x);
      if (!(point[2] > 0)) continue;
      ++shared.points;
      if (!project(rotation, translation, point, target, p)) continue;
      const float nearer = std::min(1.0F, near * near / (p.point[2] * p.point[2]));
      const auto difference =
          static_cast<double>(nearer * (target.depth.at<float>(p.row, p.column) - p.point[2]));
      if (std::abs(difference) > 0.05) continue;  // [m]; another surface
      ++shared.same;
      shared.squares += difference * difference;
      const float a = source.gray.at<float>(y, x), b = target.gray.at<float>(p.row, p.column);
      shared.grays.add(a, b);
      if (std::abs(exposure.gain * a + exposure.bias - b) < 0.1F) agreed.at<std::uint8_t>(y, x) = 1;
    }
  return shared;
}

void evaluate(Alignment& alignment, const PyramidLevel& source, std::span<const AlignmentTarget> targets,
              std::size_t level, const Exposure& exposure) {
  cv::Mat agreed(source.depth.size(), CV_8U, cv::Scalar(0));
  Shared best;
  for (const AlignmentTarget& target : targets) {
    const Shared shared = sharedWith(source, (*target.pyramid)[level],
                                     target.pose.inv() * alignment.transform, exposure, agreed);
    if (shared.same >= best.same) best = shared;
  }
  if (best.same == 0) {
    alignment.solved = false;
    return;
  }
  const auto share = [&](auto part) { return static_cast<double>(part) / static_cast<double>(best.points); };
  alignment.overlap = share(best.same);
  alignment.agreement = share(cv::countNonZero(agreed));
  alignment.rmse = std::sqrt(best.squares / best.grays.n());
  const double a = best.grays.varianceA(), b = best.grays.varianceB();
  alignment.correlation = std::min(a, b) > textured ? best.grays.covariance() / std::sqrt(a * b) : 1;
}

/// The square root of the largest eigenvalue of the position's covariance, at the source.
double spreadOfPosition(const cv::Matx66d& covariance, const cv::Vec3d& at) {
  const double entries[] = {0,      at[2],  -at[1], 1, 0, 0,  //
                            -at[2], 0,      at[0],  0, 1, 0,  //
                            at[1],  -at[0], 0,      0, 0, 1};
  const cv::Matx<double, 3, 6> move(entries);
  cv::Matx31d values;
  cv::eigen(cv::Matx33d(move * covariance * move.t()), values);
  return std::sqrt(std::max(0.0, values(0)));
}

}  // namespace

cv::Matx66d covarianceOf(const cv::Matx66d& information) {
  cv::Matx66d covariance = (information * (1 / correlated) + room).inv(cv::DECOMP_CHOLESKY);
  for (int i = 0; i < 6; ++i) covariance(i, i) += i < 3 ? cameraTurn * cameraTurn : cameraShift * cameraShift;
  return covariance;
}

Alignment align(const Pyramid& source, std::span<const AlignmentTarget> targets, const cv::Affine3d& guess,
                const AlignmentOptions& options) {
  Alignment alignment;
  alignment.transform = guess;
  std::size_t levels = source.size();
  for (const AlignmentTarget& target : targets) levels = std::min(levels, target.pyramid->size());
  const std::size_t finest = std::min(options.finest, levels - 1);
  Exposure exposure;
  for (std::size_t l = levels; l-- > finest;) {
    Level level(source, targets, l, options);
    for (int i = 0, steps = l == 0 ? 6 : 12; i < steps; ++i) {  // the finest takes the longest
      const auto length = level.step(alignment.transform, alignment.information);
      if (!length) return alignment;
      if (*length < converged) break;
    }
    exposure = level.exposure();
  }
  alignment.solved = true;
  evaluate(alignment, source[finest], targets, finest, exposure);
  alignment.spread = spreadOfPosition(covarianceOf(alignment.information),
                                      (targets.front().pose.inv() * alignment.transform).translation());
  return alignment;
}

}  // namespace estancia::odometry
