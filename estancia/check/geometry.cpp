// Checks poses against depth: pairs of depth images are reprojected into each other under all usual
// conventions. The true one stands out, because wrong motions put surfaces where the other image has none.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <vector>

#include "estancia/check/checklist.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/pose.hpp"

namespace estancia::check {
namespace {

constexpr int smallWidth = 160;     // width of the small depth image [pixels]
constexpr int stride = 4;           // from point to point in it [pixels]
constexpr double tolerance = 0.04;  // share of the depth: noise, and pixels that do not coincide

/// A depth image reduced to some thousand points.
class DepthView {
 public:
  /// `depth` in meters (CV_32F, 0 = none); `camera` of any size.
  DepthView(const cv::Mat& depth, const CameraIntrinsics& camera) {
    const int width = std::min(smallWidth, depth.cols), height = std::max(1, depth.rows * width / depth.cols);
    cv::resize(depth, depth_, {width, height}, 0, 0, cv::INTER_NEAREST);  // depths must not be interpolated
    camera_ = camera.scaledTo(width, height);
    for (int v = stride / 2; v < height; v += stride)
      for (int u = stride / 2; u < width; u += stride)
        if (const double z = depth_.at<float>(v, u); z > 0)
          points_.emplace_back(camera_.slopeX(u) * z, camera_.slopeY(v) * z, z);
  }

  const std::vector<cv::Vec3d>& points() const { return points_; }  ///< in the optical frame [m]

  /// The depth in the direction of the point `p` [m]; 0 when it is out of view or has no depth.
  double depthTowards(const cv::Vec3d& p) const {
    if (!(p[2] > 0)) return 0;
    const double u = camera_.fx * p[0] / p[2] + camera_.cx + 0.5,
                 v = camera_.fy * p[1] / p[2] + camera_.cy + 0.5;
    if (!(u >= 0 && v >= 0 && u < depth_.cols && v < depth_.rows)) return 0;
    return depth_.at<float>(static_cast<int>(v), static_cast<int>(u));
  }

 private:
  cv::Mat depth_;  ///< small, CV_32F
  CameraIntrinsics camera_;
  std::vector<cv::Vec3d> points_;
};

std::size_t matching(const DepthView& from, const DepthView& to, const cv::Affine3d& toFromFrom) {
  std::size_t count = 0;
  for (const cv::Vec3d& point : from.points()) {
    const cv::Vec3d moved = toFromFrom * point;
    if (std::abs(to.depthTowards(moved) - moved[2]) < tolerance * moved[2]) ++count;
  }
  return count;
}

/// The share in [0, 1] of the points of both views that have the same depth (within 4 %) in the other view,
/// after transformation by `bFromA` (T_b_a). Points out of the other's view do not match.
double reprojectionMatch(const DepthView& a, const DepthView& b, const cv::Affine3d& bFromA) {
  const std::size_t total = a.points().size() + b.points().size();
  if (total == 0) return 0;
  return static_cast<double>(matching(a, b, bFromA) + matching(b, a, bFromA.inv())) /
         static_cast<double>(total);
}

constexpr std::size_t anchorCount = 30;  // first frames of pairs
constexpr std::size_t maxDistance = 64;  // frames between the two of a pair
constexpr double maxMatchOfMoved = 0.6;  // match of two views without motion; below, the camera moved enough
constexpr double still = 0.8;            // above, it hardly moved
constexpr std::size_t minPairs = 5;
constexpr int maxShift = 40;  // largest delay of the poses [frames]

/// The other camera frames in use: T_map_optical = T_map_given · rotation.
struct CameraFrame {
  const char* what;
  const char* fix;
  cv::Matx33d rotation;  ///< R_given_optical
};
const std::array<CameraFrame, 3> cameraFrames = {{
    {"", "", cv::Matx33d::eye()},
    {"of the robot's body (x forward, y left, z up)",
     "multiply each pose from the right by the rotation (qx qy qz qw) = (-0.5, 0.5, -0.5, 0.5), body to "
     "optical frame",
     {0, 0, 1, -1, 0, 0, 0, -1, 0}},
    {"of OpenGL (y up, z backward)",
     "multiply each pose from the right by diag(1, -1, -1): turn the columns of y and z round",
     {1, 0, 0, 0, -1, 0, 0, 0, -1}},
}};

/// A convention, scale and delay of the poses.
struct Hypothesis {
  bool inverted = false;  ///< T_camera_map instead of T_map_camera
  std::size_t frame = 0;  ///< in cameraFrames
  bool wFirst = false;    ///< quaternions were written qw qx qy qz
  double scale = 1;       ///< positions times this fit the depth; 0: positions are ignored
  int shift = 0;          ///< frame i has the pose given for frame i + shift
};

cv::Affine3d poseOf(Pose p, const Hypothesis& h) {
  if (h.wFirst) std::tie(p.qw, p.qx, p.qy, p.qz) = std::make_tuple(p.qx, p.qy, p.qz, p.qw);
  cv::Affine3d pose = rigidOf(p);
  pose.translation(h.scale * pose.translation());
  if (h.inverted) pose = pose.inv();
  return pose * cv::Affine3d(cameraFrames[h.frame].rotation);
}

/// reprojectionMatch() of each pair; NaN where a pose is missing.
using Scores = std::vector<double>;

double meanOf(const Scores& scores) {
  double sum = 0;
  std::size_t count = 0;
  for (const double s : scores)
    if (!std::isnan(s)) {
      sum += s;
      ++count;
    }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

/// Whether `a` is significantly better than `b`: by 0.02 or more in the mean, and by three standard errors of
/// the mean (wide, because pairs with much motion differ much more than others) or of wins over losses.
bool isBetter(const Scores& a, const Scores& b) {
  double sum = 0, squares = 0, n = 0, wins = 0, losses = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = a[i] - b[i];
    if (std::isnan(d)) continue;
    sum += d;
    squares += d * d;
    n += 1;
    if (d != 0) (d > 0 ? wins : losses) += 1;
  }
  if (n < minPairs) return false;
  const double mean = sum / n, variance = std::max(0.0, squares / n - mean * mean) * n / (n - 1);
  return mean > 0.02 && (mean > 3 * std::sqrt(variance / n) || wins - losses > 3 * std::sqrt(wins + losses));
}

class Geometry {
 public:
  explicit Geometry(const Sequence& sequence) : sequence_(sequence) {}

  /// Finds pairs of frames between which the camera moved enough to distinguish motions.
  void findPairs(Progress& progress) {
    const std::size_t size = sequence_.size();
    const auto anchors = evenly(size - 1, anchorCount);
    progress.begin("comparing depth with poses", anchors.size());
    for (const std::size_t a : anchors) {
      views_.erase(views_.begin(), views_.lower_bound(a));  // earlier views are no longer needed
      if (const DepthView* from = view(a)) {
        std::size_t partner = a;
        double unmoved = 1;
        for (std::size_t step = 1; step <= maxDistance && a + step < size && unmoved > maxMatchOfMoved;
             step *= 2)
          if (const DepthView* to = sequence_.frame(a + step).pose ? view(a + step) : nullptr) {
            partner = a + step;
            unmoved = reprojectionMatch(*from, *to, cv::Affine3d::Identity());
          }
        if (partner != a && unmoved < still) pairs_.push_back({a, partner, *from, *view(partner)});
      }
      progress.advance();
      if (interrupted()) throw Interrupted("interrupted before the check was complete");
    }
    progress.end();
    views_.clear();
  }

  std::size_t pairs() const { return pairs_.size(); }

  Scores unmoved() const {
    Scores scores;
    for (const Pair& pair : pairs_)
      scores.push_back(reprojectionMatch(pair.from, pair.to, cv::Affine3d::Identity()));
    return scores;
  }

  Scores under(const Hypothesis& h) const {
    Scores scores;
    for (const Pair& pair : pairs_) {
      const Pose* a = shifted(pair.a, h.shift);
      const Pose* b = shifted(pair.b, h.shift);
      scores.push_back(a == nullptr || b == nullptr
                           ? std::numeric_limits<double>::quiet_NaN()
                           : reprojectionMatch(pair.from, pair.to, poseOf(*b, h).inv() * poseOf(*a, h)));
    }
    return scores;
  }

 private:
  struct Pair {
    std::size_t a, b;
    DepthView from, to;
  };

  const Pose* shifted(std::size_t i, int shift) const {
    const auto at = static_cast<std::ptrdiff_t>(i) + shift;
    if (at < 0 || at >= static_cast<std::ptrdiff_t>(sequence_.size())) return nullptr;
    const auto& pose = sequence_.frame(static_cast<std::size_t>(at)).pose;
    return pose ? &*pose : nullptr;
  }

  /// Null when the frame has no pose or no usable depth.
  const DepthView* view(std::size_t i) {
    if (!sequence_.frame(i).pose) return nullptr;
    auto found = views_.find(i);
    if (found == views_.end()) {
      cv::Mat depth;
      try {
        depth = sequence_.depth(i);
      } catch (...) {
        frameFailure(sequence_.frame(i).name);  // counted when depth is checked
        return nullptr;
      }
      found = views_.emplace(i, DepthView(depth, *sequence_.intrinsics())).first;
    }
    return found->second.points().size() < 100 ? nullptr : &found->second;
  }

  const Sequence& sequence_;
  std::map<std::size_t, DepthView> views_;
  std::vector<Pair> pairs_;
};

/// A hypothesis and how well it does.
struct Candidate {
  Hypothesis hypothesis;
  Scores scores;

  /// Replaces this when it is significantly better. Returns whether.
  bool challenge(const Geometry& geometry, const Hypothesis& h) {
    Scores other = geometry.under(h);
    if (!isBetter(other, scores)) return false;
    *this = {h, std::move(other)};
    return true;
  }
};

/// From common to rare conventions, so that a rare one must be significantly better than all common ones.
Candidate searchConvention(const Geometry& geometry) {
  constexpr double scales[] = {1, 1e-3, 1e3, 5, 0.2, 10, 0.1, 100, 0.01, 2, 0.5};
  Candidate best{{}, geometry.under({})};
  for (const double scale : scales)
    for (const bool wFirst : {false, true})
      for (std::size_t frame = 0; frame < cameraFrames.size(); ++frame)
        for (const bool inverted : {false, true}) best.challenge(geometry, {inverted, frame, wFirst, scale});
  return best;
}

/// The delay with the best mean, if it is significantly better than none.
void searchShift(const Geometry& geometry, Candidate& best) {
  Hypothesis shifted = best.hypothesis, top = shifted;
  double highest = meanOf(best.scores);
  for (int shift = -maxShift; shift <= maxShift; ++shift) {
    shifted.shift = shift;
    const Scores scores = geometry.under(shifted);
    std::size_t judged = 0;
    for (const double s : scores) judged += std::isnan(s) ? 0 : 1;
    if (2 * judged < geometry.pairs() || meanOf(scores) <= highest) continue;
    highest = meanOf(scores);
    top = shifted;
  }
  if (top.shift != 0) best.challenge(geometry, top);
}

/// The scale with the best mean within a factor of 2.5, if it is significantly better than the present one.
void searchScale(const Geometry& geometry, Candidate& best) {
  Hypothesis scaled = best.hypothesis, top = scaled;
  double highest = meanOf(best.scores);
  constexpr int steps = 45;  // steps of 2 %
  for (int step = -steps; step <= steps; ++step) {
    scaled.scale = best.hypothesis.scale * std::pow(1.02, step);
    const double mean = meanOf(geometry.under(scaled));
    if (mean <= highest) continue;
    highest = mean;
    top = scaled;
  }
  if (best.challenge(geometry, top) || best.hypothesis.scale == 1) return;
  best.hypothesis = top;  // the coarse factor was significant; this is its maximum
  best.scores = geometry.under(top);
}

/// A common factor nearby: 0.001 for 0.00098.
double rounded(double factor) {
  for (const double known : {1e-3, 1e3, 0.2, 5.0, 0.1, 10.0, 0.01, 100.0})
    if (std::abs(std::log(factor / known)) < 0.12) return known;
  return factor;
}

void reportScale(double factor, const DepthFacts& facts, const std::string& evidence, Checklist& list) {
  if (list.has("depth-scale") || list.has("pose-scale")) return;  // found by range or speed already
  factor = rounded(factor);
  constexpr double usual = 2, unitsDiffer = 3;  // [m], factor: common units differ by more
  const double median = facts.median.value_or(usual);
  const double ifDepth = std::abs(std::log(median / factor / usual)),
               ifPoses = std::abs(std::log(median / usual));
  if (std::abs(std::log(factor)) < std::log(unitsDiffer))
    list.add(
        Severity::problem, "scale", "Positions and depth differ in scale",
        fmt::format("positions fit multiplied by {:.2f}; {}", factor, evidence),
        fmt::format("if the positions are right, give a --depth-scale {:.2f} times as large, or check the "
                    "focal length; else (monocular SLAM, wheel odometry) multiply them by {:.2f}",
                    factor, factor));
  else if (ifDepth < ifPoses)
    list.add(
        Severity::problem, "depth-scale", "Depth is in other units than the poses",
        fmt::format("it fits divided by {:.3g}: median {:.2g} m instead of {:.2g} m; {}", factor,
                    median / factor, median, evidence),
        fmt::format("give a --depth-scale {:.3g} times as large (the default is 1000 for 16 bits, TUM RGB-D "
                    "5000, float 1)",
                    factor));
  else
    list.add(Severity::problem, "pose-scale", "Positions are in other units than meters",
             fmt::format("they fit the depth multiplied by {:.3g}; {}", factor, evidence),
             fmt::format("multiply the positions by {:.3g}", factor));
}

void report(const Sequence& sequence, const Candidate& best, double given, double unmoved, std::size_t pairs,
            const DepthFacts& facts, Checklist& list) {
  const Hypothesis& h = best.hypothesis;
  const std::string evidence = fmt::format(
      "{:.0f} % of the depth agrees so, {:.0f} % as given, {:.0f} % for a still camera, {} pairs of frames",
      100 * meanOf(best.scores), 100 * given, 100 * unmoved, pairs);
  if (h.wFirst)
    list.add(Severity::problem, "pose-quaternion", "Quaternions are written qw qx qy qz", evidence,
             "write t x y z qx qy qz qw: qw comes last");
  if (h.inverted)
    list.add(Severity::problem, "pose-inverted", "Poses are inverted: T_camera_map instead of T_map_camera",
             evidence,
             "invert each pose (R' = Rᵀ, t' = −Rᵀ t), so that it takes points of the camera to the map");
  if (h.frame != 0)
    list.add(Severity::problem, "pose-frame",
             fmt::format("Poses are {}, not of the optical frame", cameraFrames[h.frame].what), evidence,
             std::string(cameraFrames[h.frame].fix) + (h.inverted ? ", once they are inverted" : ""));
  if (h.shift != 0) {
    const auto interval = frameInterval(sequence);
    const int by = std::abs(h.shift);
    const std::string time = interval ? fmt::format(" ({:.3f} s)", by * *interval) : "";
    list.add(
        Severity::problem, "pose-time",
        fmt::format("Poses are {} frame{}{} too {}", by, by > 1 ? "s" : "", time,
                    h.shift > 0 ? "late" : "early"),
        evidence,
        h.shift > 0
            ? fmt::format("subtract the delay from the trajectory's time stamps, or leave out its first {}",
                          by > 1 ? fmt::format("{} poses", by) : "pose")
            : fmt::format("add the delay to the trajectory's time stamps, or leave out the first {}",
                          by > 1 ? fmt::format("{} images", by) : "image"));
  }
  if (std::abs(std::log(h.scale)) > 0.08) reportScale(h.scale, facts, evidence, list);
}

}  // namespace

void checkGeometry(const Sequence& sequence, const DepthFacts& facts, Progress& progress, Checklist& list) {
  if (!sequence.hasDepth() || !sequence.intrinsics() || sequence.size() < 2) return;
  for (const char* reason :
       {"pose-constant", "pose-order", "camera-size", "camera-center", "camera-view", "depth-size"})
    if (list.has(reason)) return;  // then nothing fits
  if (!hasPoses(sequence)) return;
  Geometry geometry(sequence);
  geometry.findPairs(progress);
  if (geometry.pairs() < minPairs) {
    list.fine("geometry", "Poses and depth were not compared: too few frames moved and have both",
              fmt::format("{} pairs", geometry.pairs()));
    return;
  }
  const Scores unmoved = geometry.unmoved();
  Candidate best = searchConvention(geometry);
  const double given = meanOf(geometry.under({}));
  searchShift(geometry, best);
  searchScale(geometry, best);
  Hypothesis rotation = best.hypothesis;
  rotation.scale = 0;
  const Scores rotationOnly = geometry.under(rotation);
  // Inverted, scaled or delayed positions must be significantly better than no positions.
  const bool asGiven = meanOf(best.scores) <= given;
  const bool positionsFit =
      asGiven ? !isBetter(rotationOnly, best.scores) : isBetter(best.scores, rotationOnly);
  if (!isBetter(best.scores, unmoved) || !positionsFit) {
    list.add(
        Severity::problem, "pose-unfit",
        "Poses do not fit the depth, whatever convention, scale or delay is tried",
        fmt::format("{:.0f} % of the depth agrees at best, {:.0f} % for a still camera, {} pairs of frames",
                    100 * meanOf(best.scores), 100 * meanOf(unmoved), geometry.pairs()),
        "check that trajectory, images and intrinsics belong together; `estancia odometry estimate` computes "
        "poses anew");
    return;
  }
  const std::size_t before = list.faults();
  report(sequence, best, given, meanOf(unmoved), geometry.pairs(), facts, list);
  if (list.faults() == before)
    list.fine("geometry", "Poses fit the depth",
              fmt::format("{:.0f} % of the depth agrees, {:.0f} % for a still camera, {} pairs of frames",
                          100 * given, 100 * meanOf(unmoved), geometry.pairs()));
}

}  // namespace estancia::check
