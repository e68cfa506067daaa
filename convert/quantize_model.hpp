// Quantized models: the network of a model folder in 8 bits, beside the float one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "convert/calibration.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia::convert {

struct QuantizedModel {
  /// The network of 8 bits, in the model's folder.
  std::filesystem::path file;
  std::string sha256;
  /// Values of 8 bits inside of it.
  std::size_t values = 0;
  std::size_t images = 0;
  /// One sentence an image that could not be used.
  std::vector<std::string> problems;
};

struct QuantizeOptions {
  CalibrationOptions calibration;
  /// Threads of the network; 0 = one per free core.
  int threads = 0;
  /// A network of 8 bits that the model has.
  bool overwrite = false;
  /// Where to keep the table of ranges; "" = nowhere.
  std::filesystem::path ranges;
};

/// Measures the ONNX network of a model on the images, writes NAME-int8.onnx beside it and names that in
/// model.toml. Nothing changes unless all goes well. Throws Error when the model is no ONNX network, has a
/// network of 8 bits (unless `overwrite`), cannot be quantized, or cannot be written; Interrupted.
QuantizedModel quantizeModel(const std::filesystem::path& folder, const Sequence& images,
                             const QuantizeOptions& options = {}, Progress& progress = Progress::none());

/// The text of a model.toml that names `file` as the network of 8 bits, all else as it is. `name` stands for
/// the file in messages. Throws Error when the text has no line `file = …`.
std::string withInt8(const std::string& toml, const std::string& file, const std::string& digest,
                     const std::filesystem::path& name);

}  // namespace estancia::convert
