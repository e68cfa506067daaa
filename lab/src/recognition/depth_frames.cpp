// SPDX-License-Identifier: Apache-2.0
#include "recognition/depth_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "estancia/core/error.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "objects/object_scenes.hpp"

namespace estancia::experiments {
namespace {

constexpr std::array<std::pair<Placement, const char*>, 4> placements{{{Placement::standing, "standing"},
                                                                       {Placement::lying, "lying"},
                                                                       {Placement::stacked, "stacked"},
                                                                       {Placement::byWall, "by a wall"}}};

bool hasIndex(const DepthFrameSource& source) {
  return std::filesystem::exists(source.path / "index.csv");
}

/// `count` of `all`, evenly spread.
std::size_t spread(std::size_t i, std::size_t count, std::size_t all) {
  return count < all ? i * all / count : i;
}

cv::Vec3d pointAt(const DepthFrame& frame, int u, int v) {
  const auto z = static_cast<double>(frame.depth.at<float>(v, u));
  return {z * frame.camera.slopeX(u), z * frame.camera.slopeY(v), z};
}

/// A flat place: a point of it, and its normal, towards the camera.
struct Flat {
  cv::Vec3d at, normal;
};

/// The place around a pixel, if nearly all within `radius` [m] lies in one plane.
std::optional<Flat> flatAt(const DepthFrame& frame, int u, int v, double radius) {
  constexpr double within = 0.006, share = 0.9;  // [m at 1 m]
  const cv::Vec3d middle = pointAt(frame, u, v);
  if (!(middle[2] > 0)) return {};
  const int reach = static_cast<int>(std::ceil(radius * frame.camera.fx / middle[2]));
  const int step = std::max(1, reach / 15);
  std::vector<cv::Vec3d> points;
  std::size_t pixels = 0;
  for (int y = v - reach; y <= v + reach; y += step)
    for (int x = u - reach; x <= u + reach; x += step) {
      if (x < 0 || y < 0 || x >= frame.depth.cols || y >= frame.depth.rows) return {};
      const cv::Vec3d p = pointAt(frame, x, y);
      // In a disc around the line of sight: a slanted plane shows less of its own.
      if (std::hypot(x - u, y - v) > reach) continue;
      ++pixels;
      if (p[2] > 0 && cv::norm(p - middle) < 2 * radius) points.push_back(p);
    }
  if (points.size() < 20) return {};
  cv::Vec3d mean;
  for (const cv::Vec3d& p : points) mean += p * (1.0 / static_cast<double>(points.size()));
  cv::Matx33d scatter = cv::Matx33d::zeros(), vectors;
  for (const cv::Vec3d& p : points) scatter += (p - mean) * (p - mean).t();
  cv::Vec3d values;
  cv::eigen(scatter, values, vectors);
  cv::Vec3d normal(vectors(2, 0), vectors(2, 1), vectors(2, 2));
  if (normal.dot(mean) > 0) normal = -normal;
  const double tolerance = within * std::max(1.0, mean[2] * mean[2]);
  const auto flat = std::ranges::count_if(
      points, [&](const cv::Vec3d& p) { return std::abs(normal.dot(p - mean)) < tolerance; });
  if (static_cast<double>(flat) < share * static_cast<double>(pixels)) return {};
  return Flat{middle - normal * normal.dot(middle - mean), normal};
}

/// T_camera_thing of a thing on a place, z along its normal.
cv::Affine3d poseOn(const Flat& flat, double turn) {
  const cv::Vec3d z = flat.normal, x = cv::normalize(cv::Vec3d(0, 1, 0).cross(z)), y = z.cross(x);
  const cv::Vec3d a = std::cos(turn) * x + std::sin(turn) * y, b = z.cross(a);
  return {cv::Matx33d(a[0], b[0], z[0], a[1], b[1], z[1], a[2], b[2], z[2]), flat.at};
}

struct Bounds {
  cv::Vec3d low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high = -low;
};

Bounds boundsOf(const MadeUpModel& model, const cv::Affine3d& pose = cv::Affine3d::Identity()) {
  Bounds bounds;
  for (const cv::Point3f& p : model.whole.points) {
    const cv::Vec3d q = pose * cv::Vec3d(p.x, p.y, p.z);
    for (int k = 0; k < 3; ++k) {
      bounds.low[k] = std::min(bounds.low[k], q[k]);
      bounds.high[k] = std::max(bounds.high[k], q[k]);
    }
  }
  return bounds;
}

/// T_foot_model: upright, or on its broad side; then what carries it is at z = 0, below its middle.
cv::Affine3d restOf(const MadeUpModel& model, Placement placement) {
  cv::Affine3d turned = cv::Affine3d::Identity();
  if (placement == Placement::lying) turned = cv::Affine3d(cv::Vec3d(-std::numbers::pi / 2, 0, 0));
  const Bounds bounds = boundsOf(model, turned);
  return cv::Affine3d(cv::Vec3d(), cv::Vec3d(-(bounds.low[0] + bounds.high[0]) / 2,
                                             -(bounds.low[1] + bounds.high[1]) / 2, -bounds.low[2])) *
         turned;
}

/// Depth with the noise and the steps of a Kinect.
cv::Mat_<float> asMeasured(const cv::Mat_<float>& depth, cv::RNG& random) {
  constexpr double noise = 0.0013, step = 0.00285;  // [m at 1 m]
  cv::Mat_<float> measured(depth.size(), 0.F);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u)
      if (const auto z = static_cast<double>(depth(v, u)); z > 0) {
        const double steps = step * z * z;
        measured(v, u) = static_cast<float>(std::round((z + random.gaussian(noise) * z * z) / steps) * steps);
      }
  return measured;
}

/// What is nearer replaces what is there.
void putBefore(cv::Mat_<float>& scene, const cv::Mat_<float>& thing) {
  for (int v = 0; v < scene.rows; ++v)
    for (int u = 0; u < scene.cols; ++u)
      if (thing(v, u) > 0 && (scene(v, u) == 0 || thing(v, u) < scene(v, u))) scene(v, u) = thing(v, u);
}

/// Whether the thing is seen whole, and what the frame shows there lies on the place or far behind.
bool isFree(const cv::Mat_<float>& thing, const DepthFrame& frame, const Flat& flat, double behind) {
  constexpr double share = 0.03, above = 0.015;  // [m at 1 m]
  constexpr int least = 1000;
  int pixels = 0, taken = 0;
  for (int v = 0; v < thing.rows; ++v)
    for (int u = 0; u < thing.cols; ++u)
      if (thing(v, u) > 0) {
        if (u < 2 || v < 2 || u >= thing.cols - 2 || v >= thing.rows - 2) return false;
        ++pixels;
        const cv::Vec3d there = pointAt(frame, u, v);
        if (there[2] > 0 && there[2] < static_cast<double>(thing(v, u)) + behind &&
            flat.normal.dot(there - flat.at) > above * std::max(1.0, there[2] * there[2]))
          ++taken;
      }
  return pixels >= least && taken < share * pixels;
}

/// A box in front of the thing that hides about so much of it; of some, the nearest to that.
std::vector<Solid> occluderFor(const cv::Mat_<float>& thing, const cv::Affine3d& foot, const Bounds& bounds,
                               double hidden, const CameraIntrinsics& camera, cv::RNG& random) {
  const cv::Vec3d eye = foot.inv().translation();
  const double reach = std::hypot(bounds.high[0] - bounds.low[0], bounds.high[1] - bounds.low[1]) / 2;
  const cv::Vec3d towards = cv::normalize(cv::Vec3d(eye[0], eye[1], 0)), side(-towards[1], towards[0], 0);
  std::vector<Solid> best;
  double difference = HUGE_VAL;
  for (int tries = 0; tries < 12; ++tries) {
    const double wide = random.uniform(0.05, 0.15), high = random.uniform(0.06, 0.25), thick = 0.06;
    const Solid one{
        Solid::Shape::box,
        towards * (reach + thick + random.uniform(0.02, 0.10)) + side * random.uniform(-reach, reach),
        {wide, thick, high},
        random.uniform(0.0, std::numbers::pi)};
    const cv::Mat_<float> before = renderSolids({one}, foot, camera);
    int pixels = 0, covered = 0;
    for (int v = 0; v < thing.rows; ++v)
      for (int u = 0; u < thing.cols; ++u)
        if (thing(v, u) > 0) {
          ++pixels;
          covered += before(v, u) > 0 && before(v, u) < thing(v, u) ? 1 : 0;
        }
    const double off = std::abs(static_cast<double>(covered) / std::max(1, pixels) - hidden);
    if (off < difference) {
      difference = off;
      best = {one};
    }
  }
  return best;
}

/// How it must be turned about the upright to be seen as its one-sided cloud shows it.
double turnLikeView(const MadeUpModel& model, const Flat& flat) {
  const cv::Vec3d eye = poseOn(flat, 0).inv().translation(), seen = model.view.translation();
  return std::atan2(eye[1], eye[0]) - std::atan2(seen[1], seen[0]);
}

}  // namespace

std::vector<std::string> namesOfFrames(const DepthFrameSource& source) {
  std::vector<std::string> all, names;
  if (hasIndex(source)) {
    for (const ObjectScene& scene : readObjectScenes(source.path)) all.push_back(scene.name);
  } else {
    const auto drive = openSequence(source.path);
    for (std::size_t i = 0; i < drive->size(); ++i) all.push_back(drive->frame(i).name);
  }
  for (std::size_t i = 0; i < std::min(source.frames, all.size()); ++i)
    names.push_back(all[spread(i, source.frames, all.size())]);
  return names;
}

DepthFrame readFrame(const DepthFrameSource& source, std::size_t number) {
  if (hasIndex(source)) {
    const auto scenes = readObjectScenes(source.path);
    const ObjectScene& scene = scenes[spread(number, source.frames, scenes.size())];
    return {scene.name, io::readDepth(scene.depth, 1000), {640, 480, 525, 525, 319.5, 239.5}};
  }
  const auto drive = openSequence(source.path);
  if (!drive->hasDepth() || !drive->intrinsics())
    throw Error(ErrorCode::invalidInput,
                fmt::format("{} has no depth or no camera; give a drive with both", source.path.string()));
  const std::size_t i = spread(number, source.frames, drive->size());
  const cv::Mat depth = drive->depth(i);
  return {drive->frame(i).name, depth, drive->intrinsics()->scaledTo(depth.cols, depth.rows)};
}

std::string nameOf(Placement placement) {
  return std::ranges::find(placements, placement, [](const auto& p) { return p.first; })->second;
}

std::optional<PlacedModel> place(const MadeUpModel& model, const DepthFrame& frame, Placement placement,
                                 double hidden, bool likeView, std::uint64_t seed) {
  constexpr int tries = 400;
  constexpr double wall = 0.02;  // [m]
  cv::RNG random((seed + 1) * 0x9e3779b97f4a7c15ULL);
  const cv::Affine3d rest = restOf(model, placement);
  const Bounds bounds = boundsOf(model, rest);
  const double reach = std::hypot(bounds.high[0] - bounds.low[0], bounds.high[1] - bounds.low[1]) / 2;
  for (int i = 0; i < tries; ++i) {
    const int u = random.uniform(0, frame.depth.cols), v = random.uniform(0, frame.depth.rows);
    const std::optional<Flat> flat = flatAt(frame, u, v, 0.8 * reach);
    if (!flat) continue;
    const double turn = likeView ? turnLikeView(model, *flat) + random.uniform(-0.2, 0.2)
                                 : random.uniform(-std::numbers::pi, std::numbers::pi);
    cv::Affine3d foot = poseOn(*flat, turn);
    std::vector<Solid> beside;  // in the frame of the foot
    double lift = 0;
    if (placement == Placement::stacked) {
      lift = random.uniform(0.04, 0.12);
      const double wide = bounds.high[0] - bounds.low[0] + random.uniform(0.02, 0.1),
                   deep = bounds.high[1] - bounds.low[1] + random.uniform(0.02, 0.1);
      beside.push_back({Solid::Shape::box, {}, {wide, deep, lift}, random.uniform(-0.3, 0.3)});
    }
    if (placement == Placement::byWall) {
      // On the side that the camera does not see.
      const double side =
          cv::Vec3d(foot.inv().translation())[1] > 0 ? bounds.low[1] - wall / 2 : bounds.high[1] + wall / 2;
      beside.push_back({Solid::Shape::box, {0, side, 0}, {2.5 * reach, wall, 0.4}, 0});
    }
    const cv::Affine3d pose = foot * cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, lift)) * rest;
    const cv::Mat_<float> alone = renderSolids(model.solids, pose, frame.camera);
    if (!isFree(alone, frame, *flat, reach)) continue;
    if (hidden > 0)
      for (const Solid& solid : occluderFor(alone, foot, bounds, hidden, frame.camera, random))
        beside.push_back(solid);
    cv::Mat_<float> made = renderSolids(beside, foot, frame.camera);
    int pixels = 0, covered = 0;
    for (int y = 0; y < made.rows; ++y)
      for (int x = 0; x < made.cols; ++x)
        if (alone(y, x) > 0) {
          ++pixels;
          covered += made(y, x) > 0 && made(y, x) < alone(y, x) ? 1 : 0;
        }
    putBefore(made, alone);
    PlacedModel placed{frame.depth.clone(), pose, static_cast<double>(covered) / pixels};
    cv::Mat_<float> scene = placed.depth;
    putBefore(scene, asMeasured(made, random));
    placed.depth = scene;
    return placed;
  }
  return {};
}

}  // namespace estancia::experiments
