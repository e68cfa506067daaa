// ONNX writer: network graph → serialized ONNX model.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "convert/tflite_graph.hpp"

namespace estancia::tflite {

/// The graph as a serialized ONNX model (IR 5, operator set 10) in float32; weights dequantized, images
/// 1×C×H×W.
///
/// Files often leave an activation to the range that an 8-bit output can hold: one that cannot be negative is
/// a ReLU, and a ReLU6 when it ends at 6. Both are written out. Saturation at the ends of other ranges is not
/// imitated: it changes probabilities by up to 0.03 and slows a network down by up to a fifth.
///
/// Throws Error when shapes disagree. `source` names the file in messages.
std::string toOnnx(const Graph& graph, const std::string& source);

}  // namespace estancia::tflite
