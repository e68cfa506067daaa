// Inverse depth image: 1/z, in which planes are linear over the image and a depth camera's noise is uniform.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "estancia/core/camera.hpp"

namespace estancia {

/// A depth image with a margin of pixels without depth, so that neighborhoods need no bounds checks. Masks
/// and labels of it have its size() and the same indices.
struct InverseDepth {
  CameraIntrinsics camera;             ///< camera of this image
  double scale = 1;                    ///< focal length / 525, for which lengths in pixels are given
  int margin = 0;                      ///< on every side
  std::ptrdiff_t stride = 0;           ///< from row to row
  std::vector<float> raw;              ///< 1/z [1/m]; 0 where there is no depth
  std::vector<std::uint32_t> bridged;  ///< pixels without depth whose `raw` is interpolated
  std::vector<float> smooth;           ///< denoised
  std::vector<float> slopeX, slopeY;   ///< X / Z of the columns, Y / Z of the rows

  std::size_t size() const { return raw.size(); }
  std::size_t at(int u, int v) const { return static_cast<std::size_t>((v + margin) * stride + u + margin); }
  int column(std::size_t at) const {
    return static_cast<int>(static_cast<std::ptrdiff_t>(at) % stride) - margin;
  }
  int row(std::size_t at) const {
    return static_cast<int>(static_cast<std::ptrdiff_t>(at) / stride) - margin;
  }
  cv::Point3f point(std::size_t i) const { return point(column(i), row(i)); }
  cv::Point3f point(int u, int v) const {
    const float z = 1 / raw[at(u, v)];
    return {slopeX[static_cast<std::size_t>(u)] * z, slopeY[static_cast<std::size_t>(v)] * z, z};
  }
  int pixels(double length) const { return std::max(1, static_cast<int>(std::lround(length * scale))); }
  double area(double squarePixels) const { return squarePixels * scale * scale; }
};

/// Depths outside of 1 mm to 1 km count as missing. Lost rows, columns and pixels are bridged where the depth
/// goes on behind them, or each would cut a surface in two. The smooth image is the mean over the pairs of
/// opposite pixels in a window of 5 × 5 that are both near in depth: planes stay exact, and edges stay in
/// place. Throws Error as backProject() does.
InverseDepth inverseDepth(const cv::Mat& depth, const CameraIntrinsics& camera, int threads);

/// Whether two adjacent pixels may belong to one surface: their depths differ by less than 1.2 %.
inline bool isContinuous(float a, float b) {
  return std::abs(a - b) < 0.012F * std::min(a, b);
}

/// A set of pixels of an InverseDepth.
struct Mask {
  struct Span {
    std::size_t first, last;  ///< first ≤ i < last contains all pixels of a row; equal for none
  };
  std::vector<std::uint8_t> in;  ///< 1 where a pixel is in, else 0
  std::vector<Span> rows;

  /// Finds the spans.
  Mask(const InverseDepth& grid, std::vector<std::uint8_t> pixels);

  template <class Use>
  void eachPixel(const Use& use) const {
    for (const Span& row : rows)
      for (std::size_t i = row.first; i < row.last; ++i)
        if (in[i] != 0) use(i);
  }
};

/// Marks the pixels of `mask` at which the surface bends towards the camera by more than `depth` [m at 1 m]
/// over 4 to 8 pixels to either side, in any of four directions: where two convex objects touch, or one
/// stands on another.
std::vector<std::uint8_t> concaveCreases(const InverseDepth& grid, const Mask& mask, double depth,
                                         int threads);

/// Calls work(first, last) for bands of rows that together are 0 ≤ v < rows.
void inBands(int rows, int threads, const std::function<void(int, int)>& work);

}  // namespace estancia
