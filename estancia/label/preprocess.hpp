// What a network wants done to an image before it sees it.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>

namespace estancia {

/// How an image becomes a network's input, in this order: the region is cut out of the image's center,
/// resized to width × height, its colors are put in order, and every value v becomes (v − mean) · scale.
struct Preprocessing {
  enum class Region {
    /// A square, `crop` of the image's shorter side: keeps shapes, drops the ends of the longer side.
    square,
    stretch,  ///< `crop` of the width by `crop` of the height: sees more, but squeezes (Caffe's habit)
  };
  enum class Resize { area, linear, cubic };
  enum class Color { rgb, bgr };

  int width = 224, height = 224;  ///< of the input [pixels]
  Region region = Region::square;
  double crop = 0.875;           ///< in (0, 1]; "resize to 256, cut 224" is 224 / 256 = 0.875
  Resize resize = Resize::area;  ///< how to shrink (area averages all pixels); `area` enlarges linearly
  Color color = Color::rgb;      ///< order of the input's channels, also of `mean` and `scale`
  std::array<double, 3> mean{0, 0, 0};   ///< subtracted from values of 0 … 255
  std::array<double, 3> scale{1, 1, 1};  ///< multiplied afterwards, e.g. 1 / 127.5
};

/// The image as float32 blob 1×3×height×width. Takes 1 (gray), 3 (BGR) or 4 (BGRA; alpha is dropped) channels
/// of 8 or 16 bits, any size. Throws Error on anything else.
cv::Mat preprocess(const cv::Mat& image, const Preprocessing& how);

}  // namespace estancia
