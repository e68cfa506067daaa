// TensorFlow.js weights: the shards of bytes beside a model.json.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace estancia::tfjs {

/// The shards that the manifest in a model.json names, relative to its folder, in their order. Throws Error
/// when the file is no TensorFlow.js model or a path leaves the folder.
std::vector<std::filesystem::path> weightFiles(const std::filesystem::path& modelJson);

/// All weights of a network by name, as they are stored; decoded one by one on request.
class Weights {
 public:
  /// Reads the shards that `manifest` (the `weightsManifest` of a model.json in `folder`) names. Throws Error
  /// when shards are missing, lead out of the folder through a link, or do not hold exactly the bytes that
  /// the weights' shapes need.
  Weights(const nlohmann::json& manifest, const std::filesystem::path& folder);

  bool has(const std::string& name) const { return entries_.contains(name); }
  const std::vector<int>& shape(const std::string& name) const { return entry(name).shape; }
  std::size_t elements(const std::string& name) const { return entry(name).elements; }

  /// The values of a float weight, dequantized. Throws Error when it holds none.
  std::vector<float> reals(const std::string& name) const;

  /// The values of an integer weight (a shape, an axis). Throws Error when it holds none.
  std::vector<std::int64_t> integers(const std::string& name) const;

 private:
  enum class Stored { float32, int32, boolean, float16, uint8, uint16 };
  struct Entry {
    std::vector<int> shape;
    std::size_t elements = 1;
    std::string type;  ///< type of the values, as the file calls it
    Stored stored = Stored::float32;
    double scale = 1, least = 0;  ///< scale and offset of quantized values: real = stored · scale + least
    std::size_t start = 0;        ///< in bytes_
  };

  static Entry readEntry(const nlohmann::json& weight, const std::string& name);
  static std::size_t bytesOf(Stored stored);
  const Entry& entry(const std::string& name) const;
  double value(const Entry& entry, std::size_t i) const;

  std::map<std::string, Entry> entries_;
  std::vector<std::uint8_t> bytes_;  ///< bytes of all shards
};

}  // namespace estancia::tfjs
