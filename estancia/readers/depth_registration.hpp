// Depth registration: depth of one camera as another one, mounted beside it, would see it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>

#include "estancia/core/camera.hpp"

namespace estancia::io {

/// `depth` (CV_32F [m], 0 where unknown) of the camera `from`, whose images may have another size, seen by
/// `to`, at T_to_from: in the size of `depth`, so that hardly a pixel stays empty between two; the nearer of
/// two things wins.
cv::Mat registerDepth(const cv::Mat& depth, const CameraIntrinsics& from, const cv::Affine3d& toFromFrom,
                      const CameraIntrinsics& to);

}  // namespace estancia::io
