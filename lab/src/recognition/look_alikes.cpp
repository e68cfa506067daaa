// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include "recognition/color_cases.hpp"
#include "recognition/pose_error.hpp"

namespace estancia::experiments {
namespace {

constexpr double radius = 0.033, canHeight = 0.115;  // [m], of a drink
constexpr double halfWidth = 0.06, halfDepth = 0.04, boxHeight = 0.18;
constexpr std::size_t variants = 4;
constexpr double never = std::numeric_limits<double>::infinity();

/// BGR.
const std::array<cv::Vec3d, variants> palette{
    cv::Vec3d(50, 50, 190), {60, 150, 60}, {180, 90, 50}, {50, 190, 210}};
const cv::Vec3d metal(165, 165, 165), paper(220, 220, 220), wood(110, 150, 180);

enum class Kind { plainCan, printedCan, box };
constexpr std::array<std::pair<Kind, const char*>, 3> kinds{
    {{Kind::plainCan, "plain cans"}, {Kind::printedCan, "printed cans"}, {Kind::box, "boxes"}}};

/// A place on a thing's surface, in its frame: z up, the origin in the middle of its foot.
struct Placement {
  cv::Vec3d at, normal;
};

cv::Vec3d colorOf(Kind kind, std::size_t variant, const Placement& place) {
  if (place.normal[2] > 0.5) return metal;
  if (kind == Kind::plainCan) return palette[variant];
  if (kind == Kind::printedCan) {
    const auto column = static_cast<std::uint32_t>(
        std::floor((std::atan2(place.at[1], place.at[0]) / std::numbers::pi + 1) * 4));
    const auto row = static_cast<std::uint32_t>(std::clamp(place.at[2] / canHeight * 4, 0.0, 3.0));
    std::mt19937 draw(static_cast<std::uint32_t>(variant) * 1000 + (column % 8) * 10 + row);
    return draw() % 2 == 0 ? palette[0] : paper;
  }
  // Boxes have the four colors in another order each.
  constexpr std::size_t orders[variants][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 1, 3, 2}, {0, 3, 2, 1}};
  const std::size_t side =
      std::abs(place.normal[0]) > 0.5 ? (place.normal[0] > 0 ? 0 : 2) : (place.normal[1] > 0 ? 1 : 3);
  return palette[orders[variant][side]];
}

/// Where a ray meets a thing first, as a multiple of `d`.
double meetCan(const cv::Vec3d& o, const cv::Vec3d& d, Placement& place) {
  const double a = d[0] * d[0] + d[1] * d[1], b = o[0] * d[0] + o[1] * d[1],
               c = o[0] * o[0] + o[1] * o[1] - radius * radius, root = b * b - a * c;
  double t = never;
  if (a > 0 && root >= 0) {
    const double side = (-b - std::sqrt(root)) / a;
    const cv::Vec3d at = o + side * d;
    if (side > 0 && at[2] >= 0 && at[2] <= canHeight) {
      t = side;
      place = {at, cv::Vec3d(at[0] / radius, at[1] / radius, 0)};
    }
  }
  const double top = (canHeight - o[2]) / d[2];
  const cv::Vec3d at = o + top * d;
  if (top > 0 && top < t && at[0] * at[0] + at[1] * at[1] <= radius * radius) {
    t = top;
    place = {at, cv::Vec3d(0, 0, 1)};
  }
  return t;
}

double meetBox(const cv::Vec3d& o, const cv::Vec3d& d, Placement& place) {
  const cv::Vec3d low(-halfWidth, -halfDepth, 0), high(halfWidth, halfDepth, boxHeight);
  double enter = 0, leave = never;
  int axis = -1;
  for (int k = 0; k < 3; ++k) {
    double from = (low[k] - o[k]) / d[k], to = (high[k] - o[k]) / d[k];
    if (from > to) std::swap(from, to);
    if (from > enter) {
      enter = from;
      axis = k;
    }
    leave = std::min(leave, to);
  }
  if (axis < 0 || enter > leave) return never;
  place = {o + enter * d, {}};
  place.normal[axis] = d[axis] > 0 ? -1 : 1;
  return enter;
}

double meet(Kind kind, const cv::Vec3d& o, const cv::Vec3d& d, Placement& place) {
  return kind == Kind::box ? meetBox(o, d, place) : meetCan(o, d, place);
}

/// All sides of a thing but its foot.
std::vector<Placement> surfaceOf(Kind kind) {
  constexpr double step = 0.0015;
  std::vector<Placement> places;
  const auto across = [](double from, double to, const auto& use) {
    for (double v = from + step / 2; v < to; v += step) use(v);
  };
  if (kind == Kind::box) {
    across(0, boxHeight, [&](double z) {
      for (const double sign : {-1.0, 1.0}) {
        across(-halfDepth, halfDepth, [&](double y) {
          places.push_back({{sign * halfWidth, y, z}, {sign, 0, 0}});
        });
        across(-halfWidth, halfWidth, [&](double x) {
          places.push_back({{x, sign * halfDepth, z}, {0, sign, 0}});
        });
      }
    });
    across(-halfWidth, halfWidth, [&](double x) {
      across(-halfDepth, halfDepth, [&](double y) { places.push_back({{x, y, boxHeight}, {0, 0, 1}}); });
    });
    return places;
  }
  across(0, 2 * std::numbers::pi * radius, [&](double along) {
    const double angle = along / radius - std::numbers::pi, x = std::cos(angle), y = std::sin(angle);
    across(0, canHeight, [&](double z) { places.push_back({{radius * x, radius * y, z}, {x, y, 0}}); });
  });
  across(-radius, radius, [&](double x) {
    across(-radius, radius, [&](double y) {
      if (x * x + y * y < radius * radius) places.push_back({{x, y, canHeight}, {0, 0, 1}});
    });
  });
  return places;
}

cv::Vec3b levels(const cv::Vec3d& color) {
  return {cv::saturate_cast<uchar>(color[0]), cv::saturate_cast<uchar>(color[1]),
          cv::saturate_cast<uchar>(color[2])};
}

ColorCases::Model modelOf(Kind kind, const char* name, std::size_t variant) {
  constexpr int fold = 72;  // symmetry of a plain can, for which every angle is equivalent
  ColorCases::Model model{fmt::format("{} {}", name, variant), name, {}, {}};
  for (const Placement& place : surfaceOf(kind)) {
    model.cloud.points.emplace_back(cv::Point3f(cv::Vec3f(place.at)));
    model.cloud.colors.push_back(levels(0.85 * colorOf(kind, variant, place)));
  }
  model.cloud.width = model.cloud.points.size();
  model.cloud.height = 1;
  if (kind == Kind::plainCan) model.symmetries = turnsAround(centerOf(model.cloud), {0, 0, 1}, fold);
  return model;
}

/// A thing on the table.
struct Standing {
  std::size_t variant;
  cv::Affine3d pose;  ///< T_camera_thing
};

/// What a camera sees of them.
class Renderer {
 public:
  Renderer(Kind kind, std::uint64_t seed) : kind_(kind), random_(seed) {
    const double side = random_.uniform(-0.7, 0.7);
    light_ = up_ * 0.8 + cv::Vec3d(side, 0, -0.6);
    light_ *= 1 / cv::norm(light_);
    gain_ = random_.uniform(0.85, 1.15);
  }

  /// Stands on the table: `x` [m] to the right of the middle, `y` further away, turned.
  cv::Affine3d placeAt(double x, double y, double yaw) const {
    const cv::Vec3d right(1, 0, 0), away = right.cross(up_) * -1.0;
    const cv::Matx33d frame(right[0], away[0], up_[0], right[1], away[1], up_[1], right[2], away[2], up_[2]);
    const cv::Affine3d turn(cv::Vec3d(0, 0, yaw));
    return {frame * turn.rotation(), foot_ + x * right + y * away};
  }

  cv::RNG& random() { return random_; }

  PointCloud render(const std::vector<Standing>& things) {
    constexpr int width = 320, height = 240;  // the middle of an image of 640 × 480
    constexpr double focal = 525, noise = 0.0012, colorNoise = 3;
    PointCloud cloud;
    cloud.width = width;
    cloud.height = height;
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column) {
        const cv::Vec3d ray((column - 159.5) / focal, (row - 119.5) / focal, 1);
        cv::Vec3d color = wood, normal = up_;
        double depth = up_.dot(foot_) / up_.dot(ray);
        if (!(depth > 0)) depth = never;
        for (const Standing& thing : things) {
          const cv::Matx33d back = thing.pose.rotation().t();
          Placement place;
          const double t = meet(kind_, back * -cv::Vec3d(thing.pose.translation()), back * ray, place);
          if (t >= depth) continue;
          depth = t;
          color = colorOf(kind_, thing.variant, place);
          normal = thing.pose.rotation() * place.normal;
        }
        const double shade = gain_ * (0.6 + 0.4 * std::max(0.0, normal.dot(light_)));
        const double z = depth + random_.gaussian(noise) * depth * depth;
        cv::Vec3d seen = shade * color;
        for (int c = 0; c < 3; ++c) seen[c] += random_.gaussian(colorNoise);
        cloud.points.emplace_back(cv::Point3f(cv::Vec3f(z * ray)));
        cloud.colors.push_back(levels(seen));
        if (!std::isfinite(z)) cloud.points.back() = {NAN, NAN, NAN};
      }
    return cloud;
  }

 private:
  Kind kind_;
  cv::RNG random_;
  cv::Vec3d up_{0, -std::cos(0.6), -std::sin(0.6)};  // looks down by 34°
  cv::Vec3d foot_{0, 0.04, 0.8}, light_;             // the middle of the table's view
  double gain_ = 1;
};

cv::Point3d middleOf(const Standing& thing, const cv::Point3d& center) {
  return thing.pose * center;
}

void addScene(Kind kind, const char* name, std::size_t firstModel, std::size_t number, std::uint64_t seed,
              ColorCases& cases) {
  // Mixed, as the first numbers of cv::RNG are nearly the same for seeds that are.
  const std::uint64_t unmixed = seed + 1000 * static_cast<std::uint64_t>(kind) + number;
  Renderer renderer(kind, (unmixed + 1) * 0x9e3779b97f4a7c15ULL);
  const std::size_t leftOut = number % variants, wanted = (number + 1) % variants;
  std::vector<std::size_t> shown;
  for (std::size_t v = 0; v < variants; ++v)
    if (v != leftOut) shown.push_back(v);
  for (std::size_t i = shown.size(); i-- > 1;)
    std::swap(shown[i],
              shown[static_cast<std::size_t>(renderer.random().uniform(0, static_cast<int>(i) + 1))]);
  std::vector<Standing> things;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const double x = 0.14 * (static_cast<double>(i) - 1) + renderer.random().uniform(-0.01, 0.01);
    const double y = renderer.random().uniform(-0.04, 0.04), yaw = renderer.random().uniform(-3.1, 3.1);
    things.push_back({shown[i], renderer.placeAt(x, y, yaw)});
  }
  const std::size_t scene = cases.scenes.size();
  cases.scenes.push_back({fmt::format("{} scene {}", name, number), renderer.render(things)});
  const cv::Point3d center = centerOf(cases.models[firstModel].cloud);
  ColorCases::Search present{scene, firstModel + wanted, {}, {}}, absent{scene, firstModel + leftOut, {}, {}};
  for (const Standing& thing : things) {
    if (thing.variant == wanted)
      present.truth.push_back(thing.pose);
    else
      present.lookAlikes.push_back(middleOf(thing, center));
    absent.lookAlikes.push_back(middleOf(thing, center));
  }
  cases.searches.push_back(number % 2 == 0 ? present : absent);
  cases.searches.push_back(number % 2 == 0 ? absent : present);
}

}  // namespace

ColorCases lookAlikeCases(std::size_t scenes, std::uint64_t seed) {
  ColorCases cases;
  for (const auto& [kind, name] : kinds) {
    const std::size_t firstModel = cases.models.size();
    for (std::size_t v = 0; v < variants; ++v) cases.models.push_back(modelOf(kind, name, v));
    for (std::size_t s = 0; s < scenes; ++s) addScene(kind, name, firstModel, s, seed, cases);
  }
  return cases;
}

}  // namespace estancia::experiments
