// A TensorFlow Lite network as an ONNX model, so that one engine runs every network.
#pragma once

#include <string>

#include "estancia/label/tflite_reader.hpp"

namespace estancia::tflite {

/// The graph as a serialised ONNX model (IR 5, operator set 10) in float32: weights dequantised, images
/// 1×C×H×W. An 8-bit tensor can hold only a range of reals, and networks were trained to count on it: what a
/// convolution, an addition or a matrix product writes is clamped to that range (with zero point 0 that is
/// the ReLU which the file leaves out). Throws Error when shapes disagree. `source` names the file in
/// messages.
std::string toOnnx(const Graph& graph, const std::string& source);

}  // namespace estancia::tflite
