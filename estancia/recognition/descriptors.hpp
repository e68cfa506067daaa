// Surface descriptors: SHOT, FPFH and spin images of keypoints (thesis 2.4.3), and their matches (2.4.4).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/options.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia {

/// The descriptors by name: shot, shot-color, fpfh, spin-image.
Choices descriptorMethods();

/// Described keypoints; all lists have the same length.
struct SurfaceFeatures {
  std::vector<std::uint32_t> keypoints;      ///< indices of the surface's points
  std::vector<cv::Point3f> points, normals;  ///< positions and normals of the keypoints
  std::vector<cv::Matx33f> frames;           ///< rows are x, y, z of the local frame (localFrame())
  DescriptorMatrix descriptors{0};

  std::size_t size() const { return keypoints.size(); }
  /// Adds features by the same method.
  void append(const SurfaceFeatures& others);
};

/// Sign disambiguation of the axes of a local frame.
enum class FrameSigns {
  /// Towards the side with more points, as in PCL.
  majority,
  /// z along the normal, x towards the side where points reach further: more repeatable with good normals.
  normal
};

/// Describes keypoints by the surface within `radius` [m]. Keypoints with fewer than five points around them
/// are left out. Throws Error (unknownName, invalidInput when shot-color gets a surface without colors, and
/// as requireRadius()). The result does not depend on the number of threads.
SurfaceFeatures describe(const Surface& surface, std::span<const std::uint32_t> keypoints,
                         const std::string& method, double radius, int threads = 1,
                         FrameSigns signs = FrameSigns::majority);

/// A keypoint of a model and one of a scene with similar descriptors.
struct Match {
  std::uint32_t model = 0, scene = 0;  ///< indices of the described keypoints
  float squared = 0;                   ///< squared distance of the descriptors

  bool operator==(const Match&) const = default;
};

struct NearRow {
  std::uint32_t other = 0;
  float squared = 0;
};
/// For each of `rows` the `count` rows of `others` nearest by Euclidean distance, nearest first; ties are
/// broken by the lower row. The result does not depend on the number of threads. Throws Error when their
/// lengths differ.
std::vector<std::vector<NearRow>> nearestRows(const DescriptorMatrix& rows, const DescriptorMatrix& others,
                                              std::size_t count, int threads = 1);

/// Whose keypoints are each matched.
enum class MatchEach {
  /// Each scene keypoint with the nearest model keypoints: clutter gets matches, too.
  scene,
  /// Each model keypoint with the nearest scene keypoints: far fewer matches, several of which can be right.
  model
};

/// The matches of each keypoint of one side with its `count` nearest of the other, nearest descriptors first;
/// with a `distance`, only those within this share of the norm of the scene's descriptor.
std::vector<Match> matchDescriptors(const DescriptorMatrix& model, const DescriptorMatrix& scene,
                                    MatchEach each, std::size_t count, double distance = 0, int threads = 1);

// ---- the single descriptors: rows of `values`, one a keypoint, NaN where too few points are near

/// SHOT (Salti, Tombari, Di Stefano 2014), shape only: 352 numbers in the local frame of localFrames().
/// Equals PCL's SHOTEstimation within rounding. `colored`: color-SHOT (Tombari, Salti, Di Stefano: A combined
/// texture-shape descriptor for enhanced 3D feature matching, 2011), 1344 numbers: behind those of shape, 31
/// bins of the distance in CIELAB from the keypoint's color in each of the 32 volumes. Equals PCL's
/// SHOTColorEstimation within the steps of its table of CIELAB. It distinguishes textures, but not two
/// surfaces of one plain color each.
void describeShot(const Surface& surface, std::span<const std::uint32_t> keypoints,
                  std::span<const cv::Matx33f> frames, double radius, bool colored, int threads,
                  std::vector<float>& values);

/// FPFH (Rusu, Blodow, Beetz 2009): 33 numbers. Equals PCL's FPFHEstimation within rounding.
void describeFpfh(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius,
                  int threads, std::vector<float>& values);

/// Spin image (Johnson and Hebert 1999): 153 numbers, 9 distances from the normal × 17 heights, of the points
/// whose normals differ by less than 60°. Equals PCL's SpinImageEstimation(8, 0.5) within rounding.
void describeSpinImage(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius,
                       int threads, std::vector<float>& values);

/// The local reference frames of SHOT: principal axes of the points within `radius`, weighted by proximity;
/// NaN where fewer than five are near. With FrameSigns::majority they equal PCL's
/// SHOTLocalReferenceFrameEstimation within rounding.
std::vector<cv::Matx33f> localFrames(const Surface& surface, std::span<const std::uint32_t> keypoints,
                                     double radius, int threads, FrameSigns signs = FrameSigns::majority);

}  // namespace estancia
