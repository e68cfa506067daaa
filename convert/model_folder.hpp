// Model conversion: a model folder with a TensorFlow network → the same model with an ONNX network.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "convert/to_onnx.hpp"

namespace estancia::convert {

/// The network that model.toml in `folder` names, with its section and input size. Throws Error when
/// model.toml or one of these keys is missing or wrong, and when a digest in `sha256` disagrees with its
/// file.
NetworkSource networkOf(const std::filesystem::path& folder);

/// A model folder that the library opens: the given one, or where that names a TensorFlow network, a
/// converted copy in the temporary folder, which is removed at the end.
class ConvertedModel {
 public:
  /// Throws Error as convertModel().
  explicit ConvertedModel(const std::filesystem::path& folder);
  ~ConvertedModel();
  ConvertedModel(const ConvertedModel&) = delete;
  ConvertedModel& operator=(const ConvertedModel&) = delete;
  const std::filesystem::path& folder() const { return copy_.empty() ? original_ : copy_; }

 private:
  std::filesystem::path original_, copy_;
};

/// Writes the model of `folder` into the new folder `target`: the network as NAME.onnx, a model.toml that
/// names it, and the other files that model.toml names. Throws Error as networkOf() and writeOnnx().
void convertModel(const std::filesystem::path& folder, const std::filesystem::path& target);

}  // namespace estancia::convert
