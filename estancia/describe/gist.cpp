// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/gist.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/simd.hpp"
#include "estancia/describe/gist_filters.hpp"

namespace estancia {
namespace {

constexpr int border = 5;      // mirrored around the image [pixels]
constexpr double cutOff = 4;   // half of it passes [cycles an image]
constexpr float noise = 0.2F;  // contrast below this is left small
constexpr int waves = 18;      // less than 1e-6 of higher ones passes

/// c = a b for a (n × m) and b (m × columns); all row-major.
ESTANCIA_MULTIVERSION void multiply(const float* a, const float* b, float* c, int n, int m, int columns) {
  for (int i = 0; i < n; ++i) {
    float* out = c + static_cast<std::ptrdiff_t>(i) * columns;
    const float* weights = a + static_cast<std::ptrdiff_t>(i) * m;
    for (int j = 0; j < columns; ++j) out[j] = 0;
    int k = 0;
    for (; k + 4 <= m; k += 4) {
      const float *b0 = b + static_cast<std::ptrdiff_t>(k) * columns, *b1 = b0 + columns, *b2 = b1 + columns,
                  *b3 = b2 + columns;
      const float w0 = weights[k], w1 = weights[k + 1], w2 = weights[k + 2], w3 = weights[k + 3];
#pragma omp simd
      for (int j = 0; j < columns; ++j) out[j] += (w0 * b0[j] + w1 * b1[j]) + (w2 * b2[j] + w3 * b3[j]);
    }
    for (; k < m; ++k) {
      const float* bk = b + static_cast<std::ptrdiff_t>(k) * columns;
#pragma omp simd
      for (int j = 0; j < columns; ++j) out[j] += weights[k] * bk[j];
    }
  }
}

cv::Mat product(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat c(a.rows, b.cols, CV_32F);
  multiply(a.ptr<float>(), b.ptr<float>(), c.ptr<float>(), a.rows, a.cols, b.cols);
  return c;
}

/// The transfer function exp(-f² / s²) in both directions, on an image that goes on periodically. It passes
/// so few waves that two thin matrices do it in a fraction of a Fourier transform's time: A (Aᵀ X A) Aᵀ.
class LowPass {
 public:
  explicit LowPass(int side) : waves_(side, 2 * waves + 1, CV_32F) {
    const double s = cutOff / std::sqrt(std::numbers::ln2);
    for (int x = 0; x < side; ++x)
      for (int k = 0; k <= waves; ++k) {
        const double norm = std::sqrt((k == 0 ? 1.0 : 2.0) / side) * std::exp(-k * k / (2 * s * s));
        const double phase = 2 * std::numbers::pi * k * x / side;
        waves_.at<float>(x, k) = static_cast<float>(norm * std::cos(phase));
        if (k > 0) waves_.at<float>(x, waves + k) = static_cast<float>(norm * std::sin(phase));
      }
    transposed_ = waves_.t();
  }

  cv::Mat operator()(const cv::Mat& image) const {
    const cv::Mat passed = product(product(transposed_, image), waves_);
    return product(product(waves_, passed), transposed_);
  }

 private:
  cv::Mat waves_;  ///< a column a wave, times the square root of what passes
  cv::Mat transposed_;
};

/// `gray` (CV_32F, square, even, 0 to 255) in logarithms, without what varies slower than 4 cycles an image,
/// divided by 0.2 + the standard deviation around each pixel (Oliva, Torralba: prefilt, cut-off 4).
cv::Mat withEqualContrast(const cv::Mat& gray) {
  static const LowPass common(256 + 2 * border);
  const bool isCommon = gray.cols == 256;
  cv::Mat image;
  cv::log(gray + 1, image);
  cv::copyMakeBorder(image, image, border, border, border, border, cv::BORDER_REFLECT);
  const auto smooth = [&](const cv::Mat& m) { return isCommon ? common(m) : LowPass(m.cols)(m); };
  const cv::Mat detail = image - smooth(image);
  cv::Mat deviation = cv::abs(smooth(detail.mul(detail)));
  cv::sqrt(deviation, deviation);
  cv::Mat equal = detail / (deviation + noise);
  return equal({border, border, gray.cols, gray.rows}).clone();
}

using namespace describe;

/// The image's central square, the mean of its channels, 0 to 255.
cv::Mat square(const cv::Mat& image) {
  if (image.empty()) throw Error(ErrorCode::invalidInput, "gist: the view has no image; give one");
  if (image.type() != CV_8UC3 && image.type() != CV_8UC1)
    throw Error(ErrorCode::invalidInput, "gist: the image is neither BGR nor gray with 8 bits; convert it");
  const int side = std::min(image.cols, image.rows);
  const cv::Mat part = image({(image.cols - side) / 2, (image.rows - side) / 2, side, side});
  cv::Mat gray, sized;
  part.convertTo(gray, CV_32F);
  if (gray.channels() == 3) cv::transform(gray, gray, cv::Matx13f(1, 1, 1));
  cv::resize(gray, sized, {gistSide, gistSide}, 0, 0, side > gistSide ? cv::INTER_AREA : cv::INTER_LINEAR);
  double darkest = 0, brightest = 0;
  cv::minMaxLoc(sized, &darkest, &brightest);
  if (!(brightest > darkest)) return cv::Mat::zeros(sized.size(), CV_32F);
  sized.convertTo(sized, CV_32F, 255 / (brightest - darkest), -255 * darkest / (brightest - darkest));
  return sized;
}

}  // namespace

std::vector<float> gist(const cv::Mat& image) {
  return meanAnswers(withEqualContrast(square(image)));
}

std::vector<DescriptorPart> Gist::parts() const {
  DescriptorPart part{
      "gist", PartKind::energies, {}, "gist 1, 256 pixels, 4 scales, 8 orientations, 4 blocks"};
  for (int scale = 0; scale < gistScales; ++scale)
    for (int orientation = 0; orientation < gistOrientations; ++orientation)
      for (int block = 0; block < gistBlocks * gistBlocks; ++block)
        part.columns.push_back(fmt::format("gist {}.{}.{}", scale, orientation, block));
  return {std::move(part)};
}

}  // namespace estancia
