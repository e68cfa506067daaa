// A made-up thing that stands in a room, seen from all around.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "estancia/core/point_cloud.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/objects/training.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_map.hpp"
#include "support/flat_drive.hpp"

namespace estancia::test {

using Shape = Boxes;

/// No two of its views are alike.
inline const Shape desk{{{{-0.3, -0.25, 0}, {0.3, 0.25, 0.25}}},
                        {{{-0.3, -0.25, 0.25}, {-0.12, -0.1, 0.7}}},
                        {{{0.1, 0.0, 0.25}, {0.3, 0.25, 0.4}}}};
inline const Shape shelf{{{{-0.25, -0.1, 0}, {0.25, 0.1, 0.12}}},
                         {{{-0.25, -0.1, 0.12}, {-0.15, 0.1, 0.8}}},
                         {{{-0.15, -0.1, 0.6}, {0.25, 0.0, 0.8}}}};

inline bool isInside(const Shape& shape, const cv::Vec3d& p) {
  return std::ranges::any_of(shape, [&](const auto& box) {
    return p[0] > box[0][0] && p[1] > box[0][1] && p[2] > box[0][2] && p[0] < box[1][0] && p[1] < box[1][1] &&
           p[2] < box[1][2];
  });
}

/// A point each 8 mm of its surface, times `scale`.
inline PointCloud surfaceOf(const Shape& shape, double scale = 1) {
  constexpr double step = 0.008;
  PointCloud cloud;
  for (const auto& [low, high] : shape)
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        cv::Vec3d p, normal;
        p[axis] = side < 0 ? low[axis] : high[axis];
        normal[axis] = side;
        for (p[a] = low[a] + step / 2; p[a] < high[a]; p[a] += step)
          for (p[b] = low[b] + step / 2; p[b] < high[b]; p[b] += step) {
            if (isInside(shape, p + 1e-4 * normal)) continue;
            cloud.points.emplace_back(cv::Vec3f(scale * p));
            cloud.normals.emplace_back(cv::Vec3f(normal));
          }
      }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

/// A shape that stands in a room, seen from all around.
class ShapeDrive : public FlatDrive {
 public:
  /// From so far away [m].
  explicit ShapeDrive(Shape shape, double away = 1.5) : shape_(std::move(shape)) {
    intrinsics_ = CameraIntrinsics{240, 180, 197, 197, 119.5, 89.5};
    frames_.resize(12);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(size());
      frames_[i].pose = lookingAt(0.3 + away * std::cos(angle), -0.2 + away * std::sin(angle), 1.1,
                                  angle + std::numbers::pi, -0.5);
    }
  }
  static cv::Affine3d placeOfShape() {
    return {cv::Vec3d(0, 0, 35 * std::numbers::pi / 180), cv::Vec3d(0.3, -0.2, 0)};
  }
  cv::Mat image(std::size_t) const override { return {180, 240, CV_8UC3, cv::Scalar(10, 20, 30)}; }
  cv::Mat depth(std::size_t i) const override {
    return boxesDepth(*frames_[i].pose, *intrinsics_, shape_, placeOfShape());
  }

 private:
  Shape shape_;
};

/// Maps the drive's frames up to `end`, beginning or going on. `names`: gives what names objects; may be
/// empty.
inline WorldMap mapShapes(const ShapeDrive& drive, std::size_t end, const std::filesystem::path& file,
                          const std::function<void(WorldMapper&)>& names) {
  const DescriptorSequence labeled = drive.labeled();
  {
    MappingSession session =
        std::filesystem::exists(file)
            ? MappingSession::resume(file, labeled.vocabulary, labeled.model)
            : MappingSession::create(file, labeled.vocabulary, labeled.model, MapperOptions{});
    WorldMapper world(session);
    if (names) names(world);
    for (std::size_t i = session.frames(); i < end; ++i) {
      world.observe(drive.frame(i), labeled.descriptors.row(i), drive.image(i), drive.depth(i),
                    *drive.intrinsics());
      session.add(drive.frame(i), labeled.descriptors.row(i));
    }
    session.finish();
    world.finish();
  }
  return readWorld(file);
}

/// A model of the two shapes, of views from other distances than those of ShapeDrive.
inline ObjectModel modelOfShapes() {
  ObjectTraining training{targetClassesOf({"desk", "shelf"}), {}, noShapes({}), {}, {}, "", {}};
  int instance = 0;
  for (const double away : {1.25, 1.4, 1.6, 1.75})
    for (int shape = 0; shape < 2; ++shape, ++instance) {
      const ShapeDrive drive(shape == 0 ? desk : shelf, away);
      for (std::size_t i = 0; i < drive.size(); ++i) {
        Observation seen = observe(drive.depth(i), *drive.intrinsics());
        findSegments(seen, {}, {});
        if (seen.info.size() != 1) continue;
        training.shapes.values.append(
            describeShape(segmentCloud(depthOf(seen), seen.segments == 1, seen.camera), training.shape));
        training.shapes.frames.emplace_back();
        training.classes.push_back(shape);
        training.instances.push_back(instance);
      }
    }
  ClassifierOptions options;
  options.c = 3;
  return trainObjectModel(training, options);
}

}  // namespace estancia::test
