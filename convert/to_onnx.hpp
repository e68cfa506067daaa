// Network conversion: TensorFlow Lite and TensorFlow.js files → ONNX files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "convert/activation_ranges.hpp"

namespace estancia::convert {

/// A network and, of a TensorFlow.js graph, the part of it that is wanted.
struct NetworkSource {
  /// .tflite, .lite, .json (TensorFlow.js graph model) or .onnx.
  std::filesystem::path file;
  /// TensorFlow.js: the node that is fed with the image; "" = the only placeholder.
  std::string inputNode = {};
  /// TensorFlow.js: the node of the scores; "" = the only node that no other reads.
  std::string outputNode = {};
  /// TensorFlow.js: size of the image [pixels]; 0 = as the placeholder declares.
  int width = 0, height = 0;
};

/// Inputs and outputs of an ONNX network.
struct OnnxSummary {
  /// Name and shape; 0 = any size.
  using Tensor = std::pair<std::string, std::vector<std::int64_t>>;
  std::vector<Tensor> inputs, outputs;
  std::int64_t operatorSet = 0;
  std::size_t nodes = 0;
};

/// Whether `file` is a TensorFlow Lite or TensorFlow.js network, by its extension.
bool needsConversion(const std::filesystem::path& file);

/// The network as a serialized ONNX model (an ONNX file as it is). Throws Error when it is missing, damaged
/// or of an unsupported kind.
std::string readAsOnnx(const NetworkSource& source);

/// Writes the network to `target` after ONNX's checker and shape inference have accepted it. Throws Error
/// when it cannot be read or is invalid, when `target` exists and `overwrite` is false, and when it cannot be
/// written.
OnnxSummary writeOnnx(const NetworkSource& source, const std::filesystem::path& target,
                      bool overwrite = false);

/// Writes the float network of an .onnx file in 8 bits, by a table of the ranges of its values
/// (readRanges()). Throws Error as above, and when it cannot be quantized or the table lacks a value.
void writeQuantized(const std::filesystem::path& network, const std::filesystem::path& ranges,
                    const std::filesystem::path& target);

/// Writes a serialized network, which is called `source` in messages.
void writeQuantized(const std::string& onnx, const std::string& source, const ActivationRanges& ranges,
                    const std::filesystem::path& target);

}  // namespace estancia::convert
