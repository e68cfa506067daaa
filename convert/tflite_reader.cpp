// SPDX-License-Identifier: Apache-2.0
#include "convert/tflite_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>

#include "estancia/core/error.hpp"
#include "tflite_generated.h"

namespace estancia::tflite {
namespace {

constexpr std::size_t maxElements = std::size_t{1} << 28;
constexpr std::size_t maxRank = 8;

std::size_t bytesPerElement(ElementType type) {
  switch (type) {
    case ElementType::float32:
    case ElementType::int32:
      return 4;
    case ElementType::float16:
      return 2;
    case ElementType::int64:
      return 8;
    case ElementType::uint8:
    case ElementType::int8:
      return 1;
    case ElementType::other:
      break;
  }
  return 0;
}

ElementType elementType(format::ElementType type) {
  switch (type) {
    case format::ElementType::FLOAT32:
      return ElementType::float32;
    case format::ElementType::FLOAT16:
      return ElementType::float16;
    case format::ElementType::INT32:
      return ElementType::int32;
    case format::ElementType::UINT8:
      return ElementType::uint8;
    case format::ElementType::INT64:
      return ElementType::int64;
    case format::ElementType::INT8:
      return ElementType::int8;
  }
  return ElementType::other;
}

/// Codes of the format: what can be read, and names for the message about what cannot.
struct KnownCode {
  int code;
  const char* name;
  std::optional<Kind> kind;
};
constexpr auto no = std::nullopt;
const KnownCode knownCodes[] = {{0, "ADD", Kind::add},
                                {1, "AVERAGE_POOL_2D", Kind::averagePool},
                                {2, "CONCATENATION", Kind::concatenation},
                                {3, "CONV_2D", Kind::conv},
                                {4, "DEPTHWISE_CONV_2D", Kind::depthwiseConv},
                                {5, "DEPTH_TO_SPACE", no},
                                {6, "DEQUANTIZE", Kind::dequantize},
                                {9, "FULLY_CONNECTED", Kind::fullyConnected},
                                {11, "L2_NORMALIZATION", no},
                                {14, "LOGISTIC", no},
                                {17, "MAX_POOL_2D", Kind::maxPool},
                                {18, "MUL", no},
                                {19, "RELU", no},
                                {21, "RELU6", no},
                                {22, "RESHAPE", Kind::reshape},
                                {23, "RESIZE_BILINEAR", no},
                                {25, "SOFTMAX", Kind::softmax},
                                {28, "TANH", no},
                                {34, "PAD", no},
                                {36, "GATHER", no},
                                {39, "TRANSPOSE", no},
                                {40, "MEAN", Kind::mean},
                                {41, "SUB", no},
                                {42, "DIV", no},
                                {43, "SQUEEZE", no},
                                {45, "STRIDED_SLICE", no},
                                {49, "SPLIT", no},
                                {54, "PRELU", no},
                                {67, "TRANSPOSE_CONV", no},
                                {74, "SUM", no},
                                {83, "PACK", no},
                                {97, "RESIZE_NEAREST_NEIGHBOR", no},
                                {98, "LEAKY_RELU", no},
                                {114, "QUANTIZE", Kind::quantize},
                                {117, "HARD_SWISH", no},
                                {126, "BATCH_MATMUL", no},
                                {150, "GELU", no}};

/// Walks the flatbuffer. The verifier has shown that every offset stays inside the file; here it is shown
/// that every number in it makes sense.
class Reader {
 public:
  Reader(std::span<const std::uint8_t> file, const std::string& source) : file_(file), source_(source) {}

  Graph read() {
    flatbuffers::Verifier verifier(file_.data(), file_.size());
    if (file_.size() < 8 || !format::ModelBufferHasIdentifier(file_.data()))
      fail("is no TensorFlow Lite file (its identifier TFL3 is missing)");
    if (!format::VerifyModelBuffer(verifier)) fail("is damaged or cut short; fetch it again");
    model_ = format::GetModel(file_.data());
    if (model_->subgraphs() == nullptr || model_->subgraphs()->size() == 0) fail("holds no graph");
    const format::SubGraph* subgraph = model_->subgraphs()->Get(0);
    if (subgraph == nullptr || subgraph->tensors() == nullptr || subgraph->operators() == nullptr)
      fail("holds an empty graph");

    Graph graph;
    for (const auto* tensor : *subgraph->tensors()) graph.tensors.push_back(readTensor(tensor));
    graph.input = single(subgraph->inputs(), graph, "input");
    graph.output = single(subgraph->outputs(), graph, "output");
    for (const auto* op : *subgraph->operators())
      graph.operators.push_back(readOperator(op, graph, graph.operators.size()));
    requireOrder(graph);
    return graph;
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::malformedFile) const {
    throw Error(code, fmt::format("{} {}", source_, what));
  }

  Tensor readTensor(const format::Tensor* stored) const {
    if (stored == nullptr) fail("lacks a tensor; fetch it again");
    Tensor tensor;
    tensor.name = stored->name() != nullptr ? stored->name()->str() : "";
    tensor.type = elementType(stored->type());
    if (stored->shape() != nullptr) {
      if (stored->shape()->size() > maxRank)
        fail("has a tensor of too many dimensions: " + quoted(tensor.name));
      tensor.shape.assign(stored->shape()->begin(), stored->shape()->end());
    }
    std::size_t elements = 1;
    for (const int size : tensor.shape) {
      if (size < 1 || static_cast<std::size_t>(size) > maxElements / elements)
        fail(fmt::format("has a tensor of impossible shape: {} [{}]", quoted(tensor.name),
                         fmt::join(tensor.shape, "×")));
      elements *= static_cast<std::size_t>(size);
    }
    readQuantization(stored->quantization(), tensor);
    readConstant(stored->buffer(), elements, tensor);
    return tensor;
  }

  void readQuantization(const format::Quantization* stored, Tensor& tensor) const {
    if (stored == nullptr || stored->scale() == nullptr || stored->scale()->size() == 0) return;
    tensor.scale.assign(stored->scale()->begin(), stored->scale()->end());
    tensor.zeroPoint.assign(tensor.scale.size(), 0);
    if (const auto* zero = stored->zero_point(); zero != nullptr && zero->size() > 0) {
      if (zero->size() != tensor.scale.size())
        fail("has scales without their zero points: " + quoted(tensor.name));
      // The verifier asks that vectors lie at four bytes, and these numbers have eight.
      std::memcpy(tensor.zeroPoint.data(), zero->Data(), zero->size() * sizeof(std::int64_t));
    }
    tensor.axis = stored->axis();
    for (const float scale : tensor.scale)
      if (!std::isfinite(scale) || scale < 0)
        fail("has a scale that is no positive number: " + quoted(tensor.name));
    for (const auto zero : tensor.zeroPoint)
      if (std::abs(zero) > (1 << 24)) fail("has an impossible zero point: " + quoted(tensor.name));
    if (tensor.scale.size() > 1 &&
        (tensor.axis < 0 || tensor.axis >= static_cast<int>(tensor.shape.size()) ||
         static_cast<std::size_t>(tensor.shape[static_cast<std::size_t>(tensor.axis)]) !=
             tensor.scale.size()))
      fail("has scales that do not fit the shape of " + quoted(tensor.name));
  }

  void readConstant(std::uint32_t buffer, std::size_t elements, Tensor& tensor) const {
    if (buffer == 0) return;
    if (model_->buffers() == nullptr || buffer >= model_->buffers()->size())
      fail("has a tensor without its buffer: " + quoted(tensor.name));
    const format::Buffer* stored = model_->buffers()->Get(buffer);
    if (stored == nullptr || stored->data() == nullptr || stored->data()->size() == 0) return;
    const std::size_t expected = elements * bytesPerElement(tensor.type);
    if (expected == 0) fail(fmt::format("has a constant of an unsupported type: {}", quoted(tensor.name)));
    if (stored->data()->size() != expected)
      fail(fmt::format("has {} bytes where {} of shape [{}] needs {}", stored->data()->size(),
                       quoted(tensor.name), fmt::join(tensor.shape, "×"), expected));
    tensor.constant = true;
    tensor.bytes = {stored->data()->data(), stored->data()->size()};
  }

  int single(const flatbuffers::Vector<std::int32_t>* list, const Graph& graph, const char* what) const {
    if (list == nullptr || list->size() != 1)
      fail(fmt::format("has {} {}s; only networks of one image {} can label",
                       list == nullptr ? 0 : list->size(), what, what));
    return checkedIndex(list->Get(0), graph, what);
  }

  int checkedIndex(int index, const Graph& graph, const std::string& where) const {
    if (index < 0 || static_cast<std::size_t>(index) >= graph.tensors.size())
      fail(fmt::format("names tensor {} of {} in {}", index, graph.tensors.size(), where));
    return index;
  }

  Operator readOperator(const format::Operator* stored, const Graph& graph, std::size_t position) const {
    if (stored == nullptr || model_->operator_codes() == nullptr ||
        stored->code_index() >= model_->operator_codes()->size() ||
        model_->operator_codes()->Get(stored->code_index()) == nullptr)
      fail(fmt::format("has no code for operator {}", position));
    const format::OperatorCode* code = model_->operator_codes()->Get(stored->code_index());
    Operator op;
    op.kind = kindOf(code, position);
    op.where = fmt::format("{} (operator {})", nameOf(code), position);

    if (stored->inputs() == nullptr || stored->inputs()->size() == 0 || stored->inputs()->size() > 64)
      fail("has no inputs for " + op.where);
    for (const int index : *stored->inputs())
      op.inputs.push_back(index == -1 ? -1 : checkedIndex(index, graph, op.where));
    if (stored->outputs() == nullptr || stored->outputs()->size() != 1)
      fail("has no single output for " + op.where);
    op.output = checkedIndex(stored->outputs()->Get(0), graph, op.where);
    readOptions(stored, graph, op);
    return op;
  }

  static int codeOf(const format::OperatorCode* code) {
    return std::max<int>(code->code(), code->code_byte());
  }

  static std::string nameOf(const format::OperatorCode* code) {
    for (const auto& known : knownCodes)
      if (known.code == codeOf(code)) return known.name;
    if (code->custom_name() != nullptr) return "custom operator " + quoted(code->custom_name()->str());
    return fmt::format("number {}", codeOf(code));
  }

  Kind kindOf(const format::OperatorCode* code, std::size_t position) const {
    for (const auto& known : knownCodes)
      if (known.code == codeOf(code) && known.kind) return *known.kind;
    std::string supported;
    for (const auto& known : knownCodes)
      if (known.kind) supported += (supported.empty() ? "" : ", ") + std::string(known.name);
    fail(fmt::format("needs the operator {} (operator {}), which is not supported; supported are {}; "
                     "convert the network to ONNX instead",
                     nameOf(code), position, supported),
         ErrorCode::unsupportedFile);
  }

  void requireInputs(const Operator& op, std::size_t min, std::size_t max) const {
    if (op.inputs.size() < min || op.inputs.size() > max)
      fail(fmt::format("gives {} inputs to {}", op.inputs.size(), op.where));
    for (std::size_t i = 0; i < min; ++i)
      if (op.inputs[i] < 0) fail("leaves out an input of " + op.where);
  }

  template <class Options>
  const Options* require(const Options* options, const Operator& op) const {
    if (options == nullptr) fail("has no options for " + op.where);
    return options;
  }

  template <class Options>
  void readWindow(const Options* options, Operator& op) const {
    require(options, op);
    if (options->padding() != format::Padding::SAME && options->padding() != format::Padding::VALID)
      fail("has an unknown padding in " + op.where);
    op.samePadding = options->padding() == format::Padding::SAME;
    op.strideX = positive(options->stride_w(), op, "stride");
    op.strideY = positive(options->stride_h(), op, "stride");
    op.activation = activationOf(options->activation(), op);
  }

  template <class Options>
  void readConvolution(const Options* options, Operator& op) const {
    requireInputs(op, 2, 3);
    readWindow(options, op);
    op.dilationX = positive(options->dilation_w(), op, "dilation");
    op.dilationY = positive(options->dilation_h(), op, "dilation");
  }

  void readPool(const format::Pool2D* options, Operator& op) const {
    requireInputs(op, 1, 1);
    readWindow(options, op);
    op.filterX = positive(options->filter_w(), op, "filter");
    op.filterY = positive(options->filter_h(), op, "filter");
  }

  void readFullyConnected(const format::FullyConnected* options, Operator& op) const {
    requireInputs(op, 2, 3);
    if (require(options, op)->weights_format() != 0)
      fail("has shuffled weights in " + op.where, ErrorCode::unsupportedFile);
    op.activation = activationOf(options->activation(), op);
  }

  void readConcatenation(const format::Concatenation* options, const Graph& graph, Operator& op) const {
    requireInputs(op, op.inputs.size(), op.inputs.size());
    require(options, op);
    const int rank = static_cast<int>(graph.tensors[static_cast<std::size_t>(op.output)].shape.size());
    op.axis = options->axis() < 0 ? options->axis() + rank : options->axis();
    if (op.axis < 0 || op.axis >= rank) fail(fmt::format("has axis {} in {}", options->axis(), op.where));
    op.activation = activationOf(options->activation(), op);
  }

  void readOptions(const format::Operator* stored, const Graph& graph, Operator& op) const {
    switch (op.kind) {
      case Kind::conv:
        return readConvolution(stored->options_as_Conv2D(), op);
      case Kind::depthwiseConv:
        return readConvolution(stored->options_as_DepthwiseConv2D(), op);
      case Kind::averagePool:
      case Kind::maxPool:
        return readPool(stored->options_as_Pool2D(), op);
      case Kind::fullyConnected:
        return readFullyConnected(stored->options_as_FullyConnected(), op);
      case Kind::concatenation:
        return readConcatenation(stored->options_as_Concatenation(), graph, op);
      case Kind::add:
      case Kind::multiply:
        requireInputs(op, 2, 2);
        if (const auto* options = stored->options_as_Add())
          op.activation = activationOf(options->activation(), op);
        return;
      case Kind::softmax:
        requireInputs(op, 1, 1);
        if (require(stored->options_as_Softmax(), op)->beta() != 1.0F)
          fail("has a temperature other than 1 in " + op.where, ErrorCode::unsupportedFile);
        return;
      case Kind::mean:
        requireInputs(op, 2, 2);
        op.keepDimensions = require(stored->options_as_Reducer(), op)->keep_dims();
        return;
      case Kind::reshape:
        return requireInputs(op, 1, 2);
      case Kind::quantize:
      case Kind::dequantize:
      case Kind::activation:
        return requireInputs(op, 1, 1);
    }
  }

  int positive(int value, const Operator& op, const char* what) const {
    if (value < 1 || value > 1024) fail(fmt::format("has a {} of {} in {}", what, value, op.where));
    return value;
  }

  Activation activationOf(format::Activation activation, const Operator& op) const {
    switch (activation) {
      case format::Activation::NONE:
        return Activation::none;
      case format::Activation::RELU:
        return Activation::relu;
      case format::Activation::RELU_N1_TO_1:
        return Activation::reluN1To1;
      case format::Activation::RELU6:
        return Activation::relu6;
      case format::Activation::TANH:
      case format::Activation::SIGN_BIT:
        break;
    }
    fail(fmt::format("needs activation {} fused into {}, which is not supported",
                     static_cast<int>(activation), op.where));
  }

  /// Every computed tensor is written once and before it is read.
  void requireOrder(const Graph& graph) const {
    std::set<int> known{graph.input};
    for (const auto& op : graph.operators) {
      for (const int input : op.inputs)
        if (input >= 0 && !known.contains(input) && !graph.tensors[static_cast<std::size_t>(input)].constant)
          fail(fmt::format("uses {} before it is computed in {}",
                           quoted(graph.tensors[static_cast<std::size_t>(input)].name), op.where));
      if (graph.tensors[static_cast<std::size_t>(op.output)].constant || !known.insert(op.output).second)
        fail("writes a tensor twice in " + op.where);
    }
    if (!known.contains(graph.output))
      fail("never computes its output " + quoted(graph.tensors[static_cast<std::size_t>(graph.output)].name));
  }

  static std::string quoted(const std::string& name) { return '"' + name.substr(0, 100) + '"'; }

  std::span<const std::uint8_t> file_;
  const std::string& source_;
  const format::Model* model_ = nullptr;
};

}  // namespace

Graph readGraph(std::span<const std::uint8_t> file, const std::string& source) {
  return Reader(file, source).read();
}

}  // namespace estancia::tflite
