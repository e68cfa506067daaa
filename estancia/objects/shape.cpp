// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/shape.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/describe/esf.hpp"

namespace estancia {
namespace {

EsfOptions esfOptions(const ShapeOptions& options) {
  return {.samples = options.samples, .seed = options.seed};
}

/// Standard deviations along the principal axes, largest first, and the largest distance from the center [m].
std::array<float, 4> sizeOf(const PointCloud& cloud) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double count = 0;
  const auto eachOffset = [&](const auto& use) {
    for (const cv::Point3f& p : cloud.points)
      if (isFinite(p)) use(Eigen::Vector3d(p.x, p.y, p.z) - center);
  };
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  eachOffset([&](const Eigen::Vector3d& p) {
    sum += p;
    ++count;
  });
  center = sum / count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double maxDistance = 0;
  eachOffset([&](const Eigen::Vector3d& d) {
    scatter += d * d.transpose();
    maxDistance = std::max(maxDistance, d.squaredNorm());
  });
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter / count, Eigen::EigenvaluesOnly);
  const auto deviation = [&](int axis) {
    return static_cast<float>(std::sqrt(std::max(solver.eigenvalues()[axis], 0.0)));
  };
  return {deviation(2), deviation(1), deviation(0), static_cast<float>(std::sqrt(maxDistance))};
}

}  // namespace

OptionGroup declare(ShapeOptions& options) {
  OptionGroup group("shape", "Shape descriptor of objects.");
  group.add("samples", &options.samples, "Triples of points that ESF draws.")
      .range(1, 1'000'000)
      .why("fewer are faster and noisier");
  group.add("size", &options.size, "Also describe the metric size.")
      .why("if objects of different classes have the same shape, but other sizes");
  group.add("threads", &options.threads, "Threads; 0: one a usable core. The numbers do not depend on it.")
      .range(0);
  return group;
}

std::vector<float> describeShape(const PointCloud& cloud, const ShapeOptions& options) {
  std::vector<float> numbers = esf(cloud, esfOptions(options));
  if (options.size) std::ranges::copy(sizeOf(cloud), std::back_inserter(numbers));
  return numbers;
}

Features noShapes(const ShapeOptions& options) {
  Features none{Esf(esfOptions(options)).parts(), {}, DescriptorMatrix(0)};
  if (options.size)
    none.parts.push_back({"size",
                          PartKind::energies,
                          {"largest spread", "middle spread", "smallest spread", "radius"},
                          "size 1 in meters"});
  std::size_t columns = 0;
  for (const DescriptorPart& part : none.parts) columns += part.size();
  none.values = DescriptorMatrix(columns);
  return none;
}

Features describeShapes(const ObjectViews& views, const ShapeOptions& options, Progress& progress,
                        std::vector<std::string>* problems) {
  Features features = noShapes(options);
  std::vector<std::vector<float>> rows(views.size());
  std::vector<std::string> reasons(views.size());
  progress.begin(fmt::format("describing the shapes of {}", views.name()), views.size());
  inParallel(views.size(), options.threads, progress, "stopped while describing shapes; nothing was written",
             [&](std::size_t i) {
               try {
                 rows[i] = describeShape(views.cloud(i), options);
               } catch (...) {
                 const std::string& name = views.view(i).name;
                 reasons[i] = fmt::format("{}: {}", name, frameFailure(name).what());
               }
             });
  progress.end();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].empty()) continue;
    Frame& frame = features.frames.emplace_back();
    frame.name = views.view(i).name;
    frame.room = views.view(i).category;
    features.values.append(rows[i]);
  }
  std::erase(reasons, "");
  if (features.frames.empty())
    fail(ErrorCode::insufficientData, "{}: none of its {} views can be described{}", views.name(),
         views.size(), reasons.empty() ? "" : "; " + reasons.front());
  if (problems != nullptr) problems->insert(problems->end(), reasons.begin(), reasons.end());
  return features;
}

}  // namespace estancia
