// Network graph: tensors and operators of a TensorFlow Lite or TensorFlow.js network.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace estancia::tflite {

enum class ElementType { float32, float16, int32, uint8, int64, int8, other };

/// A tensor; images are N×H×W×C. Constants point into the file's bytes, which must outlive the graph.
struct Tensor {
  std::string name;
  std::vector<int> shape;  ///< every dimension ≥ 1, at most 2²⁸ elements in all
  ElementType type = ElementType::other;
  std::vector<float> scale;  ///< real = scale · (stored − zeroPoint); one a tensor, or one an index of `axis`
  std::vector<std::int64_t> zeroPoint;  ///< one a scale
  int axis = 0;
  bool constant = false;
  std::span<const std::uint8_t> bytes;  ///< data of a constant; exactly as many as its shape and type need

  std::size_t elements() const;
  /// The real numbers that an 8-bit tensor can hold; without bounds for every other type.
  float lowest() const;
  float highest() const;
};

/// `add` and `multiply` take two tensors of one shape, or a tensor and a constant of one value, or one a
/// channel (index of the last dimension).
enum class Kind {
  activation,
  add,
  averagePool,
  concatenation,
  conv,
  depthwiseConv,
  dequantize,
  fullyConnected,
  maxPool,
  mean,
  multiply,
  quantize,
  reshape,
  softmax
};
enum class Activation { none, relu, reluN1To1, relu6, sigmoid };

/// One operator, with the options that its kind has.
struct Operator {
  Kind kind = Kind::add;
  std::string where;        ///< for messages: "CONV_2D (operator 12)"
  std::vector<int> inputs;  ///< positions in Graph::tensors; -1 = left out
  int output = 0;
  Activation activation = Activation::none;
  bool samePadding = false;  ///< SAME, else VALID
  int strideX = 1, strideY = 1;
  int dilationX = 1, dilationY = 1;
  int filterX = 1, filterY = 1;  ///< size of a pool
  int axis = 0;                  ///< axis of a concatenation, ≥ 0
  bool keepDimensions = false;   ///< option of a mean
};

struct Graph {
  std::vector<Tensor> tensors;
  std::vector<Operator> operators;  ///< in an order in which every input is known before it is used
  int input = 0, output = 0;        ///< positions in `tensors`
};

/// Where a window of `filter` pixels, `dilation` apart, lands along one side of an image.
struct Window {
  std::int64_t before = 0, after = 0;  ///< padding
  std::int64_t outputs = 0;            ///< positions; 0 when the window does not fit
};

/// TensorFlow's SAME gives ceil(size / stride) positions and puts the odd pixel of padding behind.
Window placeWindow(std::int64_t size, int filter, int stride, int dilation, bool samePadding);

/// A 16-bit floating point number (IEEE 754 binary16) by its bits. Exact.
float halfToFloat(std::uint16_t bits);

/// The real values of a constant of any supported type. Throws Error when it is none.
std::vector<float> realValues(const Tensor& tensor, const std::string& source);

/// The values of an integer constant (a shape, a list of axes). Throws Error when it is none.
std::vector<std::int64_t> integerValues(const Tensor& tensor, const std::string& source);

}  // namespace estancia::tflite
