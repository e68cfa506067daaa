// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "convert/to_onnx.hpp"
#include "support/model_support.hpp"

namespace estancia::test {
namespace fs = std::filesystem;

ModelSpec testModel(const fs::path& models, const std::string& file, const std::string& labels,
                    const Preprocessing& preprocessing, const ScratchFolder& scratch) {
  const bool isOnnx = !convert::needsConversion(file);
  const std::string network = isOnnx ? file : file + ".onnx";
  if (isOnnx)
    fs::copy_file(models / file, scratch / file);
  else
    convert::writeOnnx({.file = models / file}, scratch / network);
  fs::copy_file(models / labels, scratch / labels, fs::copy_options::overwrite_existing);
  ModelSpec spec;
  spec.folder = scratch.path();
  spec.name = file;
  spec.file = network;
  spec.labels = labels;
  spec.preprocessing = preprocessing;
  return spec;
}

}  // namespace estancia::test
