// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {
namespace {

const double parallel = std::cos(8 * CV_PI / 180), perpendicular = std::sin(8 * CV_PI / 180);
constexpr double minUprightCosine = 0.5;     // cosine of the angle between up and the image's: 60°
constexpr double behindMargin = 0.05;        // beyond which a point lies behind a plane [m]
constexpr double depthNoise = 0.005;         // and its growth with depth [m at 1 m]: 4 σ of a Kinect
constexpr double few = 0.02;                 // share of what is seen
constexpr double shallow = 0.2, deep = 0.9;  // depth of furniture [m]
constexpr double wallGap = 0.3;              // gap between a piece of furniture and the wall beside it [m]
constexpr double smallWall = 0.2;            // share of the area of what may stand before it
constexpr double wallThickness = 0.25;       // [m]
constexpr int minConvex = 10;                // pixels of an edge

cv::Vec3d toVec(const cv::Point3f& p) {
  return {p.x, p.y, p.z};
}

/// Signed distance [m]; negative behind the plane.
double distanceTo(const Plane& plane, const cv::Vec3d& p) {
  return plane.normal.dot(p) - plane.offset;
}

double marginAt(double z) {
  return behindMargin + depthNoise * z * z;
}

bool isUpright(const Plane& plane, const cv::Vec3d& up) {
  return std::abs(plane.normal.dot(up)) < perpendicular;
}

/// Visible part of a plane.
struct PlaneView {
  double behind = 0;           ///< share of the image's pixels that lie behind it
  double left = 0, right = 0;  ///< range of its pixels, along the level direction in it [m]
  int upperEdge = 0;           ///< columns in which its upper edge is seen
  int columns = 0;             ///< columns in which it is seen
};

std::vector<PlaneView> viewsOf(const InverseDepth& grid, const cv::Vec3d& up, const PlaneRemoval& removal) {
  const std::vector<Plane>& planes = removal.planes;
  std::vector<PlaneView> views(planes.size());
  std::vector<std::vector<double>> along(planes.size());
  double seen = 0;
  const int step = grid.pixels(6);
  for (int v = 0; v < grid.camera.height; v += step)
    for (int u = 0; u < grid.camera.width; u += step) {
      const std::size_t at = grid.at(u, v);
      if (!(grid.raw[at] > 0)) continue;
      const cv::Vec3d p = toVec(grid.point(u, v));
      ++seen;
      for (std::size_t k = 0; k < planes.size(); ++k)
        views[k].behind += distanceTo(planes[k], p) < -marginAt(p[2]) ? 1 : 0;
      if (const std::size_t k = removal.of[at]; k != 0)
        along[k - 1].push_back(p.dot(up.cross(planes[k - 1].normal)));
    }
  for (std::size_t k = 0; k < planes.size(); ++k) {
    views[k].behind /= std::max(seen, 1.);
    if (along[k].empty()) continue;
    std::ranges::sort(along[k]);
    const std::size_t outliers = along[k].size() / 50;
    views[k].left = along[k][outliers];
    views[k].right = along[k][along[k].size() - 1 - outliers];
  }
  return views;
}

/// Counts the columns of the image in which something lies far behind the plane above its highest pixel. What
/// lies close behind may be the reveal of a window.
void findUpperEdge(const InverseDepth& grid, const PlaneRemoval& removal, std::size_t k, PlaneView& view) {
  for (int u = 0; u < grid.camera.width; u += 2) {
    int top = 0;
    while (top < grid.camera.height && removal.of[grid.at(u, top)] != k + 1) ++top;
    if (top == grid.camera.height) continue;
    ++view.columns;
    for (int v = top - 1; v >= 0; --v) {
      if (!(grid.raw[grid.at(u, v)] > 0)) continue;
      const cv::Vec3d p = toVec(grid.point(u, v));
      if (distanceTo(removal.planes[k], p) >= behindMargin - shallow - marginAt(p[2])) continue;
      ++view.upperEdge;
      break;
    }
  }
}

/// Whether plane `wall` lies behind `front` as a wall behind furniture.
bool isWallBehind(const Plane& wall, const PlaneView& wallView, const Plane& front, const PlaneView& view) {
  const double gap = front.offset - wall.offset;
  return wall.normal.dot(front.normal) > parallel && gap > shallow && gap < deep &&
         wall.area > smallWall * front.area && wallView.left < view.right + wallGap &&
         view.left < wallView.right + wallGap;
}

/// For each pair of planes: number of pixels at convex edges between them, less three times the others.
cv::Mat_<int> convexEdges(const InverseDepth& grid, const PlaneRemoval& removal) {
  constexpr float continuous = 0.1F;
  constexpr int otherEdge = -3;
  const std::vector<Plane>& planes = removal.planes;
  const auto n = static_cast<int>(planes.size());
  cv::Mat_<int> edges(n, n, 0);
  const int reach = grid.pixels(6);
  for (int v = 0; v < grid.camera.height; ++v)
    for (int u = 0; u < grid.camera.width; ++u) {
      const std::size_t i = grid.at(u, v);
      const int k = removal.of[i];
      if (k == 0) continue;
      const cv::Point ends[] = {{u + reach, v}, {u, v + reach}};
      for (const cv::Point& end : ends) {
        if (end.x >= grid.camera.width || end.y >= grid.camera.height) continue;
        const std::size_t j = grid.at(end.x, end.y);
        const int l = removal.of[j];
        if (l == 0 || l == k || std::abs(grid.raw[i] - grid.raw[j]) > continuous * grid.raw[i]) continue;
        const bool convex = distanceTo(planes[static_cast<std::size_t>(k - 1)], toVec(grid.point(j))) < 0 &&
                            distanceTo(planes[static_cast<std::size_t>(l - 1)], toVec(grid.point(i))) < 0;
        edges(k - 1, l - 1) += convex ? 1 : otherEdge;
        edges(l - 1, k - 1) += convex ? 1 : otherEdge;
      }
    }
  return edges;
}

/// The other faces of things.
void spreadOverEdges(const InverseDepth& grid, const cv::Vec3d& up, PlaneRemoval& removal) {
  std::vector<Plane>& planes = removal.planes;
  if (std::ranges::all_of(planes, &Plane::structural)) return;
  const cv::Mat_<int> edges = convexEdges(grid, removal);
  for (bool changed = true; changed;) {
    changed = false;
    for (int k = 0; k < edges.rows; ++k) {
      Plane& plane = planes[static_cast<std::size_t>(k)];
      if (!plane.structural || !isUpright(plane, up)) continue;
      for (int j = 0; j < edges.cols; ++j)
        if (!planes[static_cast<std::size_t>(j)].structural && edges(k, j) >= minConvex)
          plane.structural = false;
      changed |= !plane.structural;
    }
  }
}

}  // namespace

cv::Vec3d upOf(const std::vector<Plane>& planes) {
  const cv::Vec3d imageUp(0, -1, 0);
  std::vector<cv::Vec3d> candidates;
  for (const Plane& p : planes) candidates.push_back(p.normal);
  for (const Plane& p : planes)
    for (const Plane& q : planes) candidates.push_back(p.normal.cross(q.normal));
  for (const Plane& p : planes) candidates.push_back(imageUp - imageUp.dot(p.normal) * p.normal);
  cv::Vec3d best = imageUp;
  double most = 0;
  for (const cv::Vec3d& candidate : candidates) {
    constexpr double minNorm = 0.1, more = 1 + 1e-6;
    if (cv::norm(candidate) < minNorm) continue;
    const cv::Vec3d c = cv::normalize(candidate[1] > 0 ? -candidate : candidate);
    if (c.dot(imageUp) < minUprightCosine) continue;
    double area = 0;
    for (const Plane& p : planes)
      area += std::abs(p.normal.dot(c)) > parallel || isUpright(p, c) ? p.area : 0;
    if (area > more * most) {
      most = area;
      best = c;
    }
  }
  return best;
}

void findStructure(const InverseDepth& grid, const cv::Vec3d& up, PlaneRemoval& removal) {
  std::vector<Plane>& planes = removal.planes;
  std::vector<PlaneView> views = viewsOf(grid, up, removal);
  std::vector<std::size_t> upright;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    if (!isUpright(planes[k], up)) {
      planes[k].structural = views[k].behind < few;
      continue;
    }
    findUpperEdge(grid, removal, k, views[k]);
    planes[k].structural = 2 * views[k].upperEdge <= views[k].columns;
    upright.push_back(k);
  }
  // Sort back to front: a plane in front of a wall cannot act as the wall behind another plane.
  std::ranges::stable_sort(upright, {}, [&](std::size_t k) { return planes[k].offset; });
  for (const std::size_t k : upright)
    for (const std::size_t j : upright)
      if (planes[j].structural && isWallBehind(planes[j], views[j], planes[k], views[k]))
        planes[k].structural = false;
  spreadOverEdges(grid, up, removal);
  for (std::size_t k = 0; k < planes.size(); ++k)
    if (isUpright(planes[k], up) && views[k].right - views[k].left < wallThickness)
      planes[k].structural = true;
}

}  // namespace estancia
