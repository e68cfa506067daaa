// SPDX-License-Identifier: Apache-2.0
#include "places/place_recognition.hpp"

#include <cmath>
#include <limits>

namespace estancia::experiments {
namespace {

bool within(double radius, const Position& a, const Position& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) <= radius;
}

}  // namespace

PlaceRecognition recognizePlaces(const PlacedImages& queries, const PlacedImages& images,
                                 Comparison comparison, double radius, std::size_t gap) {
  PlaceRecognition result;
  for (std::size_t q = 0; q < queries.vectors.size(); ++q) {
    std::size_t allowed = 0, same = 0;
    double nearest = std::numeric_limits<double>::infinity();
    bool right = false;
    for (std::size_t i = 0; i < images.vectors.size(); ++i) {
      const std::size_t a = queries.frames[q], b = images.frames[i];
      if (gap > 0 && (a > b ? a - b : b - a) <= gap) continue;
      const bool here = within(radius, queries.positions[q], images.positions[i]);
      ++allowed;
      same += here ? 1 : 0;
      const double d = compare(comparison, queries.vectors.row(q), images.vectors.row(i));
      if (d < nearest) {
        nearest = d;
        right = here;
      }
    }
    if (same == 0) continue;
    ++result.queries;
    result.right += right ? 1 : 0;
    result.chance += static_cast<double>(same) / static_cast<double>(allowed);
  }
  if (result.queries > 0) {
    result.right /= static_cast<double>(result.queries);
    result.chance /= static_cast<double>(result.queries);
  }
  return result;
}

}  // namespace estancia::experiments
