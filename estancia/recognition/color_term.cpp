// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/color_term.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace estancia {
namespace {

/// Least squares of the color differences to the neighbors over their tangential offsets.
cv::Matx33f gradientAt(const Surface& surface, std::uint32_t i, std::span<const Neighbor> near) {
  const cv::Point3f &p = surface.points()[i], &n = surface.normals()[i];
  Eigen::Matrix3d offsets = Eigen::Matrix3d::Zero(), products = Eigen::Matrix3d::Zero();
  for (const Neighbor& neighbor : near) {
    cv::Point3f d = surface.points()[neighbor.index] - p;
    d -= n.dot(d) * n;
    const cv::Vec3f change = surface.lab()[neighbor.index] - surface.lab()[i];
    const Eigen::Vector3d offset(d.x, d.y, d.z);
    offsets += offset * offset.transpose();
    products += Eigen::Vector3d(change[0], change[1], change[2]) * offset.transpose();
  }
  // The gradient has no part along the normal, which the offsets leave open.
  const Eigen::Vector3d normal(n.x, n.y, n.z);
  const double scale = offsets.trace();
  if (!(scale > 0)) return cv::Matx33f::zeros();
  const Eigen::Matrix3d closed =
      offsets + scale * normal * normal.transpose() + 1e-6 * scale * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d gradient = closed.ldlt().solve(products.transpose()).transpose();
  cv::Matx33f rows;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rows(r, c) = static_cast<float>(gradient(r, c));
  return rows;
}

}  // namespace

std::vector<cv::Matx33f> colorGradients(const Surface& surface, double radius, int threads) {
  std::vector<cv::Matx33f> gradients;
  if (surface.lab().empty()) return gradients;
  gradients.resize(surface.size());
  surface.neighbors().eachWithin(
      static_cast<float>(radius), threads,
      [&](std::uint32_t i, std::span<const Neighbor> near) { gradients[i] = gradientAt(surface, i, near); });
  return gradients;
}

ColorTerm::ColorTerm(const std::vector<cv::Vec3f>& model, const Surface& scene,
                     const std::vector<cv::Matx33f>* gradients, double tolerance)
    : model_(model),
      scene_(scene),
      gradients_(gradients),
      tolerance_(model.empty() || gradients == nullptr || gradients->empty() ? 0 : tolerance) {}

void ColorTerm::add(std::size_t i, std::size_t k, const cv::Point3f& p, const cv::Point3f& middle,
                    double size, double weight, double reach, Matrix6& left, Vector6& right) {
  if (!on()) return;
  const cv::Matx33f& gradient = (*gradients_)[k];
  const cv::Point3f &q = scene_.points()[k], &n = scene_.normals()[k];
  cv::Point3f offset = p - q;
  offset -= n.dot(offset) * n;
  const cv::Vec3f there = scene_.lab()[k] + gradient * cv::Vec3f(offset.x, offset.y, offset.z);
  const cv::Vec3d difference = cv::Vec3d(model_[i]) - cv::Vec3d(there);
  sum_ += weight * difference;
  weights_ += weight;
  if (first_) return;
  const double scaled = weight * reach * reach / (tolerance_ * tolerance_);
  for (int c = 0; c < 3; ++c) {
    const cv::Point3f slope(gradient(c, 0), gradient(c, 1), gradient(c, 2));
    const cv::Point3f lever = (p - middle).cross(slope);
    const double channel = c == 0 ? scaled / 4 : scaled;  // weighted as in colorDifference()
    Vector6 row;
    row << lever.x / size, lever.y / size, lever.z / size, slope.x, slope.y, slope.z;
    left.noalias() += channel * row * row.transpose();
    right.noalias() += channel * (difference[c] - shared_[c]) * row;
  }
}

void ColorTerm::endRound() {
  if (weights_ > 0) shared_ = sum_ / weights_;
  sum_ = {};
  weights_ = 0;
  first_ = false;
}

}  // namespace estancia
