// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/label_places.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace estancia::report {

LabelPlaces::LabelPlaces(double width, double height, const std::vector<Point>& centers,
                         const std::vector<double>& radii,
                         std::vector<std::pair<std::size_t, std::size_t>> lines)
    : frame_{4, 4, width - 8, height - 8}, centers_(centers), radii_(radii), lines_(std::move(lines)) {}

std::optional<LabelPlace> LabelPlaces::take(std::size_t disc, double width, double height) {
  constexpr std::array<std::array<int, 2>, 8> sides{
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
  const Point& center = centers_[disc];
  std::optional<LabelPlace> best;
  double bestCost = 1e9;
  for (std::size_t side = 0; side < sides.size(); ++side) {
    const auto [dx, dy] = sides[side];
    const double reach = (radii_[disc] + 4) * (dx != 0 && dy != 0 ? std::sqrt(0.5) : 1);
    const double x = center.x + dx * (reach + width / 2);
    const double y = center.y + dy * (reach + height / 2);
    const Box box{x - width / 2, y - height / 2, width, height};
    const LabelPlace place{box, dx == 0 ? center.x : x - dx * width / 2,  // text begins or ends at its disc
                           dx == 0  ? "middle"
                           : dx > 0 ? "start"
                                    : "end"};
    if (!isInside(place) || !isFree(box)) continue;
    double cost = 0.1 * static_cast<double>(side);
    for (const auto& [a, b] : lines_)
      if (box.crosses(centers_[a], centers_[b])) cost += 1;
    if (cost >= bestCost) continue;
    bestCost = cost;
    best = place;
  }
  if (best) taken_.push_back(best->box);
  return best;
}

/// Readers' fonts run up to a fourth wider than what is estimated. Where labels touch then, they can still be
/// read; what leaves the frame is lost.
bool LabelPlaces::isInside(const LabelPlace& place) const {
  Box box = place.box;
  const double more = box.width / 4;
  box.width += more;
  if (place.anchor != "start") box.x -= place.anchor == "end" ? more : more / 2;
  return box.inside(frame_);
}

bool LabelPlaces::isFree(const Box& box) const {
  for (std::size_t i = 0; i < centers_.size(); ++i)
    if (box.overlapsCircle(centers_[i], radii_[i] + 3)) return false;
  const Box withAir{box.x - 3, box.y, box.width + 6, box.height};  // words side by side would read as one
  return std::ranges::none_of(taken_, [&](const Box& other) { return other.overlaps(withAir); });
}

bool Thumbnails::isFree(const Box& box) const {
  return box.inside(frame_) &&
         std::ranges::none_of(taken_, [&box](const Box& other) { return other.overlaps(box); });
}

std::optional<Box> Thumbnails::take(const Point& at) {
  constexpr double gap = 2;
  constexpr std::array<Point, 9> sides{
      {{0, 0}, {0, -1}, {1, 0}, {-1, 0}, {0, 1}, {1, -1}, {-1, -1}, {1, 1}, {-1, 1}}};
  for (const double size : {size_, 0.72 * size_})
    for (const Point& side : sides) {
      // Beside its point the image leaves it to be seen.
      const double away = size / 2 + 6;
      const Point middle{at.x + away * side.x, at.y + away * side.y};
      const Box box{middle.x - size / 2, middle.y - size / 2, size, size};
      if (!isFree({box.x - gap, box.y - gap, size + 2 * gap, size + 2 * gap})) continue;
      taken_.push_back(box);
      return box;
    }
  return std::nullopt;
}

}  // namespace estancia::report
