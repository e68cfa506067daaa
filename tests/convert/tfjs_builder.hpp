// Writes small TensorFlow.js networks, right or wrong, for the tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/support.hpp"

namespace estancia::test {

/// A graph of nodes and one group of weights. `model` may be altered before it is written.
class TfjsBuilder {
 public:
  using Json = nlohmann::json;

  TfjsBuilder() {
    model["modelTopology"]["node"] = Json::array();
    model["weightsManifest"] = Json::array({{{"paths", {"shard1", "shard2"}}, {"weights", Json::array()}}});
    node("Placeholder", "image", {});
  }

  Json& node(const std::string& op, const std::string& name, const std::vector<std::string>& inputs,
             const Json& attributes = Json::object()) {
    auto& nodes = model["modelTopology"]["node"];
    nodes.push_back({{"name", name}, {"op", op}, {"input", inputs}, {"attr", attributes}});
    return nodes.back();
  }

  Json& weight(const std::string& name, const std::vector<int>& shape, const std::vector<float>& values) {
    return constant(name, shape, "float32", values);
  }
  Json& integers(const std::string& name, const std::vector<int>& shape,
                 const std::vector<std::int32_t>& values) {
    return constant(name, shape, "int32", values);
  }
  /// Values in a type of their own, `quantization` defines how to read them.
  template <class Stored>
  void quantized(const std::string& name, const std::vector<int>& shape, const std::vector<Stored>& values,
                 const Json& quantization) {
    constant(name, shape, "float32", values)["quantization"] = quantization;
  }

  static Json windowAttributes(int stride, bool same, int dilation = 1) {
    const auto list = [](int value) {
      return Json{{"list", {{"i", {"1", std::to_string(value), std::to_string(value), "1"}}}}};
    };
    // one text as base64, one as bytes: both occur
    return {{"strides", list(stride)},
            {"dilations", list(dilation)},
            {"padding", {{"s", same ? "U0FNRQ==" : "VkFMSUQ="}}},
            {"data_format", {{"s", {78, 72, 87, 67}}}}};
  }

  /// Writes model.json and its two shards into `folder`.
  std::filesystem::path write(const std::filesystem::path& folder) const {
    const std::size_t half = bytes_.size() / 2 - bytes_.size() / 2 % 3;  // in the middle of a number
    writeFile(folder / "shard1", bytes_.substr(0, half));
    writeFile(folder / "shard2", bytes_.substr(half));
    writeFile(folder / "model.json", model.dump());
    return folder / "model.json";
  }

  Json model;

 private:
  template <class Value>
  Json& constant(const std::string& name, const std::vector<int>& shape, const char* type,
                 const std::vector<Value>& values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
    node("Const", name, {});
    auto& weights = model["weightsManifest"][0]["weights"];
    weights.push_back({{"name", name}, {"shape", shape}, {"dtype", type}});
    return weights.back();
  }

  std::string bytes_;
};

}  // namespace estancia::test
