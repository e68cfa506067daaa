// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/gist_filters.hpp"

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "estancia/core/simd.hpp"

namespace estancia::describe {
namespace {

constexpr int border = 32;  // mirrored around the image [pixels]
constexpr int whole = gistSide + 2 * border;
constexpr double minGain = 1e-4;  // smaller values of a transfer function are left out

/// A filter's response is band-limited, so that its magnitude is smooth and can be sampled. These positions
/// of each step × step tile are sampled: as many in every row and column, with the mean position of all
/// pixels, so that edges are not biased. The two coarse scales need only the first two. The responses at one
/// position of all tiles are an inverse Fourier transform of 1/step² the size.
constexpr int step = 4;
constexpr int smallSide = whole / step;
struct Place {
  int x, y;
};
constexpr std::array<Place, 4> placesOfFilters{{{0, 1}, {3, 2}, {1, 3}, {2, 0}}};
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
  const double off = std::hypot(fx, fy) / whole / center - 1;
  return std::exp(-3.5 * off * off - 2 * std::numbers::pi * angle * angle);
}

Filter makeFilter(int scale, int orientation) {
  const auto frequency = [](int k) { return k < whole / 2 ? k : k - whole; };
  Filter filter;
  std::array<float, smallSide> row{};
  for (int y = 0; y < whole; ++y)
    for (int tile = 0; tile < whole; tile += smallSide) {
      int first = smallSide, last = -1;
      for (int x = 0; x < smallSide; ++x) {
        const double passes = transfer(scale, orientation, frequency(tile + x), frequency(y));
        row[static_cast<std::size_t>(x)] = static_cast<float>(passes / (whole * whole));
        if (passes < minGain) continue;
        first = std::min(first, x);
        last = x;
      }
      if (last < 0) continue;
      filter.pieces.push_back(
          {y * whole + tile + first, y % smallSide * smallSide + first, last + 1 - first});
      for (int x = first; x <= last; ++x)
        filter.weights.insert(filter.weights.end(), 2, row[static_cast<std::size_t>(x)]);
    }
  return filter;
}

std::vector<Filter> makeFilters() {
  std::vector<Filter> filters;
  for (int scale = 0; scale < gistScales; ++scale)
    for (int orientation = 0; orientation < gistOrientations; ++orientation)
      filters.push_back(makeFilter(scale, orientation));
  return filters;
}

/// e^(2πi k p / n) for k = 0 … n-1, real and imaginary parts in turn.
std::vector<float> turnsOf(int p) {
  std::vector<float> turns;
  for (int k = 0; k < whole; ++k) {
    const double phase = 2 * std::numbers::pi * (k * p % whole) / whole;
    turns.push_back(static_cast<float>(std::cos(phase)));
    turns.push_back(static_cast<float>(std::sin(phase)));
  }
  return turns;
}

/// The spectrum of the image shifted so that the position becomes the origin.
ESTANCIA_MULTIVERSION void move(const float* spectrum, const float* turnsX, const float* turnsY,
                                float* moved) {
  for (int y = 0; y < whole; ++y) {
    const float cy = turnsY[2 * y], sy = turnsY[2 * y + 1];
    const float* in = spectrum + static_cast<std::ptrdiff_t>(2) * y * whole;
    float* out = moved + static_cast<std::ptrdiff_t>(2) * y * whole;
#pragma omp simd
    for (int x = 0; x < whole; ++x) {
      const float c = turnsX[2 * x] * cy - turnsX[2 * x + 1] * sy;
      const float s = turnsX[2 * x] * sy + turnsX[2 * x + 1] * cy;
      out[2 * x] = in[2 * x] * c - in[2 * x + 1] * s;
      out[2 * x + 1] = in[2 * x] * s + in[2 * x + 1] * c;
    }
  }
}

ESTANCIA_MULTIVERSION void apply(const Filter& filter, const float* spectrum, float* small) {
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
  constexpr int side = gistSide / gistBlocks / step;
  for (int row = 0; row < gistBlocks; ++row) {
    std::array<float, gistSide / step> columns{};
    for (int y = row * side; y < (row + 1) * side; ++y)
      addMagnitudes(answers.ptr<float>(y), columns.data(), gistSide / step);
    for (int x = 0; x < gistSide / step; ++x)
      sums[row * gistBlocks + x / side] += columns[static_cast<std::size_t>(x)];
  }
}

}  // namespace

std::vector<float> meanAnswers(const cv::Mat& image) {
  static const std::vector<Filter> filters = makeFilters();
  cv::Mat bordered, spectrum;
  cv::copyMakeBorder(image, bordered, border, border, border, border, cv::BORDER_REFLECT);
  cv::dft(bordered, spectrum, cv::DFT_COMPLEX_OUTPUT);

  constexpr std::size_t blocks = gistBlocks * gistBlocks;
  std::vector<float> means(filters.size() * blocks);
  cv::Mat moved(spectrum.size(), CV_32FC2), answers(smallSide, smallSide, CV_32FC2);
  for (std::size_t p = 0; p < placesOfFilters.size(); ++p) {
    // The image begins where its border ends.
    move(spectrum.ptr<float>(), turnsOf(border + placesOfFilters[p].x).data(),
         turnsOf(border + placesOfFilters[p].y).data(), moved.ptr<float>());
    for (std::size_t f = 0; f < filters.size(); ++f) {
      if (p >= placesOfScale[f / gistOrientations]) continue;
      answers.setTo(0);
      apply(filters[f], moved.ptr<float>(), answers.ptr<float>());
      cv::dft(answers, answers, cv::DFT_INVERSE);
      addBlocks(answers, &means[f * blocks]);
    }
  }
  for (std::size_t i = 0; i < means.size(); ++i)
    means[i] /= static_cast<float>(gistSide * gistSide) / (step * step * blocks) *
                static_cast<float>(placesOfScale[i / (gistOrientations * blocks)]);
  return means;
}

}  // namespace estancia::describe
