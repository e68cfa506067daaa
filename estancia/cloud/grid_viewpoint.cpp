// The sensor of an organized cloud, from its rows and columns.
// SPDX-License-Identifier: Apache-2.0

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "estancia/cloud/viewpoint.hpp"

namespace estancia {
namespace {

struct Pixel {
  Eigen::Vector4d place;  // homogeneous, in units of the cloud's size around its mean
  double column, row;     // in units of half the width around the middle
};

std::vector<Pixel> pixelsOf(const PointCloud& cloud, Eigen::Vector3d& center, double& size) {
  constexpr std::size_t wanted = 4000;
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    if (isMeasured(cloud.points[i])) finite.push_back(i);
  const std::size_t step = std::max<std::size_t>(1, finite.size() / wanted);
  const auto placeOf = [&](std::size_t i) {
    const cv::Point3f& p = cloud.points[i];
    return Eigen::Vector3d(static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
  };
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < finite.size(); i += step) taken.push_back(finite[i]);
  center.setZero();
  for (const std::size_t i : taken) center += placeOf(i) / static_cast<double>(taken.size());
  size = 0;
  for (const std::size_t i : taken) size += (placeOf(i) - center).norm() / static_cast<double>(taken.size());
  std::vector<Pixel> pixels;
  if (!(size > 0)) return pixels;
  const double half = static_cast<double>(cloud.width) / 2, middle = static_cast<double>(cloud.height) / 2;
  for (const std::size_t i : taken) {
    const Eigen::Vector3d at = (placeOf(i) - center) / size;
    pixels.push_back({{at[0], at[1], at[2], 1},
                      (static_cast<double>(i % cloud.width) - half) / half,
                      (static_cast<double>(i / cloud.width) - middle) / half});
  }
  return pixels;
}

}  // namespace

std::optional<cv::Point3d> viewpointOfGrid(const PointCloud& cloud) {
  constexpr std::size_t minPixels = 100;
  constexpr double maxError = 1;  // [pixels], median
  constexpr double clearly = 30;  // times the smallest eigenvalue: the points do not lie in a plane
  if (!cloud.organized() || cloud.width < 2) return {};
  Eigen::Vector3d center;
  double size = 0;
  const std::vector<Pixel> pixels = pixelsOf(cloud, center, size);
  if (pixels.size() < minPixels) return {};

  // Direct linear transform (Hartley and Zisserman, 7.1): a row x P₃ − P₁ = 0 and one y P₃ − P₂ = 0 a pixel
  Eigen::Matrix<double, 12, 12> sums = Eigen::Matrix<double, 12, 12>::Zero();
  for (const Pixel& p : pixels) {
    Eigen::Matrix<double, 2, 12> rows = Eigen::Matrix<double, 2, 12>::Zero();
    rows.block<1, 4>(0, 0) = rows.block<1, 4>(1, 4) = -p.place.transpose();
    rows.block<1, 4>(0, 8) = p.column * p.place.transpose();
    rows.block<1, 4>(1, 8) = p.row * p.place.transpose();
    sums.noalias() += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>> solver(sums);
  if (solver.info() != Eigen::Success) return {};
  const double rounding = 1e-13 * solver.eigenvalues()[11];
  if (!(solver.eigenvalues()[1] > clearly * std::max(solver.eigenvalues()[0], rounding))) return {};
  const Eigen::Matrix<double, 12, 1> best = solver.eigenvectors().col(0);
  Eigen::Matrix<double, 3, 4> projection;
  for (int r = 0; r < 3; ++r) projection.row(r) = best.segment<4>(4 * r).transpose();

  std::vector<double> errors;
  for (const Pixel& p : pixels) {
    const Eigen::Vector3d at = projection * p.place;
    errors.push_back(std::hypot(at[0] / at[2] - p.column, at[1] / at[2] - p.row));
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  if (!(*middle * static_cast<double>(cloud.width) / 2 <= maxError)) return {};

  // The center of projection is what the matrix maps to 0.
  const Eigen::JacobiSVD<Eigen::Matrix<double, 3, 4>> svd(projection, Eigen::ComputeFullV);
  const Eigen::Vector4d null = svd.matrixV().col(3);
  const Eigen::Vector3d at = center + size * null.head<3>() / null[3];
  if (!at.allFinite()) return {};
  return cv::Point3d(at[0], at[1], at[2]);
}

}  // namespace estancia
