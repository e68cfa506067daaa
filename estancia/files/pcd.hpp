// PCD: the point cloud file format of PCL.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Reads a PCD file of version 0.7 (ascii, binary or binary_compressed) as the PCL documentation describes it
/// ("The PCD file format"). Fields x, y, z become points (any type of number; NaN is kept), rgb or rgba
/// colors (4 bytes, 0xAARRGGBB) and normal_x, normal_y, normal_z normals; others are ignored. An organized
/// cloud (height above 1) keeps its shape. VIEWPOINT is the pose of the sensor in the frame of the points,
/// which stay in it, as in PCL's normal estimation. Throws Error when it is unreadable or contradictory.
PointCloud readPcd(const std::filesystem::path& file);

/// Writes x, y, z, and rgb and normals where the cloud has them, with the names and types of PCL; binary, or
/// as text that readPcd() reads to the same numbers. Width, height and viewpoint are kept. Throws Error on a
/// cloud without points or with too few colors or normals, and when the file cannot be written (writeWhole).
void writePcd(const PointCloud& cloud, const std::filesystem::path& file, bool ascii = false);

/// The depth image of an organized cloud in the optical frame of its camera: z [m], CV_32F, height × width; 0
/// where z is not finite or not above 0. Throws Error when the cloud is not organized.
cv::Mat depthOf(const PointCloud& cloud);

}  // namespace estancia
