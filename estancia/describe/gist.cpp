// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/gist.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr int gistSide = 256;  // side of the resized image [pixels]
constexpr int gistBlocks = 4, gistScales = 4, gistOrientations = 8;
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

// ---- Gabor filters and their mean responses

constexpr int filterBorder = 32;  // mirrored around the image [pixels]
constexpr int wholeSide = gistSide + 2 * filterBorder;
constexpr double minGain = 1e-4;  // smaller values of a transfer function are left out

/// A filter's response is band-limited, so that its magnitude is smooth and can be sampled. These positions
/// of each tile are sampled: as many in every row and column, with the mean position of all pixels, so that
/// edges are not biased. The two coarse scales need only the first two. The responses at one position of all
/// tiles are an inverse Fourier transform of 1/tileSide² the size.
constexpr int tileSide = 4;
constexpr int smallSide = wholeSide / tileSide;
struct TilePlace {
  int x, y;
};
constexpr std::array<TilePlace, 4> placesOfFilters{{{0, 1}, {3, 2}, {1, 3}, {2, 0}}};
constexpr std::array<std::size_t, gistScales> placesOfScale{4, 4, 2, 2};

/// A transfer function where it is not 0, as pieces of rows. Each is added to a smaller spectrum (aliased).
struct Filter {
  struct Piece {
    int from, to, length;  ///< numbers of the spectrum, of the smaller one, and how many
  };
  std::vector<Piece> pieces;
  std::vector<float> weights;  ///< piece by piece, each twice: for the real and the imaginary part
};

/// The transfer function of the authors' createGabor; frequencies in cycles an image of whole pixels.
double transfer(int scale, int orientation, int fx, int fy) {
  const double center = 0.3 / std::pow(1.85, scale);
  double angle = std::atan2(fy, fx) + std::numbers::pi / gistOrientations * orientation;
  if (angle > std::numbers::pi) angle -= 2 * std::numbers::pi;
  const double off = std::hypot(fx, fy) / wholeSide / center - 1;
  return std::exp(-3.5 * off * off - 2 * std::numbers::pi * angle * angle);
}

Filter makeFilter(int scale, int orientation) {
  const auto frequency = [](int k) { return k < wholeSide / 2 ? k : k - wholeSide; };
  Filter filter;
  std::array<float, smallSide> row{};
  for (int y = 0; y < wholeSide; ++y)
    for (int tile = 0; tile < wholeSide; tile += smallSide) {
      int first = smallSide, last = -1;
      for (int x = 0; x < smallSide; ++x) {
        const double passes = transfer(scale, orientation, frequency(tile + x), frequency(y));
        row[static_cast<std::size_t>(x)] = static_cast<float>(passes / (wholeSide * wholeSide));
        if (passes < minGain) continue;
        first = std::min(first, x);
        last = x;
      }
      if (last < 0) continue;
      filter.pieces.push_back(
          {y * wholeSide + tile + first, y % smallSide * smallSide + first, last + 1 - first});
      for (int x = first; x <= last; ++x)
        filter.weights.insert(filter.weights.end(), 2, row[static_cast<std::size_t>(x)]);
    }
  return filter;
}

/// e^(2πi k p / n) for k = 0 … n-1, real and imaginary parts in turn.
std::vector<float> turnsOf(int p) {
  std::vector<float> turns;
  for (int k = 0; k < wholeSide; ++k) {
    const double phase = 2 * std::numbers::pi * (k * p % wholeSide) / wholeSide;
    turns.push_back(static_cast<float>(std::cos(phase)));
    turns.push_back(static_cast<float>(std::sin(phase)));
  }
  return turns;
}

/// The spectrum of the image shifted so that the position becomes the origin.
ESTANCIA_MULTIVERSION void shift(const float* spectrum, const float* turnsX, const float* turnsY,
                                 float* moved) {
  for (int y = 0; y < wholeSide; ++y) {
    const float cy = turnsY[2 * y], sy = turnsY[2 * y + 1];
    const float* in = spectrum + static_cast<std::ptrdiff_t>(2) * y * wholeSide;
    float* out = moved + static_cast<std::ptrdiff_t>(2) * y * wholeSide;
#pragma omp simd
    for (int x = 0; x < wholeSide; ++x) {
      const float c = turnsX[2 * x] * cy - turnsX[2 * x + 1] * sy;
      const float s = turnsX[2 * x] * sy + turnsX[2 * x + 1] * cy;
      out[2 * x] = in[2 * x] * c - in[2 * x + 1] * s;
      out[2 * x + 1] = in[2 * x] * s + in[2 * x + 1] * c;
    }
  }
}

ESTANCIA_MULTIVERSION void applyFilter(const Filter& filter, const float* spectrum, float* small) {
  const float* weights = filter.weights.data();
  for (const Filter::Piece& piece : filter.pieces) {
    const float* in = spectrum + static_cast<std::ptrdiff_t>(2) * piece.from;
    float* out = small + static_cast<std::ptrdiff_t>(2) * piece.to;
#pragma omp simd
    for (int i = 0; i < 2 * piece.length; ++i) out[i] += weights[i] * in[i];
    weights += static_cast<std::ptrdiff_t>(2) * piece.length;
  }
}

/// Adds the magnitudes of `count` answers to those of the rows above.
ESTANCIA_MULTIVERSION void addMagnitudes(const float* answers, float* columns, int count) {
#pragma omp simd
  for (int i = 0; i < count; ++i)
    columns[i] += std::sqrt(answers[2 * i] * answers[2 * i] + answers[2 * i + 1] * answers[2 * i + 1]);
}

/// Adds the answers at one place of every tile to the sums of the blocks, row by row.
void addBlocks(const cv::Mat& answers, float* sums) {
  constexpr int side = gistSide / gistBlocks / tileSide;
  for (int row = 0; row < gistBlocks; ++row) {
    std::array<float, gistSide / tileSide> columns{};
    for (int y = row * side; y < (row + 1) * side; ++y)
      addMagnitudes(answers.ptr<float>(y), columns.data(), gistSide / tileSide);
    for (int x = 0; x < gistSide / tileSide; ++x)
      sums[row * gistBlocks + x / side] += columns[static_cast<std::size_t>(x)];
  }
}

/// `image` is CV_32F, gistSide × gistSide. A number a scale, orientation and block, in that order.
std::vector<float> meanAnswers(const cv::Mat& image) {
  static const std::vector<Filter> filters = [] {
    std::vector<Filter> all;
    for (int f = 0; f < gistScales * gistOrientations; ++f)
      all.push_back(makeFilter(f / gistOrientations, f % gistOrientations));
    return all;
  }();
  cv::Mat bordered, spectrum;
  cv::copyMakeBorder(image, bordered, filterBorder, filterBorder, filterBorder, filterBorder,
                     cv::BORDER_REFLECT);
  cv::dft(bordered, spectrum, cv::DFT_COMPLEX_OUTPUT);

  constexpr std::size_t blocks = gistBlocks * gistBlocks;
  std::vector<float> means(filters.size() * blocks);
  cv::Mat moved(spectrum.size(), CV_32FC2), answers(smallSide, smallSide, CV_32FC2);
  for (std::size_t p = 0; p < placesOfFilters.size(); ++p) {
    // The image begins where its border ends.
    shift(spectrum.ptr<float>(), turnsOf(filterBorder + placesOfFilters[p].x).data(),
          turnsOf(filterBorder + placesOfFilters[p].y).data(), moved.ptr<float>());
    for (std::size_t f = 0; f < filters.size(); ++f) {
      if (p >= placesOfScale[f / gistOrientations]) continue;
      answers.setTo(0);
      applyFilter(filters[f], moved.ptr<float>(), answers.ptr<float>());
      cv::dft(answers, answers, cv::DFT_INVERSE);
      addBlocks(answers, &means[f * blocks]);
    }
  }
  for (std::size_t i = 0; i < means.size(); ++i)
    means[i] /= static_cast<float>(gistSide * gistSide) / (tileSide * tileSide * blocks) *
                static_cast<float>(placesOfScale[i / (gistOrientations * blocks)]);
  return means;
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
