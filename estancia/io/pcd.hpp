// Point clouds in PCD files, PCL's format.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Reads a PCD file of version 0.7 (ascii, binary or binary_compressed) as the PCL documentation describes
/// it ("The PCD file format"). Of its fields x, y, z become points (any type of number; NaN is kept), rgb or
/// rgba colors (4 bytes, 0xAARRGGBB) and normal_x, normal_y, normal_z normals; others are passed over. An
/// organized cloud (height above 1) keeps its shape. VIEWPOINT is the pose of the sensor in the frame of the
/// points, which stay in it, as in PCL's normal estimation. Throws Error when the file cannot be read, is cut
/// short, or contradicts itself.
PointCloud readPcd(const std::filesystem::path& file);

/// Writes x, y, z, and rgb and the normals where the cloud has them, as PCL names and types them; binary, or
/// as text, out of which readPcd makes the same numbers. An organized cloud keeps its shape, and any its
/// viewpoint. Throws Error on a cloud without points or with too few colors or normals, and when the file
/// cannot be written (writeWhole).
void writePcd(const std::filesystem::path& file, const PointCloud& cloud, bool ascii = false);

/// The depth image behind an organized cloud in a camera's optical frame: z [m], CV_32F, height × width; 0
/// where z is not finite or not above 0. Throws Error when the cloud is not organized.
cv::Mat depthOf(const PointCloud& cloud);

}  // namespace estancia
