// The module that optimizes pose graphs by Ceres; pose_graph.cpp opens it.
// SPDX-License-Identifier: Apache-2.0
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "estancia/odometry/pose_graph.hpp"

namespace estancia::odometry {
namespace {

#if __has_include(<ceres/manifold.h>)
using UnitQuaternion = ceres::QuaternionManifold;
#else  // Ceres 2.0
using UnitQuaternion = ceres::QuaternionParameterization;
#endif

/// Rotation (w, x, y, z) and position.
struct Node {
  std::array<double, 4> rotation;
  std::array<double, 3> position;
};

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

Node nodeOf(const cv::Affine3d& pose) {
  const cv::Matx33d r = pose.rotation();
  const Eigen::Quaterniond q(Eigen::Matrix3d(Eigen::Map<const RowMajor3>(r.val)));
  const cv::Vec3d t = pose.translation();
  return {{q.w(), q.x(), q.y(), q.z()}, {t[0], t[1], t[2]}};
}

cv::Affine3d affineOf(const Node& node) {
  const auto& [w, x, y, z] = node.rotation;
  cv::Matx33d r;
  Eigen::Map<RowMajor3>(r.val) = Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
  return {r, cv::Vec3d(node.position.data())};
}

/// measured · (T_target⁻¹ T_source)⁻¹ as a motion, in standard deviations.
class EdgeError {
 public:
  explicit EdgeError(const PoseGraphEdge& edge) : measured_(nodeOf(edge.transform)) {
    const Eigen::Matrix<double, 6, 6> covariance = Eigen::Map<const RowMajor6>(edge.covariance.val);
    whitening_ = covariance.inverse().llt().matrixU();
  }

  template <typename T>
  bool operator()(const T* targetRotation, const T* targetPosition, const T* sourceRotation,
                  const T* sourcePosition, T* residuals) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    using Rotation = Eigen::Quaternion<T>;
    const auto vectorOf = [](const T* v) { return Vector(v[0], v[1], v[2]); };
    const auto rotationOf = [](const T* q) { return Rotation(q[0], q[1], q[2], q[3]); };
    const Rotation toTarget = rotationOf(targetRotation).conjugate();
    const Rotation rotation = toTarget * rotationOf(sourceRotation);
    const Vector position = toTarget * (vectorOf(sourcePosition) - vectorOf(targetPosition));
    const auto& [w, x, y, z] = measured_.rotation;
    const Rotation difference = Rotation(T(w), T(x), T(y), T(z)) * rotation.conjugate();
    const Vector shift = Eigen::Map<const Eigen::Vector3d>(measured_.position.data()).template cast<T>() -
                         difference * position;
    const T quaternion[] = {difference.w(), difference.x(), difference.y(), difference.z()};
    Eigen::Matrix<T, 6, 1> motion;
    ceres::QuaternionToAngleAxis(quaternion, motion.data());
    motion.template tail<3>() = shift;
    Eigen::Map<Eigen::Matrix<T, 6, 1>> whitened(residuals);
    whitened = whitening_.template cast<T>() * motion;
    return true;
  }

 private:
  Node measured_;
  Eigen::Matrix<double, 6, 6> whitening_;
};

std::vector<double> optimize(std::vector<cv::Affine3d>& poses, const std::vector<PoseGraphEdge>& edges,
                             const std::vector<bool>& free) {
  std::vector<Node> nodes;
  for (const cv::Affine3d& pose : poses) nodes.push_back(nodeOf(pose));
  const auto isFree = [&](std::size_t i) { return i > 0 && (free.empty() || free[i]); };
  ceres::Problem problem;
  for (const PoseGraphEdge& edge : edges)
    for (const std::size_t i : {edge.target, edge.source}) {
      Node& node = nodes[i];
      if (problem.HasParameterBlock(node.position.data())) continue;
      problem.AddParameterBlock(node.rotation.data(), 4, new UnitQuaternion);
      problem.AddParameterBlock(node.position.data(), 3);
      if (isFree(i)) continue;
      problem.SetParameterBlockConstant(node.rotation.data());
      problem.SetParameterBlockConstant(node.position.data());
    }
  std::vector<ceres::ResidualBlockId> blocks;
  for (const PoseGraphEdge& edge : edges)
    blocks.push_back(problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<EdgeError, 6, 4, 3, 4, 3>(new EdgeError(edge)),
        new ceres::CauchyLoss(3), nodes[edge.target].rotation.data(), nodes[edge.target].position.data(),
        nodes[edge.source].rotation.data(), nodes[edge.source].position.data()));
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 100;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (summary.IsSolutionUsable())
    for (std::size_t i = 0; i < poses.size(); ++i)
      if (isFree(i)) poses[i] = affineOf(nodes[i]);
  std::vector<double> off;
  for (const ceres::ResidualBlockId block : blocks) {
    double cost = 0;
    problem.EvaluateResidualBlock(block, false, &cost, nullptr, nullptr);
    off.push_back(std::sqrt(2 * cost));
  }
  return off;
}

}  // namespace
}  // namespace estancia::odometry

extern "C" __attribute__((visibility("default"))) estancia::odometry::PoseGraphOptimizer
estanciaPoseGraphOptimizer() {
  return &estancia::odometry::optimize;
}
