// TensorFlow.js graph: its nodes with names, inputs and attributes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"

namespace estancia::tfjs {

/// One node. Errors name it: "… in Conv2D (node "block/conv")".
struct Node {
  std::string name, op;
  std::vector<std::string> inputs;             ///< names of nodes, an output other than the first as "name:1"
  const nlohmann::json* attributes = nullptr;  ///< an object, or null when the node has none

  std::string where() const;
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::malformedFile) const;

  std::int64_t integer(const char* attribute, std::int64_t otherwise) const;
  double real(const char* attribute, double otherwise) const;
  bool flag(const char* attribute) const;  ///< false when it is left out
  std::string text(const char* attribute, const std::string& otherwise) const;
  /// Lists are empty when they are left out.
  std::vector<std::int64_t> integers(const char* attribute) const;
  std::vector<std::string> texts(const char* attribute) const;
  /// Shape that a placeholder accepts, -1 for any size; empty if not declared.
  std::vector<std::int64_t> shape() const;

  /// Rows and columns of a list such as strides: [1, rows, columns, 1], each from 1 to 1024.
  std::pair<int, int> perSide(const char* attribute, std::optional<int> otherwise = {}) const;
  /// SAME, else VALID. Throws Error on anything else.
  bool samePadding() const;
  /// Throws Error unless images are N×H×W×C.
  void requireChannelsLast() const;
  void requireInputs(std::size_t count) const;

 private:
  const nlohmann::json* find(const char* attribute) const;
};

/// All nodes by name.
class Nodes {
 public:
  /// `list` is the `modelTopology.node` of a model.json, and must outlive this.
  explicit Nodes(const nlohmann::json& list);

  /// Throws Error when there is no such node.
  const Node& at(const std::string& name) const;

  /// The node of an image, and the node that no other reads. Throws Error unless there is just one.
  std::string onlyPlaceholder() const;
  std::string onlyEnd() const;

  /// All nodes that `output` needs if `input` is given, each behind those it reads itself. Calls visit(node)
  /// for each before it looks at what that node reads. Throws Error when a node is missing, or needs itself.
  std::vector<const Node*> inOrder(const std::string& input, const std::string& output,
                                   const std::function<void(const Node&)>& visit) const;

 private:
  std::map<std::string, Node> nodes_;
};

}  // namespace estancia::tfjs
