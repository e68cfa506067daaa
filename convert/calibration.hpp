// Calibration: the ranges of a network's values, measured on images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "convert/activation_ranges.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/labelers/model_spec.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia::convert {

struct CalibrationOptions {
  /// Evenly spread over the sequence.
  std::size_t images = 200;
  /// Each image is looked at so much darker and brighter, too [EV]; 0 = only as it is.
  double light = 0.7;
};

OptionGroup declare(CalibrationOptions& options);

/// How often a value lay where. Widths are powers of two, so that neither the order of the numbers nor the
/// processor's last digits change what comes out.
class ValueHistogram {
 public:
  /// Not finite numbers are counted as 0.
  void add(std::span<const float> numbers);
  /// The range whose 256 steps have the least squared error over all numbers, those beyond it cut off: the
  /// one of all numbers, or less of it on both sides (Jacob et al. 2018 and Krishnamoorthi 2018 take all).
  ActivationRange range() const;

 private:
  static constexpr int bins = 1 << 14;
  void widen();
  double centerOf(int bin) const { return (bin - bins / 2 + 0.5) * width_; }
  double squaredError(double low, double high) const;

  double width_ = 1.0 / (1 << 20);
  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(bins);
  std::uint64_t zeros_ = 0;  ///< which every range represents exactly
};

struct MeasuredRanges {
  ActivationRanges ranges;
  std::size_t images = 0;
  /// One sentence an image that could not be used.
  std::vector<std::string> problems;
};

/// Runs the float network of `spec`, whose serialized form is `onnx`, on images of the sequence and measures
/// the values that quantizedOnnx() needs. `threads` = 0: one per free core. The result does not depend on the
/// number of threads. Throws Error when no image can be used, when the network cannot be quantized or opened,
/// without ONNX Runtime, and Interrupted.
MeasuredRanges measureRanges(const ModelSpec& spec, const std::string& onnx, const Sequence& images,
                             const CalibrationOptions& options = {}, int threads = 0,
                             Progress& progress = Progress::none());

}  // namespace estancia::convert
