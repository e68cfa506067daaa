// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/scales.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {
namespace {

/// To `perDecade` values a decade (Renard series for 10 and 20): the same in meters and in millimeters.
double rounded(double value, int perDecade) {
  return value > 0 ? std::pow(10, std::round(perDecade * std::log10(value)) / perDecade) : 0;
}

}  // namespace

RecognitionScales scalesFor(const RecognitionOptions& options, double resolution, double spacing,
                            double noise, double extent) {
  const auto orElse = [](double given, double automatic) { return given > 0 ? given : automatic; };
  if (options.surface != "mean")  // at 2 mm without noise and with 10 mm: 16 and 36 mm for normals
    return {.normalRadius =
                options.normalNeighbors > 0 ? 0 : orElse(options.normalRadius, 8 * resolution + 2 * noise),
            .keypointSpacing = orElse(options.keypointSpacing, 5 * resolution),
            .descriptorRadius = orElse(options.descriptorRadius, 18 * resolution + 2.5 * noise),
            .consistency = orElse(options.consistency, 5 * resolution + noise),
            .tolerance = orElse(options.tolerance, 3 * resolution + 0.6 * noise),
            .color = options.colorTolerance,
            .unit = resolution,
            .noise = noise,
            .spacing = spacing};
  constexpr double finest = 400, coarsest = 80;  // units across a model
  const double wanted = extent > 0 ? std::clamp(spacing, extent / finest, extent / coarsest) : spacing;
  // Less noise is invisible: the averages are wider.
  constexpr double hidden = 0.3;
  RecognitionScales scales;
  scales.unit = rounded(wanted, 10);
  scales.spacing = rounded(spacing, 10);
  scales.noise = std::max(rounded(noise, 20), rounded(hidden * scales.unit, 20));
  const double unit = scales.unit;
  scales.normalRadius =
      orElse(options.normalRadius, std::max({7 * unit, 3 * scales.noise, 2.5 * scales.spacing}));
  scales.keypointSpacing = orElse(options.keypointSpacing, 6 * unit);
  scales.descriptorRadius = orElse(options.descriptorRadius, 30 * unit);
  scales.consistency = orElse(options.consistency, 6 * unit);
  scales.tolerance = orElse(options.tolerance, 2.5 * unit);
  scales.color = options.colorTolerance;
  return scales;
}

MlsOptions smoothingFor(const RecognitionScales& scales) {
  const auto [unit, noise, spacing] = std::array{scales.unit, scales.noise, scales.spacing};
  MlsOptions smoothing;
  smoothing.leaf = std::max(2.2 * unit, 0.8 * noise);
  smoothing.radius = scales.normalRadius;
  smoothing.width = 2.28 * std::max({2.5 * unit, 1.2 * noise, 0.8 * spacing});
  smoothing.depth = std::max({5 * unit, 3.5 * noise, 2 * spacing});
  smoothing.spacing = 3.25 * unit;
  return smoothing;
}

}  // namespace estancia
