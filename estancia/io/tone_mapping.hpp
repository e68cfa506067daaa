// From radiance to a photograph.
#pragma once

#include <opencv2/core/mat.hpp>

namespace estancia::io {

/// The panorama (CV_32FC3 linear radiance, or an 8-bit image) as a camera would have taken it: BGR, 8 bits,
/// sRGB. Radiance is exposed so that its log-average over the sphere becomes middle gray (0.18), then changed
/// by `exposure` [EV]; highlights above 0.6 are rolled off softly. An image is exposed already and only
/// changed.
cv::Mat toneMap(cv::Mat panorama, double exposure);

}  // namespace estancia::io
