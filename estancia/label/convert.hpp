// Networks of any format, written as ONNX files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "estancia/label/model_spec.hpp"

namespace estancia {

/// What an ONNX network takes and gives.
struct OnnxSummary {
  using Tensor = std::pair<std::string, std::vector<std::int64_t>>;  ///< name and shape; 0 = any size
  std::vector<Tensor> inputs, outputs;
  std::int64_t operatorSet = 0;
  std::size_t nodes = 0;
};

/// The network of a spec whose model.toml does not exist: a file that says itself what it takes.
ModelSpec specOfFile(const std::filesystem::path& network);

/// Writes the network of `spec` to `target` as ONNX that any engine can open, after ONNX's own checker has
/// found it sound and its shapes to follow from one another. Throws Error when the network cannot be read or
/// is not sound, when `target` exists and `overwrite` is false, and when it cannot be written.
OnnxSummary convertToOnnx(const ModelSpec& spec, const std::filesystem::path& target, bool overwrite = false);

}  // namespace estancia
