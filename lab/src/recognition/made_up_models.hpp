// Made-up models: boxes, books, cans, plates, toys and parts of furniture in three sizes, as clouds and
// solids. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core/affine.hpp>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/point_cloud.hpp"
#include "objects/solids.hpp"

namespace estancia::experiments {

struct MadeUpModel {
  /// "box 21 cm", and its kind.
  std::string name, family;
  /// In its frame: z up, the origin in the middle of its foot.
  std::vector<Solid> solids;
  /// Its points all around, 2 mm apart, without noise.
  PointCloud whole;
  /// What a camera 1 m away sees of it, from above and askew, 1.9 mm apart, with 0.8 mm of noise along the
  /// ray; in the camera's frame.
  PointCloud oneSided;
  /// T_model_camera of that view.
  cv::Affine3d view;

  /// Between the farthest corners of its solids [m].
  double diameter() const;
};

/// Three sizes of each family. A function of the seed.
std::vector<MadeUpModel> madeUpModels(std::uint64_t seed);

/// Depths of the solids in a pose T_camera_solids (CV_32F, meters; 0 where they are not).
cv::Mat renderSolids(const std::vector<Solid>& solids, const cv::Affine3d& pose,
                     const CameraIntrinsics& camera);

}  // namespace estancia::experiments
