// ESF (ensemble of shape functions): distances, angles and areas between random points of a cloud.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/describe/descriptor.hpp"

namespace estancia {

struct EsfOptions {
  int samples = 20000;
  int points = 20000;
  std::uint64_t seed = 1;
};
OptionGroup declare(EsfOptions& options);

/// 640 numbers ≥ 0 that add up to 1, ten histograms of 64: of triples of points the angles, the areas and the
/// distances, each for lines inside of the surface, outside, and both; and for the last the share inside.
/// Points that are not finite are left out; invariant to position, orientation and scale. The result depends
/// on cloud, options and seed only, to the byte. Throws Error (insufficientData) on fewer than three points
/// or collinear ones, and on invalid options.
///
/// Wohlkinger, Vincze: Ensemble of shape functions for 3D object classification, ROBIO 2011, with the
/// parameters, limits and weights of PCL 1.13's ESFEstimation: equal to it in distribution.
std::vector<float> esf(const PointCloud& cloud, const EsfOptions& options = {});

/// esf() of the view's depth.
class Esf final : public Descriptor {
 public:
  explicit Esf(const EsfOptions& options = {});
  std::vector<DescriptorPart> parts() const override;
  bool needsImage() const override { return false; }
  bool needsDepth() const override { return true; }
  std::vector<float> describe(const View& view) const override;

 private:
  EsfOptions options_;
};

}  // namespace estancia
