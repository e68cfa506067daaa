// Point clouds in PCD files, PCL's format.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Reads a PCD file of version 0.7 (ascii, binary or binary_compressed) as the PCL documentation describes
/// it ("The PCD file format"). Of its fields x, y, z become points (any type of number; NaN is kept) and rgb
/// or rgba colours (4 bytes, 0xAARRGGBB); others are passed over. An organised cloud (height above 1) keeps
/// its shape. VIEWPOINT is not applied, as in PCL: points stay in the frame that they are written in. Throws
/// Error when the file cannot be read, is cut short, or contradicts itself.
PointCloud readPcd(const std::filesystem::path& file);

/// The depth picture behind an organised cloud in a camera's optical frame: z [m], CV_32F, height × width; 0
/// where z is not finite or not above 0. Throws Error when the cloud is not organised.
cv::Mat depthOf(const PointCloud& cloud);

}  // namespace estancia
