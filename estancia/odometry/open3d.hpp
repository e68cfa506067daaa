// What Estancia has Open3D do. Open3D brings a hundred libraries along, so it lives in a module of its own
// (open3d_module.cpp) that is opened when it is first needed.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "estancia/odometry/pyramid.hpp"

namespace estancia::odometry {

using Matrix4 = std::array<double, 16>;  ///< row-major rigid transform
using Matrix6 = std::array<double, 36>;  ///< row-major; rotation, then translation

/// What an alignment makes small.
enum class AlignmentTerm {
  depth,     ///< distances of points from planes; sees nothing in front of one flat wall
  color,     ///< differences of gray values; sees nothing without texture
  hybrid,    ///< gray values and depth together
  automatic  ///< depth, and where that leaves a direction open, hybrid; no term of a single step
};

/// One Gauss–Newton step.
struct AlignmentStep {
  bool solved = false;   ///< false where too little is seen to tell
  Matrix4 correction{};  ///< to be multiplied from the left to T_target_source
};

/// "T_target_source was seen to be this."
struct PoseGraphEdge {
  std::size_t source = 0, target = 0;
  Matrix4 transform{};
  Matrix6 information{};   ///< of the points in the target's frame
  bool uncertain = false;  ///< a loop: may be wrong, and is then outvoted
};

class Open3d {
 public:
  virtual ~Open3d() = default;

  /// `beyond`: points that differ by more in depth do not belong together [m]. Runs on the caller's thread
  /// alone, so that sums are added up in one order.
  virtual AlignmentStep step(const PyramidLevel& source, const PyramidLevel& target, const Matrix4& transform,
                             AlignmentTerm term, float beyond) const = 0;

  /// Poses T_map_node that agree best with the edges, by Levenberg–Marquardt with line processes (Choi et al.
  /// 2015); the first stays. `kept` tells for every edge whether it was believed. False when that fails.
  virtual bool optimize(std::vector<Matrix4>& nodes, const std::vector<PoseGraphEdge>& edges, double beyond,
                        std::vector<bool>& kept) const = 0;
};

/// Opens the module once. Throws Error that says what to install when it is not there.
const Open3d& open3d();

}  // namespace estancia::odometry
