// Layer figures: what inner layers of a network make of an image (thesis Fig. 1.14).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "estancia/findings/findings.hpp"

namespace estancia::experiments {

/// A layer to look at.
struct ShownLayer {
  /// For getModelFolder(): an ONNX network.
  std::string model;
  /// A value inside of it, of `channels` square channels one after another.
  std::string output;
  std::size_t channels = 0;
};

/// The channels with the most energy, at most 8 × 8 of them in their order, each by its own range, 480 pixels
/// a side; CV_8UC1. Empty where the values are not so many square channels.
cv::Mat drawChannels(std::span<const float> values, std::size_t channels);

/// A figure a layer, of this image. Throws Error when a model cannot be opened, has no such value, or it has
/// other channels.
Images layerFigures(const std::vector<ShownLayer>& layers, const cv::Mat& image, const std::string& name);

}  // namespace estancia::experiments
