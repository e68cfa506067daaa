#include "estancia/recognition/lengths.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {
namespace {

/// To `perDecade` numbers a decade (Renard's series for 10 and 20): the same in meters and in millimeters.
double rounded(double value, int perDecade) {
  return value > 0 ? std::pow(10, std::round(perDecade * std::log10(value)) / perDecade) : 0;
}

}  // namespace

RecognitionLengths lengthsFor(const RecognitionOptions& options, double resolution, double spacing,
                              double noise, double extent) {
  const auto or_ = [](double given, double automatic) { return given > 0 ? given : automatic; };
  if (options.surface != "mean")  // at 2 mm without noise and with 10 mm: 16 and 36 mm for normals
    return {.normalRadius =
                options.normalNeighbors > 0 ? 0 : or_(options.normalRadius, 8 * resolution + 2 * noise),
            .keypointSpacing = or_(options.keypointSpacing, 5 * resolution),
            .descriptorRadius = or_(options.descriptorRadius, 18 * resolution + 2.5 * noise),
            .consistency = or_(options.consistency, 5 * resolution + noise),
            .tolerance = or_(options.tolerance, 3 * resolution + 0.6 * noise),
            .unit = resolution,
            .noise = noise,
            .spacing = spacing};
  constexpr double finest = 400, coarsest = 80;  // parts of a model
  const double wanted = extent > 0 ? std::clamp(spacing, extent / finest, extent / coarsest) : spacing;
  // Less noise than that does not show: the averages are wider.
  constexpr double hidden = 0.3;
  RecognitionLengths lengths;
  lengths.unit = rounded(wanted, 10);
  lengths.spacing = rounded(spacing, 10);
  lengths.noise = std::max(rounded(noise, 20), rounded(hidden * lengths.unit, 20));
  const double unit = lengths.unit;
  lengths.normalRadius =
      or_(options.normalRadius, std::max({7 * unit, 3 * lengths.noise, 2.5 * lengths.spacing}));
  lengths.keypointSpacing = or_(options.keypointSpacing, 6 * unit);
  lengths.descriptorRadius = or_(options.descriptorRadius, 30 * unit);
  lengths.consistency = or_(options.consistency, 6 * unit);
  lengths.tolerance = or_(options.tolerance, 2.5 * unit);
  return lengths;
}

MeanSurfaceOptions smoothingFor(const RecognitionLengths& lengths) {
  const auto [unit, noise, spacing] = std::array{lengths.unit, lengths.noise, lengths.spacing};
  MeanSurfaceOptions smoothing;
  smoothing.leaf = std::max(2.2 * unit, 0.8 * noise);
  smoothing.radius = lengths.normalRadius;
  smoothing.width = 2.28 * std::max({2.5 * unit, 1.2 * noise, 0.8 * spacing});
  smoothing.depth = std::max({5 * unit, 3.5 * noise, 2 * spacing});
  smoothing.spacing = 3.25 * unit;
  return smoothing;
}

}  // namespace estancia
