// SPDX-License-Identifier: Apache-2.0
#include "recognition/bop_measures.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>

namespace estancia::experiments {
namespace {

constexpr std::size_t thresholds = 10;  // a measure: 5 %, 10 % …
constexpr double levelStep = 0.05;

double levelOf(std::size_t i) {
  return levelStep * static_cast<double>(i + 1);
}

/// A corner in the image: column, row, 1 / depth; the last is 0 where it is not in front of the camera.
using Corner = cv::Vec3d;

Corner project(const cv::Vec3d& p, const CameraIntrinsics& camera) {
  constexpr double near = 0.001;  // [m]
  if (!(p[2] > near)) return {};
  return {camera.fx * p[0] / p[2] + camera.cx, camera.fy * p[1] / p[2] + camera.cy, 1 / p[2]};
}

/// The whole numbers from `a` to `b` that are below `size`.
cv::Range pixelsWithin(double a, double b, int size) {
  const auto inside = [&](double x) {
    return static_cast<int>(std::clamp(x, -1.0, static_cast<double>(size)));
  };
  return {std::max(0, inside(std::ceil(a))), std::min(size, inside(std::floor(b)) + 1)};
}

double cross(double ax, double ay, double bx, double by) {
  return ax * by - ay * bx;
}

void drawTriangle(const Corner& a, const Corner& b, const Corner& c, cv::Mat_<float>& depth) {
  if (a[2] == 0 || b[2] == 0 || c[2] == 0) return;
  const double area = cross(b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
  if (area == 0) return;
  const cv::Range rows = pixelsWithin(std::min({a[1], b[1], c[1]}), std::max({a[1], b[1], c[1]}), depth.rows),
                  columns =
                      pixelsWithin(std::min({a[0], b[0], c[0]}), std::max({a[0], b[0], c[0]}), depth.cols);
  for (int v = rows.start; v < rows.end; ++v)
    for (int u = columns.start; u < columns.end; ++u) {
      const double wa = cross(b[0] - u, b[1] - v, c[0] - u, c[1] - v) / area,
                   wb = cross(c[0] - u, c[1] - v, a[0] - u, a[1] - v) / area, wc = 1 - wa - wb;
      if (wa < 0 || wb < 0 || wc < 0) continue;
      const auto z = static_cast<float>(1 / (wa * a[2] + wb * b[2] + wc * c[2]));
      if (float& there = depth(v, u); there == 0 || z < there) there = z;
    }
}

/// The largest distance of two places of the same vertex, for that symmetry which makes it smallest.
template <class Place, class Distance>
double smallestOfLargest(const BopObject& object, const cv::Affine3d& found, const cv::Affine3d& truth,
                         const Place& place, const Distance& distance) {
  const auto& points = object.mesh.vertices.points;
  std::vector<decltype(place(cv::Vec3d()))> there;
  there.reserve(points.size());
  for (const cv::Point3f& p : points) there.push_back(place(found * cv::Vec3d(p.x, p.y, p.z)));
  double smallest = HUGE_VAL;
  for (const cv::Affine3d& symmetry : object.symmetries) {
    const cv::Affine3d same = truth * symmetry;
    double largest = 0;
    for (std::size_t i = 0; i < points.size() && largest < smallest; ++i)
      largest = std::max(largest,
                         distance(there[i], place(same * cv::Vec3d(points[i].x, points[i].y, points[i].z))));
    smallest = std::min(smallest, largest);
  }
  return smallest;
}

/// Whether the projections of the spheres around the object in both poses can touch: without, nothing that
/// is seen of one is seen of the other.
bool spheresMeet(const cv::Vec3d& a, const cv::Vec3d& b, double diameter) {
  if (!(a[2] > 0 && b[2] > 0)) return false;
  return std::hypot(a[0] / a[2] - b[0] / b[2], a[1] / a[2] - b[1] / b[2]) <
         diameter / 2 * (1 / a[2] + 1 / b[2]);
}

/// The poses of the target's most visible instances.
std::vector<cv::Affine3d> instancesOf(const BopTarget& target, const BopImage& image) {
  std::vector<BopInstance> all;
  std::ranges::copy_if(image.truth, std::back_inserter(all),
                       [&](const auto& i) { return i.object == target.object; });
  std::ranges::stable_sort(all, std::greater(), &BopInstance::visible);
  std::vector<cv::Affine3d> poses;
  for (std::size_t i = 0; i < std::min(all.size(), target.instances); ++i) poses.push_back(all[i].pose);
  return poses;
}

using Errors = std::vector<std::vector<double>>;  // [estimate][instance]

/// The mean number of matches over thresholds of 1 … 10 steps.
double meanMatches(const Errors& errors, double step) {
  double sum = 0;
  for (std::size_t i = 1; i <= thresholds; ++i)
    sum += static_cast<double>(matchEstimates(errors, step * static_cast<double>(i)));
  return sum / thresholds;
}

}  // namespace

cv::Mat renderMesh(const PlyMesh& mesh, const cv::Affine3d& pose, const CameraIntrinsics& camera) {
  cv::Mat_<float> depth(camera.height, camera.width, 0.F);
  std::vector<Corner> corners;
  corners.reserve(mesh.vertices.points.size());
  for (const cv::Point3f& p : mesh.vertices.points)
    corners.push_back(project(pose * cv::Vec3d(p.x, p.y, p.z), camera));
  for (const auto& [a, b, c] : mesh.triangles) drawTriangle(corners[a], corners[b], corners[c], depth);
  return depth;
}

std::array<double, 10> visibleSurfaceDiscrepancy(const VisibleSurfaces& depths,
                                                 const CameraIntrinsics& camera, double delta,
                                                 double diameter) {
  const cv::Mat_<float> measured = depths.measured, truth = depths.truth, found = depths.found;
  std::array<double, thresholds> wrong{};
  double seen = 0;  // pixels of either
  for (int v = 0; v < measured.rows; ++v)
    for (int u = 0; u < measured.cols; ++u) {
      // Distances to the camera instead of depths.
      const double ray = std::hypot(1, camera.slopeX(u), camera.slopeY(v));
      const double m = ray * static_cast<double>(measured(v, u)), t = ray * static_cast<double>(truth(v, u)),
                   f = ray * static_cast<double>(found(v, u));
      const bool trueSeen = t > 0 && (m == 0 || t - m <= delta);
      const bool foundSeen = f > 0 && (m == 0 || f - m <= delta || trueSeen);
      if (!trueSeen && !foundSeen) continue;
      ++seen;
      for (std::size_t i = 0; i < thresholds; ++i)
        if (!trueSeen || !foundSeen || std::abs(t - f) >= levelOf(i) * diameter) ++wrong[i];
    }
  for (double& count : wrong) count = seen > 0 ? count / seen : 1;
  return wrong;
}

double maxSurfaceDistance(const BopObject& object, const cv::Affine3d& found, const cv::Affine3d& truth) {
  return smallestOfLargest(
      object, found, truth, [](const cv::Vec3d& p) { return p; },
      [](const cv::Vec3d& a, const cv::Vec3d& b) { return cv::norm(a - b); });
}

double maxProjectionDistance(const BopObject& object, const cv::Affine3d& found, const cv::Affine3d& truth,
                             const CameraIntrinsics& camera) {
  return smallestOfLargest(
      object, found, truth, [&](const cv::Vec3d& p) { return project(p, camera); },
      [](const Corner& a, const Corner& b) {
        return a[2] == 0 || b[2] == 0 ? HUGE_VAL : std::hypot(a[0] - b[0], a[1] - b[1]);
      });
}

std::size_t matchEstimates(const std::vector<std::vector<double>>& errors, double threshold) {
  std::vector<bool> taken(errors.empty() ? 0 : errors[0].size());
  std::size_t matches = 0;
  for (const std::vector<double>& estimate : errors) {
    double smallest = threshold;
    std::size_t best = taken.size();
    for (std::size_t i = 0; i < taken.size(); ++i)
      if (!taken[i] && estimate[i] < smallest) {
        smallest = estimate[i];
        best = i;
      }
    if (best == taken.size()) continue;
    taken[best] = true;
    ++matches;
  }
  return matches;
}

BopScore& BopScore::operator+=(const BopScore& other) {
  targets += other.targets;
  vsd += other.vsd;
  mssd += other.mssd;
  mspd += other.mspd;
  return *this;
}

BopScore judgeEstimates(const BopTarget& target, const BopObject& object,
                        std::span<const cv::Affine3d> estimates, const BopImage& image,
                        const DepthFrame& frame, double delta) {
  constexpr double widthOfPixels = 640, pixels = 5;  // MSPD's thresholds: 5, 10 … pixels in an image of VGA
  const std::vector<cv::Affine3d> truth = instancesOf(target, image);
  const Errors none(std::min(estimates.size(), target.instances),
                    std::vector<double>(truth.size(), HUGE_VAL));
  std::array<Errors, thresholds> vsd;
  vsd.fill(none);
  Errors mssd = none, mspd = none;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const cv::Mat there = renderMesh(object.mesh, truth[i], frame.camera);
    for (std::size_t e = 0; e < none.size(); ++e) {
      const cv::Vec3d at = estimates[e].translation(), wanted = truth[i].translation();
      if (spheresMeet(at, wanted, object.diameter)) {
        const cv::Mat found = renderMesh(object.mesh, estimates[e], frame.camera);
        const auto errors =
            visibleSurfaceDiscrepancy({frame.depth, there, found}, frame.camera, delta, object.diameter);
        for (std::size_t k = 0; k < thresholds; ++k) vsd[k][e][i] = errors[k];
      }
      if (cv::norm(at - wanted) < object.diameter)
        mssd[e][i] = maxSurfaceDistance(object, estimates[e], truth[i]);
      mspd[e][i] = maxProjectionDistance(object, estimates[e], truth[i], frame.camera);
    }
  }
  BopScore score{static_cast<double>(truth.size())};
  for (const Errors& errors : vsd) score.vsd += meanMatches(errors, levelStep);
  score.vsd /= thresholds;
  score.mssd = meanMatches(mssd, levelStep * object.diameter);
  score.mspd = meanMatches(mspd, pixels * frame.camera.width / widthOfPixels);
  return score;
}

}  // namespace estancia::experiments
