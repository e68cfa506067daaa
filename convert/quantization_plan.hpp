// Quantization plan: which nodes of a float network compute in 8 bits, and which values must be numbers of 8
// bits. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <onnx/onnx_pb.h>

#include <map>
#include <string>
#include <vector>

#include "convert/activation_ranges.hpp"

namespace estancia::convert {

/// Number of layers with weights from the image on that compute in real numbers. Measured by the default
/// network's labels of the demo's panoramas: their Hellinger distance to those of the float network is .066
/// with 0, .061 with 1, .038 with 2, .028 with 3, .026 with 4 and 5, and each one kept costs time
/// (docs/measured/benchmarks.md).
inline constexpr int floatLayers = 3;

/// Analysis of one network. It must outlive the plan.
class QuantizationPlan {
 public:
  /// All nodes of a kind that has integer kernels compute in 8 bits between the first floatLayers and the
  /// last layer with weights. The last (the logits, each head of a detector) and what comes after it stay
  /// float, since that costs next to nothing and errors of logits count most.
  explicit QuantizationPlan(const onnx::GraphProto& graph);

  bool isQuantized(int node) const { return quantized_[static_cast<std::size_t>(node)]; }
  /// The values of 8 bits in the order in which they are computed, the image first.
  const std::vector<std::string>& values() const { return values_; }
  bool isQuantized(const std::string& value) const { return representative_.contains(value); }
  /// Values of one scale share a representative: what a maximum, a reshaping or a concatenation reads and
  /// writes, which then move bytes instead of computing.
  const std::string& scaleOf(const std::string& value) const { return representative_.at(value); }
  const onnx::TensorProto* findConstant(const std::string& value) const;

 private:
  /// For each node the maximum number of layers with weights on a path from the image to it, itself included.
  std::vector<int> layersUpTo() const;
  void chooseNodes();
  void chooseValues();
  void joinScales();
  /// Whether it takes only computed values (convolutions: and constant weights).
  bool isQuantizable(const onnx::NodeProto& node) const;

  const onnx::GraphProto& graph_;
  std::map<std::string, const onnx::TensorProto*> constants_;
  std::vector<bool> quantized_;
  std::vector<std::string> values_;
  std::map<std::string, std::string> representative_;
};

/// Whether the node multiplies with weights that get scales of their own.
bool hasWeights(const onnx::NodeProto& node);

/// Whether the node limits what another has computed (ReLU, Clip), and computes together with that one.
bool isClamp(const onnx::NodeProto& node);

}  // namespace estancia::convert
