// Open3D interface: RGB-D odometry steps and pose graph optimization.
//
// Open3D depends on a hundred libraries, so it is in a module (open3d_module.cpp) that is opened when needed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "estancia/odometry/pyramid.hpp"

namespace estancia::odometry {

using Matrix4 = std::array<double, 16>;  ///< row-major rigid transform
using Matrix6 = std::array<double, 36>;  ///< row-major; rotation, then translation

/// What an alignment minimizes.
enum class AlignmentTerm {
  depth,     ///< point-to-plane distances; degenerate in front of a single wall
  color,     ///< differences of gray values; degenerate without texture
  hybrid,    ///< gray values and depth together
  automatic  ///< depth, and hybrid where depth alone is degenerate; no term of a single step
};

/// One Gauss–Newton step.
struct AlignmentStep {
  bool solved = false;   ///< false when the system is singular
  Matrix4 correction{};  ///< to be multiplied from the left to T_target_source
};

/// A measured T_target_source.
struct PoseGraphEdge {
  std::size_t source = 0, target = 0;
  Matrix4 transform{};
  Matrix6 information{};   ///< of the points in the target's frame
  bool uncertain = false;  ///< a loop closure, which may be an outlier
};

class Open3d {
 public:
  virtual ~Open3d() = default;

  /// `beyond`: largest difference in depth of corresponding points [m]. Runs on the caller's thread alone, so
  /// that the order of sums is fixed.
  virtual AlignmentStep step(const PyramidLevel& source, const PyramidLevel& target, const Matrix4& transform,
                             AlignmentTerm term, float beyond) const = 0;

  /// Poses T_map_node that agree best with the edges, by Levenberg–Marquardt with line processes (Choi et al.
  /// 2015); the first stays. `kept` says for every edge whether it is an inlier. False when that fails.
  virtual bool optimize(std::vector<Matrix4>& nodes, const std::vector<PoseGraphEdge>& edges, double beyond,
                        std::vector<bool>& kept) const = 0;
};

/// Opens the module once. Throws Error (missingDependency) when it is not installed.
const Open3d& open3d();

}  // namespace estancia::odometry
