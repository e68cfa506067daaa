// SPDX-License-Identifier: Apache-2.0
#include "features/layer_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/png.hpp"
#include "estancia/labelers/engines.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/model_files.hpp"
#include "estancia/labelers/network_labeler.hpp"

namespace estancia::experiments {
namespace {

constexpr int mosaicSide = 480;     // pixels
constexpr int tilesInARow = 8;      // at most
constexpr int gapBetweenTiles = 2;  // pixels

/// The `count` channels with the largest sum of squares, in ascending order.
std::vector<std::size_t> strongest(std::span<const float> values, std::size_t channels, std::size_t count) {
  const std::size_t size = values.size() / channels;
  std::vector<double> energies(channels);
  for (std::size_t c = 0; c < channels; ++c)
    for (const float value : values.subspan(c * size, size))
      energies[c] += static_cast<double>(value) * static_cast<double>(value);
  std::vector<std::size_t> order(channels);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return energies[a] > energies[b]; });
  order.resize(std::min(count, channels));
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace

cv::Mat drawChannels(std::span<const float> values, std::size_t channels) {
  if (channels == 0 || values.empty() || values.size() % channels != 0) return {};
  const std::size_t size = values.size() / channels;
  const int side = cvRound(std::sqrt(static_cast<double>(size)));
  if (static_cast<std::size_t>(side) * static_cast<std::size_t>(side) != size) return {};
  const auto shown = strongest(values, channels, tilesInARow * tilesInARow);
  const int row = cvCeil(std::sqrt(static_cast<double>(shown.size()))), tile = mosaicSide / row;
  cv::Mat mosaic(mosaicSide, mosaicSide, CV_8UC1, cv::Scalar(0));
  for (std::size_t i = 0; i < shown.size(); ++i) {
    cv::Mat channel(side, side, CV_32F);
    std::ranges::copy(values.subspan(shown[i] * size, size), channel.begin<float>());
    cv::normalize(channel, channel, 0, 255, cv::NORM_MINMAX);
    channel.convertTo(channel, CV_8U);
    const int at = static_cast<int>(i), inner = tile - gapBetweenTiles;
    cv::resize(channel, mosaic({at % row * tile, at / row * tile, inner, inner}), {inner, inner}, 0, 0,
               side > inner ? cv::INTER_AREA : cv::INTER_NEAREST);
  }
  return mosaic;
}

Images layerFigures(const std::vector<ShownLayer>& layers, const cv::Mat& image, const std::string& name) {
  Images figures{
      "What inner layers show (Fig. 1.14)",
      fmt::format("Of {}: the channels with the most energy, at most 64, each by its own range.", name),
      {},
      false};
  for (const ShownLayer& layer : layers) {
    ModelSpec spec = readModelSpec(getModelFolder(layer.model));
    spec.output = layer.output;
    const std::string source = fmt::format("model {}", spec.name);
    const auto network = openNetworkValues(readOnnx(spec), source);
    const auto& names = network->names();
    const auto wanted = std::ranges::find(names, layer.output);
    if (wanted == names.end())
      fail(ErrorCode::invalidInput, "{} has no value {}; name an output of one of its nodes", source,
           layer.output);
    cv::Mat drawn;
    network->run(preprocess(image, spec.preprocessing), [&](std::size_t i, std::span<const float> values) {
      if (names[i] != *wanted) return;
      drawn = drawChannels(values, layer.channels);
      if (drawn.empty())
        fail(ErrorCode::invalidInput, "{} of {} has {} numbers, which are not {} square channels",
             layer.output, source, values.size(), layer.channels);
    });
    figures.images.push_back(
        {toPng(drawn), fmt::format("{}, {}, {} channels", spec.name, layer.output, layer.channels)});
  }
  return figures;
}

}  // namespace estancia::experiments
