// Network values: what an ONNX network computes for an image, every output of it; for calibration.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

namespace estancia {

/// A network in ONNX Runtime of which all outputs are wanted.
class NetworkValues {
 public:
  virtual ~NetworkValues() = default;
  /// The names of the outputs.
  virtual const std::vector<std::string>& names() const = 0;
  /// Runs the network on an image as preprocess() makes it and gives each output's numbers to `use`, by its
  /// position in names(). Throws Error when the image does not fit, or an output holds no floats.
  virtual void run(const cv::Mat& blob,
                   const std::function<void(std::size_t, std::span<const float>)>& use) = 0;
};

/// Opens a serialized ONNX network; `source` names it in messages. `threads` = 0: one per free core; they
/// change no bit. Throws Error when ONNX Runtime is not at hand or cannot open the network.
std::unique_ptr<NetworkValues> openNetworkValues(const std::string& onnx, const std::string& source,
                                                 int threads = 0);

}  // namespace estancia
