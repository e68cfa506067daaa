// SPDX-License-Identifier: Apache-2.0
#include "convert/tflite_to_onnx.hpp"

#include <fmt/format.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "estancia/core/error.hpp"

namespace estancia::tflite {
namespace {

using Shape = std::vector<std::int64_t>;

/// Values from layout `from` (outermost first) into the order `axes` of its dimensions.
std::vector<float> transposed(const std::vector<float>& values, const std::vector<int>& shape,
                              const std::array<std::size_t, 4>& axes) {
  std::array<std::size_t, 4> stride{};
  std::size_t step = 1;
  for (std::size_t d = 4; d-- > 0;) {
    stride[d] = step;
    step *= static_cast<std::size_t>(shape[d]);
  }
  const auto size = [&](std::size_t d) { return static_cast<std::size_t>(shape[axes[d]]); };
  std::vector<float> result;
  result.reserve(values.size());
  for (std::size_t a = 0; a < size(0); ++a)
    for (std::size_t b = 0; b < size(1); ++b)
      for (std::size_t c = 0; c < size(2); ++c)
        for (std::size_t d = 0; d < size(3); ++d)
          result.push_back(
              values[a * stride[axes[0]] + b * stride[axes[1]] + c * stride[axes[2]] + d * stride[axes[3]]]);
  return result;
}

/// Writes one graph. A tensor of four dimensions is N×H×W×C there and N×C×H×W here; all others stay as they
/// are.
class Writer {
 public:
  Writer(const Graph& graph, const std::string& source) : graph_(graph), source_(source) {}

  std::string write() {
    onnx::ModelProto model;
    model.set_ir_version(5);
    model.set_producer_name("estancia");  // OpenCV counts padding into averages for the producer "pytorch"
    model.add_opset_import()->set_version(
        10);  // the last in which Clip has attributes; OpenCV 4.6 reads no others
    out_ = model.mutable_graph();
    out_->set_name("network");

    names_.resize(graph_.tensors.size());
    if (tensor(graph_.input).constant) fail("takes a constant as its input");
    names_[index(graph_.input)] = "input";
    describe(out_->add_input(), "input", graph_.input);
    for (const auto& op : graph_.operators) {
      op_ = &op;
      writeOperator();
    }
    nameOutput();
    describe(out_->add_output(), names_[index(graph_.output)], graph_.output);

    std::string bytes;
    if (!model.SerializeToString(&bytes)) fail("is too large", ErrorCode::tooLarge);
    return bytes;
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::malformedFile) const {
    throw Error(code, fmt::format("{} {}", source_, what));
  }
  [[noreturn]] void failHere(const std::string& what, ErrorCode code = ErrorCode::malformedFile) const {
    fail(fmt::format("{} in {}", what, op_->where), code);
  }

  static std::size_t index(int position) { return static_cast<std::size_t>(position); }
  const Tensor& tensor(int position) const { return graph_.tensors[index(position)]; }
  const Tensor& input(std::size_t i = 0) const { return tensor(op_->inputs[i]); }
  const Tensor& output() const { return tensor(op_->output); }

  /// The tensor's shape as written here.
  static Shape shapeOf(const Tensor& t) {
    Shape shape(t.shape.begin(), t.shape.end());
    if (shape.size() == 4) shape = {shape[0], shape[3], shape[1], shape[2]};
    return shape;
  }

  /// The output keeps the name that it has in the file, unless that would be ambiguous here.
  void nameOutput() {
    std::string& last = names_[index(graph_.output)];
    const std::string& name = tensor(graph_.output).name;
    if (last == "input") fail("computes nothing");
    if (name.empty() || name == "input") return;
    for (const auto& node : out_->node())
      if (node.output(0) == name) return;
    for (auto& node : *out_->mutable_node()) {
      for (auto& input : *node.mutable_input())
        if (input == last) input = name;
      if (node.output(0) == last) node.set_output(0, name);
    }
    last = name;
  }

  void describe(onnx::ValueInfoProto* value, const std::string& name, int position) {
    value->set_name(name);
    auto* type = value->mutable_type()->mutable_tensor_type();
    type->set_elem_type(onnx::TensorProto::FLOAT);
    for (const auto size : shapeOf(tensor(position))) type->mutable_shape()->add_dim()->set_dim_value(size);
  }

  onnx::NodeProto* addNode(const char* type, std::vector<std::string> inputs, const std::string& output) {
    auto* node = out_->add_node();
    node->set_op_type(type);
    node->set_name(output);
    for (auto& name : inputs) node->add_input(std::move(name));
    node->add_output(output);
    return node;
  }

  static void setInt(onnx::NodeProto* node, const char* name, std::int64_t value) {
    auto* attribute = node->add_attribute();
    attribute->set_name(name);
    attribute->set_type(onnx::AttributeProto::INT);
    attribute->set_i(value);
  }

  static void setFloat(onnx::NodeProto* node, const char* name, float value) {
    auto* attribute = node->add_attribute();
    attribute->set_name(name);
    attribute->set_type(onnx::AttributeProto::FLOAT);
    attribute->set_f(value);
  }

  static void setInts(onnx::NodeProto* node, const char* name, const Shape& values) {
    auto* attribute = node->add_attribute();
    attribute->set_name(name);
    attribute->set_type(onnx::AttributeProto::INTS);
    for (const auto value : values) attribute->add_ints(value);
  }

  template <class Value>
  std::string addConstant(const std::string& name, int type, const Shape& shape,
                          const std::vector<Value>& values) {
    static_assert(std::endian::native == std::endian::little, "raw_data is little-endian");
    auto* constant = out_->add_initializer();
    constant->set_name(name);
    constant->set_data_type(type);
    for (const auto size : shape) constant->add_dims(size);
    constant->set_raw_data(values.data(), values.size() * sizeof(Value));
    return name;
  }
  std::string addFloats(const std::string& name, const Shape& shape, const std::vector<float>& values) {
    return addConstant(name, onnx::TensorProto::FLOAT, shape, values);
  }

  /// The name under which input i of the current operator is known.
  std::string inputName(std::size_t i = 0) const {
    if (input(i).constant) failHere(fmt::format("has the constant \"{}\" as an image", input(i).name));
    return names_[index(op_->inputs[i])];
  }

  /// A fresh name for what the current operator writes.
  std::string newName(const char* suffix = "") const { return fmt::format("t{}{}", op_->output, suffix); }
  void setOutput(const std::string& name) { names_[index(op_->output)] = name; }

  void requireShape(const Shape& expected) const {
    if (shapeOf(output()) != expected)
      failHere(fmt::format("has shape [{}] where [{}] is computed", fmt::join(shapeOf(output()), "×"),
                           fmt::join(expected, "×")));
  }

  Shape imageShape() const {
    if (input().shape.size() != 4) failHere("has an input that is no image");
    return shapeOf(input());
  }

  void writeOperator() {
    switch (op_->kind) {
      case Kind::conv:
        return writeConvolution(false);
      case Kind::depthwiseConv:
        return writeConvolution(true);
      case Kind::averagePool:
        return writePool("AveragePool");
      case Kind::maxPool:
        return writePool("MaxPool");
      case Kind::activation:
        requireShape(shapeOf(input()));
        return apply(op_->activation, inputName());
      case Kind::add:
        return writeArithmetic("Add");
      case Kind::multiply:
        return writeArithmetic("Mul");
      case Kind::concatenation:
        return writeConcatenation();
      case Kind::fullyConnected:
        return writeFullyConnected();
      case Kind::mean:
        return writeMean();
      case Kind::reshape:
        return writeReshape();
      case Kind::softmax:
        return writeSoftmax();
      case Kind::quantize:
      case Kind::dequantize:  // the real numbers stay the same
        requireShape(shapeOf(input()));
        return setOutput(inputName());
    }
  }

  /// The operator's activation, after the node that wrote newName("_raw"): the one that the file names, or
  /// the one that it leaves to the range of an 8-bit output.
  void writeActivation() {
    Activation activation = op_->activation;
    if (output().lowest() == 0 && activation != Activation::relu6) {
      const float step = output().highest() / 255;
      activation = std::abs(output().highest() - 6) < step ? Activation::relu6 : Activation::relu;
    }
    apply(activation, newName("_raw"));
  }

  /// Writes the current operator's output: `activation` of what is known as `from`.
  void apply(Activation activation, const std::string& from) {
    switch (activation) {
      case Activation::none:
        return setOutput(from);
      case Activation::relu:
        addNode("Relu", {from}, newName());
        break;
      case Activation::relu6:
        addClip(from, 0, 6);
        break;
      case Activation::reluN1To1:
        addClip(from, -1, 1);
        break;
      case Activation::sigmoid:
        addNode("Sigmoid", {from}, newName());
        break;
    }
    setOutput(newName());
  }

  void addClip(const std::string& from, float low, float high) {
    auto* node = addNode("Clip", {from}, newName());
    setFloat(node, "min", low);
    setFloat(node, "max", high);
  }

  void writeWindow(onnx::NodeProto* node, const Shape& in, std::int64_t channels, int filterY, int filterX) {
    const Window y = placeWindow(in[2], filterY, op_->strideY, op_->dilationY, op_->samePadding);
    const Window x = placeWindow(in[3], filterX, op_->strideX, op_->dilationX, op_->samePadding);
    if (y.outputs < 1 || x.outputs < 1) failHere("has a window larger than the image");
    requireShape({in[0], channels, y.outputs, x.outputs});
    setInts(node, "kernel_shape", {filterY, filterX});
    setInts(node, "strides", {op_->strideY, op_->strideX});
    setInts(node, "pads", {y.before, x.before, y.after, x.after});
  }

  void writeConvolution(bool depthwise) {
    const Shape in = imageShape();
    const Tensor& weights = input(1);
    if (weights.shape.size() != 4) failHere("has weights that are no filters");
    // stored as filters×H×W×C, or depthwise as 1×H×W×filters; ONNX wants filters×(C / groups)×H×W
    const std::int64_t filters = depthwise ? weights.shape[3] : weights.shape[0];
    const bool fits = depthwise ? weights.shape[0] == 1 && filters % in[1] == 0 : weights.shape[3] == in[1];
    if (!fits)
      failHere(fmt::format("has weights [{}] for {} channels", fmt::join(weights.shape, "×"), in[1]));
    const auto axes =
        depthwise ? std::array<std::size_t, 4>{3, 0, 1, 2} : std::array<std::size_t, 4>{0, 3, 1, 2};
    const std::string stored =
        addFloats(newName("_weights"), {filters, depthwise ? 1 : in[1], weights.shape[1], weights.shape[2]},
                  transposed(realValues(weights, source_), weights.shape, axes));
    auto* node = addNode("Conv", {inputName(), stored, writeBias(filters)}, newName("_raw"));
    setInt(node, "group", depthwise ? in[1] : 1);
    setInts(node, "dilations", {op_->dilationY, op_->dilationX});
    writeWindow(node, in, filters, weights.shape[1], weights.shape[2]);
    writeActivation();
  }

  std::string writeBias(std::int64_t size) {
    const auto count = static_cast<std::size_t>(size);
    if (op_->inputs.size() < 3 || op_->inputs[2] < 0)
      return addFloats(newName("_bias"), {size}, std::vector<float>(count));
    if (input(2).elements() != count) failHere("has a bias of another size");
    return addFloats(newName("_bias"), {size}, realValues(input(2), source_));
  }

  void writePool(const char* type) {
    const Shape in = imageShape();
    auto* node = addNode(type, {inputName()}, newName("_raw"));
    writeWindow(node, in, in[1], op_->filterY, op_->filterX);
    finishKeepingRange();
  }

  /// Pools and concatenations write what they read: only a fused activation can change it.
  void finishKeepingRange() {
    if (op_->activation == Activation::none)
      setOutput(newName("_raw"));
    else
      writeActivation();
  }

  /// Two tensors, or a tensor and a constant: one value, or one a channel (its last dimension in the file).
  void writeArithmetic(const char* type) {
    const Shape shape = shapeOf(input());
    requireShape(shape);
    std::string second;
    if (input(1).constant) {
      const auto count = static_cast<std::int64_t>(input(1).elements());
      if (input().shape.empty() || (count != 1 && count != input().shape.back()))
        failHere(fmt::format("has {} values for a tensor of [{}]", count, fmt::join(shape, "×")));
      Shape broadcast(shape.size(), 1);
      broadcast[shape.size() == 4 ? 1 : shape.size() - 1] = count;
      second = addFloats(newName("_values"), broadcast, realValues(input(1), source_));
    } else {
      if (shape != shapeOf(input(1))) failHere("joins tensors of different shapes");
      second = inputName(1);
    }
    addNode(type, {inputName(), second}, newName("_raw"));
    writeActivation();
  }

  void writeConcatenation() {
    Shape joined = shapeOf(input());
    if (joined.size() != output().shape.size()) failHere("joins tensors of different shapes");
    // N×H×W×C → N×C×H×W moves the axes, too
    const std::size_t axis =
        joined.size() == 4 ? std::array<std::size_t, 4>{0, 2, 3, 1}[index(op_->axis)] : index(op_->axis);
    std::vector<std::string> names;
    joined[axis] = 0;
    for (std::size_t i = 0; i < op_->inputs.size(); ++i) {
      Shape part = shapeOf(input(i));
      if (part.size() != joined.size()) failHere("joins tensors of different shapes");
      joined[axis] += part[axis];
      part[axis] = joined[axis];
      if (part != joined) failHere("joins tensors of different shapes");
      names.push_back(inputName(i));
    }
    requireShape(joined);
    setInt(addNode("Concat", names, newName("_raw")), "axis", static_cast<std::int64_t>(axis));
    finishKeepingRange();
  }

  /// The input as one row of numbers in the file's own order.
  std::string writeFlatInput() {
    const auto size = static_cast<std::int64_t>(input().elements());
    if (input().shape.size() == 2 && input().shape[0] == 1) return inputName();
    addNode("Reshape", {inputInFileOrder(), addShape("_flat_shape", {1, size})}, newName("_flat"));
    return newName("_flat");
  }

  void writeFullyConnected() {
    const Tensor& weights = input(1);
    if (weights.shape.size() != 2 || static_cast<std::size_t>(weights.shape[1]) != input().elements())
      failHere(
          fmt::format("has weights [{}] for {} numbers", fmt::join(weights.shape, "×"), input().elements()));
    requireShape({1, weights.shape[0]});
    const std::string flat = writeFlatInput();
    const std::string stored =
        addFloats(newName("_weights"), {weights.shape[0], weights.shape[1]}, realValues(weights, source_));
    setInt(addNode("Gemm", {flat, stored, writeBias(weights.shape[0])}, newName("_raw")), "transB", 1);
    writeActivation();
  }

  void writeMean() {
    const Shape in = imageShape();
    auto axes = integerValues(input(1), source_);
    for (auto& axis : axes) axis += axis < 0 ? 4 : 0;
    std::sort(axes.begin(), axes.end());
    if (axes != Shape{1, 2})
      failHere("takes a mean over other axes than height and width", ErrorCode::unsupportedFile);
    requireShape(op_->keepDimensions ? Shape{in[0], in[1], 1, 1} : Shape{in[0], in[1]});
    addNode("GlobalAveragePool", {inputName()}, newName("_raw"));
    if (op_->keepDimensions) return setOutput(newName("_raw"));
    addNode("Reshape", {newName("_raw"), addShape("_shape", {in[0], in[1]})}, newName());
    setOutput(newName());
  }

  std::string addShape(const char* suffix, const Shape& shape) {
    return addConstant(newName(suffix), onnx::TensorProto::INT64, {static_cast<std::int64_t>(shape.size())},
                       shape);
  }

  /// Elements in the order of the file: an image's channels last, unless it is a single pixel.
  std::string inputInFileOrder() {
    const auto& shape = input().shape;
    if (shape.size() != 4 || shape[3] == 1 || (shape[1] == 1 && shape[2] == 1)) return inputName();
    setInts(addNode("Transpose", {inputName()}, newName("_nhwc")), "perm", {0, 2, 3, 1});
    return newName("_nhwc");
  }

  void writeReshape() {
    if (input().elements() != output().elements()) failHere("changes the number of elements");
    const std::string from = inputInFileOrder();
    const Shape fileShape(output().shape.begin(), output().shape.end());
    const bool image = fileShape.size() == 4 && fileShape[3] != 1 && (fileShape[1] != 1 || fileShape[2] != 1);
    if (!image) {
      addNode("Reshape", {from, addShape("_shape", shapeOf(output()))}, newName());
    } else {
      addNode("Reshape", {from, addShape("_shape", fileShape)}, newName("_nhwc_out"));
      setInts(addNode("Transpose", {newName("_nhwc_out")}, newName()), "perm", {0, 3, 1, 2});
    }
    setOutput(newName());
  }

  void writeSoftmax() {
    requireShape(shapeOf(input()));
    const Shape in = shapeOf(input());
    const std::size_t last = in.size() == 4 ? 1 : in.size() - 1;  // TFLite takes it over the file's last axis
    if (in.empty() || input().elements() != static_cast<std::size_t>(in[last]))
      failHere("takes a softmax of more than one row", ErrorCode::unsupportedFile);
    setInt(addNode("Softmax", {inputName()}, newName()), "axis", static_cast<std::int64_t>(last));
    setOutput(newName());
  }

  const Graph& graph_;
  const std::string& source_;
  onnx::GraphProto* out_ = nullptr;
  const Operator* op_ = nullptr;
  std::vector<std::string> names_;  ///< name of each computed tensor in the ONNX graph
};

}  // namespace

std::string toOnnx(const Graph& graph, const std::string& source) {
  return Writer(graph, source).write();
}

}  // namespace estancia::tflite
