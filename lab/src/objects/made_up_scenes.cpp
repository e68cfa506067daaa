// SPDX-License-Identifier: Apache-2.0
#include "objects/made_up_scenes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "objects/solids.hpp"

namespace estancia::experiments {
namespace {

const std::array<std::string, 7> categories{"clutter", "side by side", "gaps",   "coaxial",
                                            "stacks",  "slits",        "printed"};

/// A solid that is seen; meters, z up.
struct Body {
  Solid solid;
  cv::Vec3d color = {}, print = {};  ///< BGR, 0 … 255
  int printed = 0;                   ///< 0: plain, 1: a label on its middle, 2: fine dots
  int object = 0;                    ///< 0: hides what is behind it, and is no object
  bool hole = false;                 ///< no depth where it is seen
};

struct Hit : SolidHit {
  const Body* body = nullptr;
};

cv::Vec3d colorAt(const Hit& hit) {
  const Body& body = *hit.body;
  const cv::Vec3d& p = hit.local;
  if (body.printed == 1) {  // on each face
    int inside = 0;
    for (int k = 0; k < 3; ++k) inside += std::abs(p[k]) < 0.6 ? 1 : 0;
    return inside >= 2 ? body.print : body.color;
  }
  if (body.printed == 2) {
    const double wave = std::sin(12 * p[0]) + std::sin(12 * p[1]) + std::sin(12 * p[2]);
    return wave > 0.4 ? body.print : body.color;
  }
  return body.color;
}

class Author {
 public:
  explicit Author(std::uint64_t seed) : random_(seed * 7919 + 17) {
    bodies_.push_back({.solid = {.at = {0, 0, -0.05}, .size = {1.6, 1.2, 0.05}}, .color = color()});
    for (int i = 0; i < 3; ++i) random_.next();
  }
  double between(double low, double high) { return random_.uniform(low, high); }
  int choice(int count) { return random_.uniform(0, count); }

  std::vector<Body> write(const std::string& category) {
    if (category == "side by side")
      row(0, 0);
    else if (category == "gaps")
      row(0.005, 0.03);
    else if (category == "coaxial")
      tower(true);
    else if (category == "stacks")
      tower(false);
    else if (category == "slits")
      slits();
    scatter(category == "clutter" ? 7 : category == "printed" ? 4 : 2, category == "printed");
    return bodies_;
  }

 private:
  /// Colors of two bodies beside each other differ.
  cv::Vec3d color() {
    for (;;) {
      const cv::Vec3d c{between(20, 235), between(20, 235), between(20, 235)};
      if (!bodies_.empty() && cv::norm(c - bodies_.back().color) < 110) continue;
      return c;
    }
  }
  void add(Body body, bool object = true) {
    if (object) body.object = ++objects_ + 1;
    body.color = color();
    bodies_.push_back(body);
  }
  /// Boxes of one height in a row, `low` to `high` apart.
  void row(double low, double high) {
    const double height = between(0.05, 0.2), angle = between(-0.7, 0.7);
    const int count = 2 + choice(2);
    const bool flush = choice(2) == 0;
    const double depth = between(0.06, 0.14);
    double x = -0.15;
    for (int i = 0; i < count; ++i) {
      const double width = between(0.06, 0.13), deep = flush ? depth : between(0.06, 0.16);
      const cv::Vec3d along(std::cos(angle), std::sin(angle), 0),
          across(-std::sin(angle), std::cos(angle), 0);
      add({.solid = {.at = (x + width / 2) * along + (flush ? 0 : between(-0.03, 0.03)) * across,
                     .size = {width, deep, height},
                     .angle = angle}});
      x += width + between(low, high);
    }
  }
  void tower(bool round) {
    double height = 0, wide = between(0.1, 0.16);
    cv::Vec3d at{between(-0.08, 0.08), between(-0.05, 0.05), 0};
    for (int i = 0, count = 2 + choice(2); i < count; ++i) {
      const double high = between(0.05, 0.11);
      at[2] = height;
      add({.solid = {.shape = round ? Solid::Shape::cylinder : Solid::Shape::box,
                     .at = at,
                     .size = {wide, round ? wide : wide * between(0.7, 1), high},
                     .angle = between(-1, 1)}});
      height += high;
      wide -= between(round ? 0.006 : 0.015, 0.03);
    }
  }
  /// A box behind thin posts, and bands of it without depth.
  void slits() {
    add({.solid = {.at = {0, 0.08, 0},
                   .size = {between(0.25, 0.35), 0.1, between(0.1, 0.2)},
                   .angle = between(-0.3, 0.3)}});
    for (int i = 0; i < 2; ++i) {
      const double thick = between(0.004, 0.015);
      const double x = i == 0 ? between(-0.08, -0.02) : between(0.02, 0.08);
      add({.solid = {.at = {x, -0.1 + (i == 0 ? 0 : 0.125), 0},
                     .size = {thick, i == 0 ? thick : 0.001, 0.4}}},
          false);
      bodies_.back().hole = i == 1;
    }
  }
  void scatter(int count, bool printed) {
    for (int tries = 0; count > 0 && tries < 200; ++tries) {
      const bool round = choice(2) == 0;
      Solid solid{.shape = round ? Solid::Shape::cylinder : Solid::Shape::box,
                  .at = {between(-0.4, 0.4), between(-0.25, 0.3), 0}};
      const double wide = between(0.05, 0.12);
      solid.size = {wide, round ? wide : between(0.05, 0.14), between(0.03, 0.18)};
      solid.angle = between(-1.5, 1.5);
      const double reach = std::hypot(solid.size[0], solid.size[1]) / 2;
      if (std::any_of(bodies_.begin() + 1, bodies_.end(), [&](const Body& other) {
            const cv::Vec3d d = other.solid.at - solid.at;
            return std::hypot(d[0], d[1]) <
                   reach + std::hypot(other.solid.size[0], other.solid.size[1]) / 2 + 0.005;
          }))
        continue;
      Body body{.solid = solid};
      body.printed = printed ? 1 + choice(2) : 0;
      add(body);
      bodies_.back().print = color();
      --count;
    }
  }

  cv::RNG random_;
  std::vector<Body> bodies_;
  int objects_ = 0;
};

/// Lateral noise, shadows, noise and steps.
cv::Mat asSeen(const cv::Mat_<float>& depth, cv::RNG& random) {
  constexpr double lateral = 0.6, noise = 0.0013, step = 0.00285, shadow = 0.05;  // [pixels], [m at 1 m], [m]
  cv::Mat_<float> seen(depth.size(), 0.F);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const auto moved = [&](int at, int size) {
        return std::clamp(at + static_cast<int>(std::lround(random.gaussian(lateral))), 0, size - 1);
      };
      const double z = depth(moved(v, depth.rows), moved(u, depth.cols));
      const double error = random.gaussian(noise);
      const float left = depth(v, std::max(u - 3, 0));
      if (!(z > 0) || (left > 0 && z - left > shadow && random.uniform(0., 1.) < 0.7)) continue;
      const double steps = step * z * z;
      seen(v, u) = static_cast<float>(std::round((z + error * z * z) / steps) * steps);
    }
  return seen;
}

}  // namespace

std::string madeUpCategory(std::uint64_t seed) {
  return categories[seed % categories.size()];
}

MadeUpScene madeUpScene(std::uint64_t seed) {
  Author author(seed);
  MadeUpScene scene{madeUpCategory(seed), {}, {}, {}, {640, 480, 525, 525, 319.5, 239.5}};
  const std::vector<Body> bodies = author.write(scene.category);
  const double away = author.between(0.8, 1.3), pitch = author.between(0.45, 0.95),
               turn = author.between(-0.4, 0.4);
  const cv::Vec3d to(0, 0, 0.05),
      from = to + away * cv::Vec3d(std::cos(pitch) * std::sin(turn), -std::cos(pitch) * std::cos(turn),
                                   std::sin(pitch));
  const cv::Vec3d forward = cv::normalize(to - from),
                  right = cv::normalize(forward.cross(cv::Vec3d(0, 0, 1))), down = forward.cross(right),
                  light = cv::normalize(cv::Vec3d{author.between(-1, 1), author.between(-1, 0), 1.5});
  const cv::Size size(scene.camera.width, scene.camera.height);
  cv::Mat_<cv::Vec3b> image(size, cv::Vec3b(60, 60, 60));
  cv::Mat_<float> depth(size, 0.F);
  scene.truth = cv::Mat(size, CV_32S, cv::Scalar(0));
  cv::Mat_<std::uint8_t> hole(size, 0);
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      const cv::Vec3d ray = forward + scene.camera.slopeX(u) * right + scene.camera.slopeY(v) * down;
      Hit hit;
      for (const Body& body : bodies)
        if (cast(body.solid, from, ray, hit)) hit.body = &body;
      if (hit.body == nullptr) continue;
      depth(v, u) = static_cast<float>(hit.t);
      hole(v, u) = hit.body->hole ? 1 : 0;
      scene.truth.at<int>(v, u) = hit.body->object;
      const double bright = 0.45 + 0.55 * std::max(0., hit.normal.dot(light));
      image(v, u) = cv::Vec3b(bright * colorAt(hit));
    }
  cv::RNG random(seed + 1);
  cv::GaussianBlur(image, image, {}, 0.7);
  cv::Mat_<cv::Vec3s> grain(size);
  random.fill(grain, cv::RNG::NORMAL, 0, 4);
  cv::add(image, grain, scene.image, {}, CV_8U);
  scene.depth = asSeen(depth, random);
  scene.depth.setTo(0, hole);
  return scene;
}

}  // namespace estancia::experiments
