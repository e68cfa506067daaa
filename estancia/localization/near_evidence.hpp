// Near evidence: how much more probable a distance of descriptors is when two frames were taken near each
// other. Private. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace estancia {

/// The likelihood ratio p(distance | near) / p(distance | far), each a Gaussian, made to fall with the
/// distance.
class NearEvidence {
 public:
  /// Distances of pairs of frames of a map that were taken near each other, and of any others; neither empty.
  NearEvidence(const std::vector<float>& near, const std::vector<float>& far);

  double ratio(double distance) const;

 private:
  static constexpr std::size_t samples = 64;
  double first_, step_;
  /// Logarithms of the ratio.
  std::vector<double> log_;
};

}  // namespace estancia
