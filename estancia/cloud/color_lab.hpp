// CIELAB: colors in which distances are about those that people see.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/matx.hpp>
#include <vector>

namespace estancia {

/// L* in [0, 100], a* and b* within about ±110, of an sRGB color (BGR) under D65 (CIE 15:2004; IEC
/// 61966-2-1).
cv::Vec3f labOf(const cv::Vec3b& bgr);
/// One a color.
std::vector<cv::Vec3f> labOf(const std::vector<cv::Vec3b>& colors);

}  // namespace estancia
