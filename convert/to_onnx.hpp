// Network conversion: TensorFlow Lite and TensorFlow.js files → ONNX files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace estancia::convert {

/// A network and, of a TensorFlow.js graph, the part of it that is wanted.
struct NetworkSource {
  /// .tflite, .lite, .json (TensorFlow.js graph model) or .onnx.
  std::filesystem::path file;
  /// TensorFlow.js: the node that is fed with the image; "" = the only placeholder.
  std::string inputNode = {};
  /// TensorFlow.js: the node of the scores; "" = the only node that no other reads.
  std::string outputNode = {};
  /// TensorFlow.js: size of the image [pixels]; 0 = what the placeholder says.
  int width = 0, height = 0;
};

/// What an ONNX network takes and gives.
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

}  // namespace estancia::convert
