// SPDX-License-Identifier: Apache-2.0
#include "convert/fold_pads.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <vector>

namespace estancia::convert {
namespace {

/// Before and after the rows and the columns, as Conv lists them: top, left, bottom, right.
using Pads = std::vector<std::int64_t>;

const onnx::AttributeProto* attributeOf(const onnx::NodeProto& node, const std::string& name) {
  const auto found = std::find_if(node.attribute().begin(), node.attribute().end(),
                                  [&](const auto& attribute) { return attribute.name() == name; });
  return found == node.attribute().end() ? nullptr : &*found;
}

class Folder {
 public:
  explicit Folder(onnx::GraphProto& graph) : graph_(graph) {
    for (const auto& constant : graph_.initializer()) constants_[constant.name()] = &constant;
    for (const auto& node : graph_.node())
      if (const auto* value = attributeOf(node, "value"); node.op_type() == "Constant" && value != nullptr)
        constants_[node.output(0)] = &value->t();
  }

  void run() {
    std::vector<int> folded;
    for (int i = 0; i < graph_.node_size(); ++i)
      if (graph_.node(i).op_type() == "Pad" && fold(graph_.node(i))) folded.push_back(i);
    for (auto i = folded.rbegin(); i != folded.rend(); ++i) graph_.mutable_node()->DeleteSubrange(*i, 1);
  }

 private:
  /// Whether it could be.
  bool fold(const onnx::NodeProto& pad) {
    const Pads widths = widthsOf(pad);
    if (widths.empty()) return false;
    for (const auto& output : graph_.output())
      if (output.name() == pad.output(0)) return false;
    std::vector<onnx::NodeProto*> readers;
    for (auto& node : *graph_.mutable_node()) {
      if (std::count(node.input().begin(), node.input().end(), pad.output(0)) == 0) continue;
      if (!isPlainConvolution(node) || node.input(0) != pad.output(0)) return false;
      readers.push_back(&node);
    }
    for (onnx::NodeProto* node : readers) {
      node->set_input(0, pad.input(0));
      addWidths(*node, widths);
    }
    return !readers.empty();
  }

  /// Widths of zeros around the rows and columns of images; empty if it pads differently.
  Pads widthsOf(const onnx::NodeProto& pad) const {
    const auto* mode = attributeOf(pad, "mode");
    if ((mode != nullptr && mode->s() != "constant") || pad.input_size() < 2) return {};
    const auto widths = constants_.find(pad.input(1));
    if (widths == constants_.end() || !writesZeros(pad)) return {};
    const onnx::TensorProto& tensor = *widths->second;
    Pads all(tensor.int64_data().begin(), tensor.int64_data().end());
    if (tensor.has_raw_data() && tensor.raw_data().size() == 8 * sizeof(std::int64_t)) {
      all.resize(8);
      std::memcpy(all.data(), tensor.raw_data().data(), tensor.raw_data().size());
    }
    // Images, channels, rows, columns: before, then after.
    if (tensor.data_type() != onnx::TensorProto::INT64 || all.size() != 8 || all[0] != 0 || all[1] != 0 ||
        all[4] != 0 || all[5] != 0 || std::any_of(all.begin(), all.end(), [](auto w) { return w < 0; }))
      return {};
    return {all[2], all[3], all[6], all[7]};
  }

  bool writesZeros(const onnx::NodeProto& pad) const {
    if (pad.input_size() < 3 || pad.input(2).empty()) return true;
    const auto value = constants_.find(pad.input(2));
    if (value == constants_.end() || value->second->data_type() != onnx::TensorProto::FLOAT) return false;
    const onnx::TensorProto& tensor = *value->second;
    float number = tensor.float_data_size() == 1 ? tensor.float_data(0) : 1;
    if (tensor.raw_data().size() == sizeof number)
      std::memcpy(&number, tensor.raw_data().data(), sizeof number);
    return number == 0;
  }

  static bool isPlainConvolution(const onnx::NodeProto& node) {
    const auto* automatic = attributeOf(node, "auto_pad");
    const auto* pads = attributeOf(node, "pads");
    return node.op_type() == "Conv" && (automatic == nullptr || automatic->s() == "NOTSET") &&
           (pads == nullptr || pads->ints_size() == 4);
  }

  static void addWidths(onnx::NodeProto& node, const Pads& widths) {
    onnx::AttributeProto* pads = nullptr;
    for (auto& attribute : *node.mutable_attribute())
      if (attribute.name() == "pads") pads = &attribute;
    if (pads == nullptr) {
      pads = node.add_attribute();
      pads->set_name("pads");
      pads->set_type(onnx::AttributeProto::INTS);
      for (int k = 0; k < 4; ++k) pads->add_ints(0);
    }
    for (int k = 0; k < 4; ++k) pads->set_ints(k, pads->ints(k) + widths[static_cast<std::size_t>(k)]);
  }

  onnx::GraphProto& graph_;
  std::map<std::string, const onnx::TensorProto*> constants_;
};

}  // namespace

void foldPads(onnx::GraphProto& graph) {
  Folder(graph).run();
}

}  // namespace estancia::convert
