// Segmentation stages: the steps of findClusters() that remove planes, compare segments and merge them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <utility>
#include <vector>

#include "estancia/cloud/bounds.hpp"
#include "estancia/segmentation/clusters.hpp"
#include "estancia/segmentation/inverse_depth.hpp"
#include "estancia/segmentation/segments.hpp"

namespace estancia {

/// Color of each pixel: lightness, weighted, and chroma over lightness, which shading does not change (in CIE
/// Lab, L + 16, a and b all grow with the cube root of the light). Empty without an image.
using SegmentColors = cv::Mat_<cv::Vec3f>;

/// The least change of color over 4 pixels at an edge of color.
constexpr double colorEdge = 7;

/// `image`: BGR, or empty; of the same view as the depth image of `size`, in any size.
SegmentColors segmentColors(const cv::Mat& image, const cv::Size& size);

/// Share of 1/z by which adjacent pixels of two surfaces differ at least where one ends before the other.
constexpr float depthStep = 0.02F;

/// Two segments side by side in the image, a < b; segment 0 is all pixels with depth that have none.
struct SegmentEdge {
  std::uint32_t a = 0, b = 0;
  std::size_t contacts = 0;                ///< pairs of adjacent pixels of about one depth
  std::size_t aInFront = 0, bInFront = 0;  ///< pairs at a depth edge
  double height = 0;                       ///< mean height of the contacts, along `up` [m]
  double contrast = 0;                     ///< change of color over 4 pixels across the contacts, their mean
  /// The distance of a quarter of the pixels to the other segment, across at most three pixels without a
  /// segment [m]; infinite for segment 0.
  float gap = 0;
};

/// Ascending by a, b. Without colors there is no contrast.
std::vector<SegmentEdge> segmentGraph(const InverseDepth& grid, const Segmentation& segments,
                                      const cv::Vec3d& up, const SegmentColors& colors = {});

struct SegmentSamples {
  std::uint32_t segment;
  std::vector<cv::Point3f> surface;  ///< spread over the segment, at most 1500
  std::vector<cv::Point3f> border;   ///< along its border in the image, at most 256
  Bounds<float> box;                 ///< box of the border
  std::vector<float> x, y, z;        ///< the border by coordinate, for SIMD
};

/// Samples the segments above a minimum size, in their order; at most the 512 largest.
std::vector<SegmentSamples> sampleSegments(const InverseDepth& grid, const Mask& mask,
                                           const Segmentation& segments);

/// Merges the pairs of segments that find(i) returns for each i below `count`; calls it on several threads.
using FindPairs = std::function<std::vector<std::pair<std::uint32_t, std::uint32_t>>(std::size_t)>;
void mergePairs(std::size_t count, const FindPairs& find, const Mask& mask, int threads,
                Segmentation& segments);

/// Every second pixel of every second row of an InverseDepth, with its normal.
struct HalfImage {
  int width, height;
  double pixelArea;               ///< area of a pixel on a surface at 1 m that faces the camera [m²]
  std::vector<float> x, y;        ///< slopes of the columns and rows
  std::vector<float> w;           ///< 1/z, 0: none
  std::vector<float> nx, ny, nz;  ///< unit vectors away from the camera; 0 where there is no normal
  std::vector<float> near;        ///< tolerance of w beside a plane a x + b y + c, divided by |(a, b, c)|
  std::size_t row(int v) const { return static_cast<std::size_t>(v) * static_cast<std::size_t>(width); }
  /// Normal at pixel (u, v) of the whole image.
  cv::Vec3d normal(int u, int v) const {
    const std::size_t at = row(v / 2) + static_cast<std::size_t>(u / 2);
    return {nx[at], ny[at], nz[at]};
  }
};

struct PlaneRemoval {
  std::vector<Plane> planes;     ///< in the order they were found
  std::vector<std::uint8_t> of;  ///< a pixel's plane, numbered from 1 on; 0: none
  Mask rest;                     ///< the pixels with depth that lie on none
  HalfImage half;
};

/// Plane removal: sequential RANSAC for the large planes of a depth image (tables, walls, floors), in which
/// one pixel with its normal is a hypothesis and areas are votes. Patches of a plane have at least half of
/// minPlaneArea, the largest all of it. Pixels behind a plane stay.
PlaneRemoval removePlanes(const InverseDepth& grid, const ClusterOptions& options);

/// Up, in the optical frame, as a unit vector: the direction within 60° of the image's up to which planes of
/// the largest area are parallel or perpendicular (Manhattan world; Coughlan and Yuille, ICCV 1999). The
/// image's up if there is no such plane.
cv::Vec3d upOf(const std::vector<Plane>& planes);

/// Sets Plane::structural. Level and sloping planes bound the room when nearly nothing is seen behind them:
/// the floor, but not the top of a table beside which the floor is seen. Upright planes are walls, unless
/// their upper edge is seen before what lies far behind it, or another plane, parallel and behind them by the
/// depth of furniture, is the wall that they stand at; and then so are the other faces of the thing, where
/// its surface turns convexly from one into the other. Upright planes as narrow as a wall is thick are the
/// walls' ends.
void findStructure(const InverseDepth& grid, const cv::Vec3d& up, PlaneRemoval& removal);

/// Takes the pixels of planes that are not structural from the planes: returns their connected patches as
/// segments, and gives pixels of small ones to `removal.rest`.
Segmentation takePatches(const InverseDepth& grid, PlaneRemoval& removal);

/// Drops the pixels of level surfaces that the camera sees so flat that they have no normals: the few rows of
/// a worktop near eye height. They would join what stands on it with what is below.
void dropGrazedLevels(const InverseDepth& grid, const cv::Vec3d& up, PlaneRemoval& removal);

/// Adds `patches` to the segments of `removal.rest`, and drops what is left of walls, floor and ceiling: flat
/// segments that are nowhere in front of another (the wall seen between things), and strips along walls
/// (skirting, frames and reveals of doors). Returns the pixels of what remains.
Mask dropStructure(const InverseDepth& grid, const PlaneRemoval& removal, const cv::Vec3d& up,
                   const Segmentation& patches, Segmentation& segments);

/// Joins crumbs that lie close together (leaves), and small segments whose lower ends are free, as nothing
/// floats, to the nearest larger segment, but to no body (too large for a hand) below them.
void joinLoose(const InverseDepth& grid, const Mask& mask, const HalfImage& half, const cv::Vec3d& up,
               Segmentation& segments);

/// Furniture assembly: joins to each body, a segment too large for a hand, what touches it and what carries
/// its level top. What stands on a body is a thing of its own: it begins where they touch, inside of the
/// border of a level surface, or above all of a body that is wider. So is a small segment of another color
/// than the body beside it. A crown joins its stem: a segment that is too wide to balance on what is below
/// it, or has no smooth surface (leaves).
void assembleFurniture(const InverseDepth& grid, const Mask& mask, const HalfImage& half,
                       const SegmentColors& colors, const cv::Vec3d& up, Segmentation& segments);

/// Drops fragments: segments that stand before nothing, nor on anything, small ragged ones for which this
/// holds on half of the border, and the ends of walls beside doors. Who owns a border (Nakayama et al.,
/// Perception 1989) distinguishes things from what shows between them.
void dropFragments(const InverseDepth& grid, const PlaneRemoval& removal, const cv::Vec3d& up,
                   const Mask& mask, Segmentation& segments);

/// Drops segments of less than 8 pixels' mean width, in which nearly all pixels mix them with what is behind.
/// Gaps narrower than that belong to the segment: leaves of a plant are narrow, the plant is not.
void dropNarrow(const InverseDepth& grid, const Mask& mask, Segmentation& segments);

/// Segment merging: merges segments that touch, within the camera's accuracy, without a concave corner
/// between them (a hole or the rim of the nearer one separates them in the image), and segments of one
/// surface that an occluder separates. Segments touch where the gap is no wider than pixels of mixed depth,
/// they are no farther apart than that and noise, and nothing behind is seen through the gap.
void mergeSegments(const InverseDepth& grid, const Mask& mask, int threads, Segmentation& segments);

/// Container merging: merges the segments inside of the round wall of a container (bowl, mug, pot) that
/// stands on one of `planes` with the wall.
void mergeContainerInteriors(const InverseDepth& grid, const Mask& mask, const std::vector<Plane>& planes,
                             int threads, Segmentation& segments);

/// Color splitting: splits a segment where two compact colors meet side by side and the surface goes on: two
/// things of one height that touch. Labels, patterns and bands stay, as do the faces of a thing.
void splitByColor(const InverseDepth& grid, const HalfImage& half, const SegmentColors& colors,
                  const cv::Vec3d& up, Segmentation& segments);

/// ClusterOptions::Method::euclidean: the connected components of what lies on none of `planes`, and the
/// pixels of all that does not.
std::pair<Segmentation, Mask> euclideanSegments(const InverseDepth& grid, const std::vector<Plane>& planes,
                                                int threads);

/// findClusters() from the points alone, thinned to one a voxel of 5 mm or two spacings. Concave creases
/// separate objects where the visible side of the surface is known: the cloud has normals or a viewpoint, or
/// the origin, the default position of a sensor, lies outside of it. Otherwise each connected component is an
/// object.
Clusters findUnorganizedClusters(const PointCloud& cloud, const ClusterOptions& options);

}  // namespace estancia
