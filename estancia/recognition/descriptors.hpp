// Numbers that describe the surface around a keypoint, whichever way it is turned (thesis 2.4.3).
#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia {

/// The descriptors by name, each with one line of explanation: shot, fpfh, spin-image.
std::vector<std::pair<std::string, std::string>> descriptorMethods();

/// Described keypoints; all lists are equally long.
struct SurfaceFeatures {
  std::vector<std::uint32_t> keypoints;      ///< indices of the surface's points
  std::vector<cv::Point3f> points, normals;  ///< of them
  std::vector<cv::Matx33f> frames;           ///< rows are x, y, z of the local frame (localFrame())
  DescriptorMatrix descriptors{0};

  std::size_t size() const { return keypoints.size(); }
};

/// What tells one way along an axis of a local frame from the other.
enum class FrameSigns {
  majority,  ///< where more points lie, as PCL has it
  normal  ///< z along the normal, x to where points lie further ahead: steadier where surfaces have normals
};

/// Describes keypoints by the surface within `radius` [m]. Left out are those around which it has fewer than
/// five points. Throws Error on an unknown method, naming the known ones, and on a radius that cannot be
/// (Surface::requireRadius). The same for any number of threads.
SurfaceFeatures describe(const Surface& surface, std::span<const std::uint32_t> keypoints,
                         const std::string& method, double radius, int threads = 1,
                         FrameSigns signs = FrameSigns::majority);

// ---- each for itself: rows of `values`, one a keypoint, full of NaN where too few points are near

/// SHOT (Salti, Tombari, Di Stefano 2014), shape only: 352 numbers in the local frame of localFrames().
/// PCL's SHOTEstimation within rounding.
void describeShot(const Surface& surface, std::span<const std::uint32_t> keypoints,
                  std::span<const cv::Matx33f> frames, double radius, int threads,
                  std::vector<float>& values);

/// FPFH (Rusu, Blodow, Beetz 2009): 33 numbers. PCL's FPFHEstimation within rounding.
void describeFpfh(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius,
                  int threads, std::vector<float>& values);

/// Spin image (Johnson and Hebert 1999): 153 numbers, 9 distances from the normal × 17 heights, of the points
/// whose normals differ by less than 60°. PCL's SpinImageEstimation(8, 0.5) within rounding.
void describeSpinImage(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius,
                       int threads, std::vector<float>& values);

/// The local frames of SHOT: axes of the points within `radius`, weighted by how near they are; full of NaN
/// where fewer than five are near. With FrameSigns::majority PCL's SHOTLocalReferenceFrameEstimation within
/// rounding.
std::vector<cv::Matx33f> localFrames(const Surface& surface, std::span<const std::uint32_t> keypoints,
                                     double radius, int threads, FrameSigns signs = FrameSigns::majority);

}  // namespace estancia
