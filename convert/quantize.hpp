// Network quantization: a float ONNX network and the ranges of its values → a network that computes in 8
// bits. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "convert/activation_ranges.hpp"

namespace estancia::convert {

/// The values of a serialized float network whose ranges quantizedOnnx() needs, in the order in which they
/// are computed, the image first. Throws Error when it is no ONNX network, or has no layers to quantize (also
/// one that computes in 8 bits already). `source` names the network in messages.
std::vector<std::string> valuesToQuantize(const std::string& onnx, const std::string& source);

/// The network with pairs of QuantizeLinear and DequantizeLinear around what is to compute in 8 bits, which
/// ONNX Runtime replaces by integer kernels (Jacob et al. 2018, "Quantization and Training of Neural Networks
/// for Efficient Integer-Arithmetic-Only Inference"): uint8 activations of one scale and zero point a value,
/// int8 weights of a scale a filter, int32 biases. Operator set 13 at least. The last layers with weights
/// stay float (QuantizationPlan). Equal input gives equal bytes on every machine. Throws Error as above, and
/// (mismatch) when `ranges` lacks a value.
std::string quantizedOnnx(const std::string& onnx, const ActivationRanges& ranges, const std::string& source);

/// Scale of one filter's weights: among those that bring them into -127 … 127 the one whose rounding has the
/// least squared error. `step`: see weightStep(); 0 = none. ≥ the smallest normal number.
float weightScale(const std::vector<float>& weights, float step);

/// The step of which all weights are multiples, as those of networks that come out of 8-bit files are:
/// rounding to it loses nothing. 0 when there is none.
float weightStep(const std::vector<float>& weights);

}  // namespace estancia::convert
