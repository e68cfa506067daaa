// SPDX-License-Identifier: Apache-2.0
#include "convert/quantization_plan.hpp"

#include <algorithm>
#include <set>

namespace estancia::convert {
namespace {

/// Kinds of node with integer kernels whose inputs are all images.
const std::set<std::string> imageKinds{"Add",     "AveragePool", "Clip",      "Concat",   "Flatten",
                                       "Mul",     "MaxPool",     "Relu",      "Reshape",  "GlobalAveragePool",
                                       "Sigmoid", "Squeeze",     "Transpose", "Unsqueeze"};
/// Operators whose outputs are numbers that they read.
const std::set<std::string> keepingKinds{"Concat",  "Flatten",   "MaxPool",  "Reshape",
                                         "Squeeze", "Transpose", "Unsqueeze"};
/// Operators whose other inputs are shapes, axes or limits.
const std::set<std::string> oneImageKinds{"Clip",    "Flatten", "MaxPool",   "Relu",
                                          "Reshape", "Squeeze", "Transpose", "Unsqueeze"};

float attributeOf(const onnx::NodeProto& node, const std::string& name, float otherwise) {
  for (const auto& attribute : node.attribute())
    if (attribute.name() == name)
      return attribute.type() == onnx::AttributeProto::INT ? static_cast<float>(attribute.i())
                                                           : attribute.f();
  return otherwise;
}

bool isPlainGemm(const onnx::NodeProto& node) {
  return attributeOf(node, "alpha", 1) == 1 && attributeOf(node, "beta", 1) == 1 &&
         attributeOf(node, "transA", 0) == 0;
}

}  // namespace

bool hasWeights(const onnx::NodeProto& node) {
  return node.op_type() == "Conv" || node.op_type() == "Gemm" || node.op_type() == "MatMul" ||
         node.op_type() == "ConvTranspose";
}

bool isClamp(const onnx::NodeProto& node) {
  return node.op_type() == "Relu" || node.op_type() == "Clip";
}

QuantizationPlan::QuantizationPlan(const onnx::GraphProto& graph) : graph_(graph) {
  for (const auto& constant : graph_.initializer()) constants_[constant.name()] = &constant;
  chooseNodes();
  chooseValues();
  joinScales();
}

const onnx::TensorProto* QuantizationPlan::findConstant(const std::string& value) const {
  const auto found = constants_.find(value);
  return found == constants_.end() ? nullptr : found->second;
}

bool QuantizationPlan::isQuantizable(const onnx::NodeProto& node) const {
  if (node.output_size() != 1 || node.input_size() == 0) return false;
  const auto isFloat = [&](int i) {
    const auto* constant = findConstant(node.input(i));
    return constant != nullptr && constant->data_type() == onnx::TensorProto::FLOAT &&
           constant->data_location() == onnx::TensorProto::DEFAULT;
  };
  if (node.op_type() == "Conv" || (node.op_type() == "Gemm" && isPlainGemm(node)))
    return findConstant(node.input(0)) == nullptr && node.input_size() >= 2 && isFloat(1) &&
           (node.input_size() < 3 || node.input(2).empty() || isFloat(2));
  if (!imageKinds.contains(node.op_type())) return false;
  const int images = oneImageKinds.contains(node.op_type()) ? 1 : node.input_size();
  for (int i = 0; i < images; ++i)
    if (findConstant(node.input(i)) != nullptr) return false;
  return true;
}

std::vector<int> QuantizationPlan::layersUpTo() const {
  std::map<std::string, int> layers;  // layers of values
  std::vector<int> upTo;
  for (const auto& node : graph_.node()) {
    int most = 0;
    for (const std::string& value : node.input())
      if (const auto found = layers.find(value); found != layers.end()) most = std::max(most, found->second);
    upTo.push_back(most + (hasWeights(node) ? 1 : 0));
    for (const std::string& value : node.output()) layers[value] = upTo.back();
  }
  return upTo;
}

void QuantizationPlan::chooseNodes() {
  const std::vector<int> layers = layersUpTo();
  // Backwards: a value is on the way to weights when a node with weights, or one on the way, reads it.
  std::set<std::string> onTheWay;
  quantized_.resize(static_cast<std::size_t>(graph_.node_size()));
  for (int i = graph_.node_size(); i-- > 0;) {
    const auto& node = graph_.node(i);
    const bool leads = std::any_of(node.output().begin(), node.output().end(),
                                   [&](const std::string& value) { return onTheWay.contains(value); });
    const auto n = static_cast<std::size_t>(i);
    quantized_[n] = leads && layers[n] > floatLayers && isQuantizable(node);
    if (leads || hasWeights(node)) onTheWay.insert(node.input().begin(), node.input().end());
  }
}

void QuantizationPlan::chooseValues() {
  std::set<std::string> wanted;
  std::map<std::string, int> readers;
  for (const auto& output : graph_.output()) ++readers[output.name()];
  for (int i = 0; i < graph_.node_size(); ++i) {
    const auto& node = graph_.node(i);
    for (const std::string& value : node.input()) ++readers[value];
    if (!isQuantized(i)) continue;
    wanted.insert(node.output(0));
    const int images = hasWeights(node) || oneImageKinds.contains(node.op_type()) ? 1 : node.input_size();
    for (int k = 0; k < images; ++k) wanted.insert(node.input(k));
  }
  // A value that only a ReLU reads is computed together with it.
  std::set<std::string> computed;
  for (int i = 0; i < graph_.node_size(); ++i) {
    const auto& node = graph_.node(i);
    if (isQuantized(i) && isClamp(node) && computed.contains(node.input(0)) && readers[node.input(0)] == 1)
      wanted.erase(node.input(0));
    if (isQuantized(i)) computed.insert(node.output(0));
  }
  const auto take = [&](const std::string& value) {
    if (wanted.erase(value) > 0) values_.push_back(value);
  };
  for (const auto& input : graph_.input())
    if (findConstant(input.name()) == nullptr) take(input.name());
  for (const auto& node : graph_.node())
    for (const std::string& value : node.output()) take(value);
  for (const std::string& value : values_) representative_[value] = value;
}

void QuantizationPlan::joinScales() {
  const auto join = [this](const std::string& one, const std::string& other) {
    if (!isQuantized(one) || !isQuantized(other)) return;
    const std::string from = scaleOf(other), to = scaleOf(one);
    for (auto& [value, representative] : representative_)
      if (representative == from) representative = to;
  };
  for (int i = 0; i < graph_.node_size(); ++i) {
    const auto& node = graph_.node(i);
    if (!isQuantized(i) || !keepingKinds.contains(node.op_type())) continue;
    const int images = node.op_type() == "Concat" ? node.input_size() : 1;
    for (int k = 0; k < images; ++k) join(node.output(0), node.input(k));
  }
}

}  // namespace estancia::convert
