// Normals of a neural gas, from its graph.
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>

#include "estancia/cloud/growing_neural_gas.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// Adjacency lists of all neurons, one after the other.
class Adjacency {
 public:
  explicit Adjacency(const NeuralGas& gas) : first_(gas.cloud.points.size() + 1), all_(2 * gas.edges.size()) {
    const std::size_t neurons = gas.cloud.points.size();
    for (const auto& edge : gas.edges)
      for (const std::uint32_t end : edge) {
        if (end >= neurons)
          fail(ErrorCode::invalidInput,
               "an edge of the graph has neuron {}, but there are {}; give edges and neurons "
               "of one graph",
               end, neurons);
        ++first_[end + 1];
      }
    for (std::size_t i = 0; i < neurons; ++i) first_[i + 1] += first_[i];
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const auto& [a, b] : gas.edges) {
      all_[next[a]++] = b;
      all_[next[b]++] = a;
    }
  }
  /// Appends the neighbors of i.
  void append(std::uint32_t i, std::vector<std::uint32_t>& to) const {
    to.insert(to.end(), all_.begin() + static_cast<std::ptrdiff_t>(first_[i]),
              all_.begin() + static_cast<std::ptrdiff_t>(first_[i + 1]));
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> all_;
};

cv::Point3f normal(const std::vector<cv::Point3f>& points, const std::vector<std::uint32_t>& members) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  cv::Vec3d mean;
  for (const std::uint32_t i : members) mean += cv::Vec3d(points[i].x, points[i].y, points[i].z);
  mean /= static_cast<double>(members.size());
  cv::Matx33d covariance = cv::Matx33d::zeros();
  for (const std::uint32_t i : members) {
    const cv::Vec3d d = cv::Vec3d(points[i].x, points[i].y, points[i].z) - mean;
    covariance += d * d.t();
  }
  cv::Vec3d values;
  cv::Matx33d vectors;
  cv::eigen(covariance, values, vectors);  // the largest first
  // Collinear points have no normal; smaller variances are rounding.
  if (!(values[1] > 1e-10 * values[0])) return {none, none, none};
  return {static_cast<float>(vectors(2, 0)), static_cast<float>(vectors(2, 1)),
          static_cast<float>(vectors(2, 2))};
}

}  // namespace

std::vector<cv::Point3f> normalsFromGraph(const NeuralGas& gas, const cv::Point3f& viewpoint) {
  const std::vector<cv::Point3f>& points = gas.cloud.points;
  const Adjacency neighbors(gas);
  std::vector<cv::Point3f> normals(points.size());
  std::vector<std::uint32_t> ring, members;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    ring.clear();
    neighbors.append(i, ring);
    members = {i};
    for (const std::uint32_t n : ring) {
      members.push_back(n);
      neighbors.append(n, members);
    }
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    cv::Point3f n = normal(points, members);
    if (n.dot(viewpoint - points[i]) < 0) n = -n;
    normals[i] = n;
  }
  return normals;
}

}  // namespace estancia
