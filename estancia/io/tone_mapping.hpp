// Tone mapping: linear HDR panorama to 8-bit sRGB.
#pragma once

#include <opencv2/core/mat.hpp>

namespace estancia::io {

/// Converts a panorama (CV_32FC3 linear radiance, or an 8-bit image) to BGR, 8 bits, sRGB. Radiance is scaled
/// so that its log-average over the sphere becomes middle gray (0.18, Reinhard et al. 2002), then by
/// `exposure` [EV]; highlights above 0.6 are rolled off. 8-bit images are scaled by `exposure` only.
cv::Mat toneMap(cv::Mat panorama, double exposure);

}  // namespace estancia::io
