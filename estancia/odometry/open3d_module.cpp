// The only file that sees Open3D; compiled into a module that odometry/open3d.cpp opens on demand. Only the
// pieces of its RGB-D odometry are used that do without Intel's IPP, which Debian's Open3D lacks: pyramids
// are ours.
// SPDX-License-Identifier: Apache-2.0
#include <omp.h>
#include <open3d/core/EigenConverter.h>
#include <open3d/pipelines/registration/GlobalOptimization.h>
#include <open3d/pipelines/registration/PoseGraph.h>
#include <open3d/t/pipelines/odometry/RGBDOdometry.h>
#include <open3d/utility/Logging.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "estancia/odometry/open3d.hpp"

namespace estancia::odometry {
namespace {

namespace core = open3d::core;
namespace registration = open3d::pipelines::registration;
using open3d::t::pipelines::odometry::OdometryResult;
using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr float kDepthHuber = 0.05F, kGrayHuber = 0.1F;  // [m], [gray value]: Open3D's own

Matrix4 matrixOf(const Eigen::Matrix4d& eigen) {
  Matrix4 matrix;
  Eigen::Map<RowMajor4>(matrix.data()) = eigen;
  return matrix;
}

Eigen::Matrix4d eigenOf(const Matrix4& matrix) {
  return Eigen::Map<const RowMajor4>(matrix.data());
}

/// The image's own memory, not a copy: it outlives the step.
core::Tensor tensorOf(const cv::Mat& image) {
  const std::int64_t rows = image.rows, columns = image.cols, channels = image.channels();
  auto memory = std::make_shared<core::Blob>(core::Device("CPU:0"), image.data, [](void*) {});
  return {{rows, columns, channels}, {columns * channels, channels, 1}, image.data, core::Float32, memory};
}

OdometryResult stepOf(const PyramidLevel& source, const PyramidLevel& target, const core::Tensor& transform,
                      AlignmentTerm term, float beyond) {
  using namespace open3d::t::pipelines::odometry;
  const CameraIntrinsics& c = target.camera;
  const core::Tensor camera = core::Tensor::Init<double>({{c.fx, 0, c.cx}, {0, c.fy, c.cy}, {0, 0, 1}});
  switch (term) {
    case AlignmentTerm::depth:
      return ComputeOdometryResultPointToPlane(tensorOf(source.points), tensorOf(target.points),
                                               tensorOf(target.normals), camera, transform, beyond,
                                               std::min(kDepthHuber, beyond / 2));
    case AlignmentTerm::color:
      return ComputeOdometryResultIntensity(tensorOf(source.depth), tensorOf(target.depth),
                                            tensorOf(source.gray), tensorOf(target.gray),
                                            tensorOf(target.grayDx), tensorOf(target.grayDy),
                                            tensorOf(source.points), camera, transform, beyond, kGrayHuber);
    case AlignmentTerm::automatic:  // aligned by the other two in turn
    case AlignmentTerm::hybrid:
      return ComputeOdometryResultHybrid(
          tensorOf(source.depth), tensorOf(target.depth), tensorOf(source.gray), tensorOf(target.gray),
          tensorOf(target.depthDx), tensorOf(target.depthDy), tensorOf(target.grayDx),
          tensorOf(target.grayDy), tensorOf(source.points), camera, transform, beyond,
          std::min(kDepthHuber, beyond / 2), kGrayHuber);
  }
  return {};
}

/// Open3D's loops over pixels on the caller's thread alone, whichever of its two ways they take: sums are
/// added up in one order, and small images are quicker so than with threads that wait for each other.
class Alone {
 public:
  template <typename Work>
  static void run(const Work& work) {
    thread_local tbb::task_arena arena(1);
    const Alone alone;
    arena.execute(work);
  }

 private:
  // Not omp_set_num_threads(): Open3D asks for its number of threads by name.
  Alone() { omp_set_max_active_levels(0); }
  ~Alone() { omp_set_max_active_levels(before_); }
  const int before_ = omp_get_max_active_levels();
};

class Module : public Open3d {
 public:
  Module() { open3d::utility::SetVerbosityLevel(open3d::utility::VerbosityLevel::Error); }

  AlignmentStep step(const PyramidLevel& source, const PyramidLevel& target, const Matrix4& transform,
                     AlignmentTerm term, float beyond) const override {
    AlignmentStep step;
    Alone::run([&] {
      try {
        const auto guess = core::eigen_converter::EigenMatrixToTensor(eigenOf(transform));
        const OdometryResult result = stepOf(source, target, guess, term, beyond);
        step.correction = matrixOf(core::eigen_converter::TensorToEigenMatrixXd(result.transformation_));
        step.solved = std::ranges::all_of(step.correction, [](double v) { return std::isfinite(v); });
      } catch (const std::exception&) {  // a singular system: nothing, or a single plane, is seen
      }
    });
    return step;
  }

  bool optimize(std::vector<Matrix4>& nodes, const std::vector<PoseGraphEdge>& edges, double beyond,
                std::vector<bool>& kept) const override {
    registration::PoseGraph graph;
    for (const Matrix4& node : nodes) graph.nodes_.emplace_back(eigenOf(node));
    for (const PoseGraphEdge& e : edges)
      graph.edges_.emplace_back(static_cast<int>(e.source), static_cast<int>(e.target), eigenOf(e.transform),
                                Eigen::Map<const RowMajor6>(e.information.data()), e.uncertain);
    const registration::GlobalOptimizationOption option(beyond, 0.25, 1.0, 0);
    kept.assign(edges.size(), true);
    try {
      registration::GlobalOptimization(graph, registration::GlobalOptimizationLevenbergMarquardt(), {},
                                       option);
    } catch (const std::exception&) {
      return false;
    }
    // The pruned graph is a copy: wrong loops are out before the last round, and told by their confidence.
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Matrix4 node = matrixOf(graph.nodes_[i].pose_);
      if (!std::ranges::all_of(node, [](double v) { return std::isfinite(v); })) return false;
      nodes[i] = node;
    }
    if (graph.edges_.size() == edges.size()) {
      for (std::size_t i = 0; i < edges.size(); ++i)
        kept[i] = !edges[i].uncertain || graph.edges_[i].confidence_ > option.edge_prune_threshold_;
    } else {
      for (std::size_t i = 0; i < edges.size(); ++i)
        kept[i] = std::ranges::any_of(graph.edges_, [&](const registration::PoseGraphEdge& e) {
          return e.source_node_id_ == static_cast<int>(edges[i].source) &&
                 e.target_node_id_ == static_cast<int>(edges[i].target);
        });
    }
    return true;
  }
};

}  // namespace
}  // namespace estancia::odometry

extern "C" __attribute__((visibility("default"))) const estancia::odometry::Open3d* estanciaOpen3d() {
  static const estancia::odometry::Module module;
  return &module;
}
