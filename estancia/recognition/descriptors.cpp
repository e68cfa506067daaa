// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/descriptors.hpp"

#include <algorithm>
#include <cmath>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

struct Method {
  const char *name, *explanation;
  std::size_t length;
};
constexpr Method methods[] = {
    {"shot", "signatures of histograms of normals in a local frame, 352 numbers", 352},
    {"shot-color", "shot, and histograms of color differences, 1344 numbers; needs colors", 1344},
    {"fpfh", "fast point feature histograms: angles between normals, 33 numbers", 33},
    {"spin-image", "distances and heights of points around the normal, 153 numbers", 153},
};

}  // namespace

Choices descriptorMethods() {
  Choices choices;
  for (const Method& m : methods) choices.push_back({m.name, m.explanation});
  return choices;
}

SurfaceFeatures describe(const Surface& surface, std::span<const std::uint32_t> keypoints,
                         const std::string& method, double radius, int threads, FrameSigns signs) {
  requireChoice("surface descriptor", method, descriptorMethods());
  const std::size_t length = std::ranges::find(methods, method, &Method::name)->length;
  surface.requireRadius(radius, "descriptor radius");
  const bool colored = method == "shot-color";
  if (colored && surface.lab().empty())
    fail(ErrorCode::invalidInput, "{}: the cloud has no colors, which shot-color describes; use shot",
         surface.name());
  const std::vector<cv::Matx33f> frames = localFrames(surface, keypoints, radius, threads, signs);
  std::vector<float> values;
  if (method == "shot" || colored)
    describeShot(surface, keypoints, frames, radius, colored, threads, values);
  else if (method == "fpfh")
    describeFpfh(surface, keypoints, radius, threads, values);
  else
    describeSpinImage(surface, keypoints, radius, threads, values);

  SurfaceFeatures features;
  features.descriptors = DescriptorMatrix(length);
  features.descriptors.reserve(keypoints.size());
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const DescriptorView row(values.data() + i * length, length);
    float sum = frames[i](0, 0);
    for (const float v : row) sum += v;
    if (!std::isfinite(sum)) continue;
    features.descriptors.append(row);
    features.frames.push_back(frames[i]);
    features.keypoints.push_back(keypoints[i]);
    features.points.push_back(surface.points()[keypoints[i]]);
    features.normals.push_back(surface.normals()[keypoints[i]]);
  }
  return features;
}

}  // namespace estancia
