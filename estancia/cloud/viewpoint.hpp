// Viewpoint estimation: where the sensor of a point cloud stood, from its grid or the density of its points.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// How unevenly points lie in the directions from a place: the coefficient of variation of their numbers in
/// equal cells of the image that a camera there, looking at their mean, would have, divided by that of points
/// drawn at random. A depth camera measures in equal cells, so that it is about 1 where it stood, and more
/// elsewhere; infinite where points lie behind the place or beyond 76° to a side. A few thousand points do.
double unevenness(std::span<const cv::Point3f> points, const cv::Point3d& viewpoint);

/// Smaller values of unevenness() belong to the sensor.
constexpr double even = 1.35;

/// Where the sensor of an unorganized cloud may have been, in its frame [m]: the smallest unevenness() in up
/// to six directions, where it is small enough, most even first. Several for flat clouds, which are as even
/// from their back. None for clouds of several views. What a filter has made uniform in space is even from
/// afar. `points` are finite. Deterministic.
std::vector<cv::Point3d> findViewpoints(std::span<const cv::Point3f> points, int threads = 1);

/// The position of the sensor of an organized cloud, in its frame [m]: the center of the projection that its
/// rows and columns are (direct linear transform; depth errors along the rays do not matter). None for an
/// unorganized cloud, for one that a single pinhole projection does not explain within a pixel, and for
/// points in one plane, which many explain.
std::optional<cv::Point3d> viewpointOfGrid(const PointCloud& cloud);

/// T_view_cloud: into the frame of a camera at `viewpoint` [m] (x right, y down, z forward) that looks at the
/// centroid of the points, which are finite; its roll is arbitrary. Throws Error (invalidOption) on a
/// viewpoint that is not finite, or the centroid itself.
cv::Affine3d viewFrom(const cv::Point3d& viewpoint, std::span<const cv::Point3f> points);

/// A part of the points, drawn at random with a fixed seed, in their order.
std::vector<cv::Point3f> drawnFrom(std::span<const cv::Point3f> points, std::size_t count);

/// The direction from which a cloud shows one side, as seen from afar: the mean of the directions in which
/// hardly anything lies behind something else, and towards which the cloud bulges. None where from every
/// direction more than a quarter of it does, as for an object of which all sides are known. A unit vector
/// from the cloud towards the sensor. `spacing` is that of the points [m].
std::optional<cv::Point3d> directionOfView(std::span<const cv::Point3f> points, double spacing,
                                           int threads = 1);

}  // namespace estancia
