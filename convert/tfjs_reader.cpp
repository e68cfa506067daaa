// SPDX-License-Identifier: Apache-2.0
#include "convert/tfjs_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "convert/tfjs_json.hpp"
#include "convert/tfjs_nodes.hpp"
#include "convert/tfjs_weights.hpp"
#include "estancia/core/error.hpp"

namespace estancia::tfjs {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;
using tflite::Activation;
using tflite::Kind;
using tflite::Operator;
using Integers = std::vector<std::int64_t>;
using Reals = std::vector<float>;
using Shape = std::vector<int>;

constexpr std::int64_t largestSide = 4096;  ///< side of an image [pixels], as in model.toml

/// Result of a node: an image (or other tensor) that the network computes, a stored weight, or integers that
/// follow from shapes alone.
struct Value {
  int tensor = -1;
  std::string weight;
  std::optional<Integers> integers;
};

class Reader {
 public:
  Reader(const Json& model, const fs::path& folder, const Section& section)
      : section_(section), weights_(model.at("weightsManifest"), folder), nodes_(nodesOf(model)) {}

  Network read() {
    const std::string input = section_.input.empty() ? nodes_.onlyPlaceholder() : section_.input;
    const std::string output = section_.output.empty() ? nodes_.onlyEnd() : section_.output;
    node_ = &nodes_.at(input);
    graph().input = addTensor(image());
    values_[node_].tensor = graph().input;
    for (const Node* node : nodes_.inOrder(input, output, requireKnown)) {
      node_ = node;
      values_[node] = (this->*converters().at(node->op))();
    }
    graph().output = values_.at(&nodes_.at(output)).tensor;
    if (graph().output < 0 || graph().output == graph().input)
      throw Error(ErrorCode::invalidInput,
                  fmt::format("computes nothing from an image in {}", inQuotes(output)));
    return std::move(network_);
  }

 private:
  static const Json& nodesOf(const Json& model) {
    const Json& topology = model.at("modelTopology");
    if (topology.contains("node")) return topology.at("node");
    throw Error(ErrorCode::unsupportedFile,
                "holds layers, not a graph; convert it with tensorflowjs_converter "
                "--output_format=tfjs_graph_model");
  }

  tflite::Graph& graph() { return network_.graph; }
  const Shape& shapeOf(int tensor) const {
    return network_.graph.tensors[static_cast<std::size_t>(tensor)].shape;
  }

  /// The shape of the image. A placeholder may declare the one it accepts; -1 is any size.
  Shape image() const {
    const Integers takes = node_->shape();
    const bool own = section_.width == 0 && takes.size() == 4 && takes[1] > 0 && takes[2] > 0 &&
                     takes[1] <= largestSide && takes[2] <= largestSide;
    if (section_.width == 0 && !own)
      throw Error(ErrorCode::invalidInput,
                  "does not say how large its image is; convert it as a model, whose `input` does");
    Shape ours{1, own ? static_cast<int>(takes[1]) : section_.height,
               own ? static_cast<int>(takes[2]) : section_.width, 3};
    const auto fits = [](std::int64_t theirs, std::int64_t size) { return theirs == -1 || theirs == size; };
    if (!takes.empty() && !std::equal(takes.begin(), takes.end(), ours.begin(), ours.end(), fits))
      throw Error(ErrorCode::mismatch,
                  fmt::format("takes an input of [{}] where model.toml makes [{}]; correct `input`",
                              fmt::join(takes, "×"), fmt::join(ours, "×")));
    return ours;
  }

  // ---- inputs of the current node

  const Value& input(std::size_t i) const {
    if (i >= node_->inputs.size()) node_->fail(fmt::format("lacks its input {}", i));
    return values_.at(&nodes_.at(node_->inputs[i]));
  }
  int tensorInput(std::size_t i) const {
    if (input(i).tensor < 0) node_->fail(fmt::format("has no image as its input {}", i));
    return input(i).tensor;
  }
  Shape imageShape(std::size_t i) const {
    const Shape& shape = shapeOf(tensorInput(i));
    if (shape.size() != 4) node_->fail("has an input that is no image");
    return shape;
  }
  const std::string& weightInput(std::size_t i) const {
    if (input(i).weight.empty()) node_->fail(fmt::format("has no stored weight as its input {}", i));
    return input(i).weight;
  }
  Integers integersInput(std::size_t i) const {
    return input(i).integers ? *input(i).integers : weights_.integers(weightInput(i));
  }

  // ---- writing

  int addTensor(Shape shape) {
    std::size_t elements = 1;
    for (const int size : shape) {
      if (size < 1 || static_cast<std::size_t>(size) > maxElements / elements)
        node_->fail(fmt::format("makes the impossible shape [{}]", fmt::join(shape, "×")));
      elements *= static_cast<std::size_t>(size);
    }
    tflite::Tensor tensor;
    tensor.name = node_->name;
    tensor.shape = std::move(shape);
    tensor.type = tflite::ElementType::float32;
    graph().tensors.push_back(std::move(tensor));
    return static_cast<int>(graph().tensors.size()) - 1;
  }

  int addConstant(Shape shape, Reals values) {
    // A weight that a thousand nodes read would be written a thousand times.
    constants_ += values.size();
    if (constants_ > maxElements) node_->fail("has too many weights");
    const int position = addTensor(std::move(shape));
    network_.weights.push_back(std::move(values));
    const Reals& kept = network_.weights.back();
    auto& tensor = graph().tensors[static_cast<std::size_t>(position)];
    tensor.constant = true;
    tensor.bytes = {reinterpret_cast<const std::uint8_t*>(kept.data()), kept.size() * sizeof(float)};
    return position;
  }

  Operator newOperator(Kind kind, std::vector<int> inputs) const {
    Operator op;
    op.kind = kind;
    op.where = node_->where();
    op.inputs = std::move(inputs);
    return op;
  }

  Value add(Operator op, Shape shape) {
    op.output = addTensor(std::move(shape));
    graph().operators.push_back(std::move(op));
    return {graph().operators.back().output, "", {}};
  }

  /// `tensor` with a constant added or multiplied: one value, or one a channel.
  Value perChannel(Kind kind, int tensor, Reals values) {
    const Shape shape = shapeOf(tensor);
    if (shape.empty() || (values.size() != 1 && values.size() != static_cast<std::size_t>(shape.back())))
      node_->fail(fmt::format("has {} values for a tensor of [{}]", values.size(), fmt::join(shape, "×")));
    const Shape size{static_cast<int>(values.size())};
    const int constant = addConstant(size, std::move(values));
    return add(newOperator(kind, {tensor, constant}), shape);
  }

  // ---- operators

  using Converter = Value (Reader::*)();
  static const std::map<std::string, Converter>& converters() {
    static const std::map<std::string, Converter> all{
        {"Const", &Reader::convertConstant},
        {"Identity", &Reader::convertIdentity},
        {"Conv2D", &Reader::convertConvolution},
        {"_FusedConv2D", &Reader::convertConvolution},
        {"DepthwiseConv2dNative", &Reader::convertDepthwise},
        {"FusedDepthwiseConv2dNative", &Reader::convertDepthwise},
        {"FusedBatchNorm", &Reader::convertBatchNorm},
        {"FusedBatchNormV3", &Reader::convertBatchNorm},
        {"MatMul", &Reader::convertMatMul},
        {"_FusedMatMul", &Reader::convertMatMul},
        {"Add", &Reader::convertAdd},
        {"AddV2", &Reader::convertAdd},
        {"AddN", &Reader::convertAdd},
        {"BiasAdd", &Reader::convertAdd},
        {"Mul", &Reader::convertMultiply},
        {"Relu", &Reader::convertActivation},
        {"Relu6", &Reader::convertActivation},
        {"Sigmoid", &Reader::convertActivation},
        {"Softmax", &Reader::convertSoftmax},
        {"AvgPool", &Reader::convertPool},
        {"MaxPool", &Reader::convertPool},
        {"Mean", &Reader::convertMean},
        {"Reshape", &Reader::convertReshape},
        {"Squeeze", &Reader::convertSqueeze},
        {"ConcatV2", &Reader::convertConcatenation},
        {"Shape", &Reader::convertShape},
        {"StridedSlice", &Reader::convertSlice},
        {"Pack", &Reader::convertPack}};
    return all;
  }
  static void requireKnown(const Node& node) {
    if (converters().contains(node.op)) return;
    std::vector<std::string> known;
    for (const auto& [op, converter] : converters()) known.push_back(op);
    throw Error(
        ErrorCode::unsupportedFile,
        fmt::format("needs the operator {}, which is not supported; supported are {}; choose `input_node` "
                    "and `output` so "
                    "that it is left out, or convert the network to ONNX",
                    node.where(), fmt::join(known, ", ")));
  }

  Value convertConstant() {
    if (!weights_.has(node_->name)) node_->fail("has no weights");
    return {-1, node_->name, {}};
  }

  Value convertIdentity() { return input(0); }

  /// Operations that may be fused into a node: a bias, its third input, and an activation.
  void fuse(Operator& op, int filters) {
    auto fused = node_->texts("fused_ops");
    const bool hasBias = !fused.empty() && fused.front() == "BiasAdd";
    node_->requireInputs(hasBias ? 3 : 2);
    if (hasBias) {
      Reals bias = weights_.reals(weightInput(2));
      if (bias.size() != static_cast<std::size_t>(filters)) node_->fail("has a bias of another size");
      op.inputs.push_back(addConstant({filters}, std::move(bias)));
      fused.erase(fused.begin());
    }
    if (fused == std::vector<std::string>{"Relu"})
      op.activation = Activation::relu;
    else if (fused == std::vector<std::string>{"Relu6"})
      op.activation = Activation::relu6;
    else if (!fused.empty())
      node_->fail(fmt::format("has the unsupported {} fused", inQuotes(fused.front())),
                  ErrorCode::unsupportedFile);
  }

  /// Rows and columns that a window of filterY × filterX gives.
  Shape slide(const Operator& op, const Shape& in, int filterY, int filterX, int channels) const {
    const auto outputs = [&](int size, int filter, int stride, int dilation) {
      const auto count = tflite::placeWindow(size, filter, stride, dilation, op.samePadding).outputs;
      if (count < 1) node_->fail("has a window larger than the image");
      return static_cast<int>(count);
    };
    return {in[0], outputs(in[1], filterY, op.strideY, op.dilationY),
            outputs(in[2], filterX, op.strideX, op.dilationX), channels};
  }

  /// Values whose last dimension, of `size`, becomes the first.
  static Reals lastFirst(const Reals& values, int size) {
    const auto last = static_cast<std::size_t>(size), rest = values.size() / last;
    Reals turned(values.size());
    for (std::size_t i = 0; i < rest; ++i)
      for (std::size_t j = 0; j < last; ++j) turned[j * rest + i] = values[i * last + j];
    return turned;
  }

  /// Weights rows×columns×inputs×filters become filters×rows×columns×inputs, as TensorFlow Lite has them.
  Value convertConvolution() {
    const std::string& name = weightInput(1);
    const Shape stored = weights_.shape(name), in = imageShape(0);
    if (stored.size() != 4 || stored[2] != in[3])
      node_->fail(fmt::format("has weights [{}] for {} channels", fmt::join(stored, "×"), in[3]));
    return convolve(Kind::conv, {stored[3], stored[0], stored[1], stored[2]},
                    lastFirst(weights_.reals(name), stored[3]), stored[3]);
  }

  /// Weights rows×columns×inputs×multiplier become 1×rows×columns×filters: the same order in memory.
  Value convertDepthwise() {
    const std::string& name = weightInput(1);
    const Shape stored = weights_.shape(name), in = imageShape(0);
    if (stored.size() != 4 || stored[2] != in[3])
      node_->fail(fmt::format("has weights [{}] for {} channels", fmt::join(stored, "×"), in[3]));
    const int filters = stored[2] * stored[3];  // fits: all elements do
    return convolve(Kind::depthwiseConv, {1, stored[0], stored[1], filters}, weights_.reals(name), filters);
  }

  Value convolve(Kind kind, const Shape& shape, Reals values, int filters) {
    node_->requireChannelsLast();
    Operator op = newOperator(kind, {tensorInput(0), addConstant(shape, std::move(values))});
    fuse(op, filters);
    op.samePadding = node_->samePadding();
    std::tie(op.strideY, op.strideX) = node_->perSide("strides");
    std::tie(op.dilationY, op.dilationX) = node_->perSide("dilations", 1);
    Shape out = slide(op, imageShape(0), shape[1], shape[2], filters);
    return add(std::move(op), std::move(out));
  }

  Value convertPool() {
    node_->requireChannelsLast();
    const Shape in = imageShape(0);
    Operator op = newOperator(node_->op == "AvgPool" ? Kind::averagePool : Kind::maxPool, {tensorInput(0)});
    op.samePadding = node_->samePadding();
    std::tie(op.strideY, op.strideX) = node_->perSide("strides");
    std::tie(op.filterY, op.filterX) = node_->perSide("ksize");
    Shape out = slide(op, in, op.filterY, op.filterX, in[3]);
    return add(std::move(op), std::move(out));
  }

  /// Mean of all pixels of an image: an average pool as large as the image.
  Value convertMean() {
    node_->requireInputs(2);
    const Shape in = imageShape(0);
    Integers axes = integersInput(1);
    for (auto& axis : axes) axis += axis < 0 ? 4 : 0;
    std::sort(axes.begin(), axes.end());
    if (axes != Integers{1, 2})
      node_->fail("takes a mean over other axes than height and width", ErrorCode::unsupportedFile);
    Operator op = newOperator(Kind::averagePool, {tensorInput(0)});
    op.filterY = in[1];
    op.filterX = in[2];
    Value mean = add(std::move(op), {in[0], 1, 1, in[3]});
    if (node_->flag("keep_dims")) return mean;
    return add(newOperator(Kind::reshape, {mean.tensor}), {in[0], in[3]});
  }

  /// Weights inputs×outputs become outputs×inputs, as TensorFlow Lite has them.
  Value convertMatMul() {
    const std::string& name = weightInput(1);
    const Shape stored = weights_.shape(name), in = shapeOf(tensorInput(0));
    if (node_->flag("transpose_a") || node_->flag("transpose_b"))
      node_->fail("turns its inputs, which is not supported", ErrorCode::unsupportedFile);
    if (stored.size() != 2 || in != Shape{1, stored[0]})
      node_->fail(fmt::format("multiplies [{}] by [{}]", fmt::join(in, "×"), fmt::join(stored, "×")));
    Operator op = newOperator(
        Kind::fullyConnected,
        {tensorInput(0), addConstant({stored[1], stored[0]}, lastFirst(weights_.reals(name), stored[1]))});
    fuse(op, stored[1]);
    return add(std::move(op), {1, stored[1]});
  }

  Value convertSoftmax() {
    const Shape shape = shapeOf(tensorInput(0));
    return add(newOperator(Kind::softmax, {tensorInput(0)}), shape);
  }

  /// (x − mean) · gamma / √(variance + ε) + beta
  Value convertBatchNorm() {
    node_->requireChannelsLast();
    node_->requireInputs(5);
    const auto channels = static_cast<std::size_t>(imageShape(0)[3]);
    std::array<Reals, 4> stored;
    for (std::size_t i = 0; i < 4; ++i) {
      stored[i] = weights_.reals(weightInput(i + 1));
      if (stored[i].size() != channels)
        node_->fail(fmt::format("has {} values for {} channels", stored[i].size(), channels));
    }
    const auto& [gamma, beta, mean, variance] = stored;
    const double least = node_->real("epsilon", 1e-4);
    Reals factor(channels), offset(channels);
    for (std::size_t c = 0; c < channels; ++c) {
      const double scale = gamma[c] / std::sqrt(variance[c] + least);
      factor[c] = static_cast<float>(scale);
      offset[c] = static_cast<float>(beta[c] - mean[c] * scale);
    }
    const Value scaled = perChannel(Kind::multiply, tensorInput(0), std::move(factor));
    return perChannel(Kind::add, scaled.tensor, std::move(offset));
  }

  Value convertAdd() { return combine(Kind::add); }
  Value convertMultiply() { return combine(Kind::multiply); }

  Value combine(Kind kind) {
    node_->requireInputs(2);
    for (const std::size_t i : {0U, 1U})
      if (!input(i).weight.empty())
        return perChannel(kind, tensorInput(1 - i), channelValues(input(i).weight));
    const Shape shape = shapeOf(tensorInput(0));
    if (shape != shapeOf(tensorInput(1))) node_->fail("joins tensors of different shapes");
    return add(newOperator(kind, {tensorInput(0), tensorInput(1)}), shape);
  }

  /// A weight that is broadcast over all but the last dimension.
  Reals channelValues(const std::string& name) const {
    const Shape& shape = weights_.shape(name);
    if (!shape.empty() && weights_.elements(name) != static_cast<std::size_t>(shape.back()))
      node_->fail(fmt::format("has values of [{}] where one a channel is supported", fmt::join(shape, "×")));
    return weights_.reals(name);
  }

  Value convertActivation() {
    Operator op = newOperator(Kind::activation, {tensorInput(0)});
    op.activation = node_->op == "Relu"    ? Activation::relu
                    : node_->op == "Relu6" ? Activation::relu6
                                           : Activation::sigmoid;
    return add(std::move(op), shapeOf(tensorInput(0)));
  }

  Value convertReshape() {
    node_->requireInputs(2);
    const Shape from = shapeOf(tensorInput(0));
    const Integers to = integersInput(1);
    const auto elements =
        static_cast<std::int64_t>(graph().tensors[static_cast<std::size_t>(tensorInput(0))].elements());
    std::int64_t known = 1;
    for (const auto size : to)
      if (size != -1) {
        if (size < 1 || size > elements / known)
          node_->fail(fmt::format("cannot make [{}] of [{}]", fmt::join(to, "×"), fmt::join(from, "×")));
        known *= size;
      }
    Shape shape;
    for (const auto size : to) shape.push_back(static_cast<int>(size == -1 ? elements / known : size));
    if (to.size() > 8 || std::count(to.begin(), to.end(), -1) > 1 || elements % known != 0 ||
        (std::count(to.begin(), to.end(), -1) == 0 && known != elements))
      node_->fail(fmt::format("cannot make [{}] of [{}]", fmt::join(to, "×"), fmt::join(from, "×")));
    return add(newOperator(Kind::reshape, {tensorInput(0)}), std::move(shape));
  }

  /// Drops dimensions of size 1: those that it names, else all.
  Value convertSqueeze() {
    const Shape from = shapeOf(tensorInput(0));
    Integers axes = node_->integers("squeeze_dims");
    for (auto& axis : axes) axis += axis < 0 ? static_cast<std::int64_t>(from.size()) : 0;
    Shape shape;
    for (std::size_t d = 0; d < from.size(); ++d) {
      const bool named = std::count(axes.begin(), axes.end(), static_cast<std::int64_t>(d)) > 0;
      if (named && from[d] != 1) node_->fail(fmt::format("drops a dimension of [{}]", fmt::join(from, "×")));
      if (!named && (from[d] != 1 || !axes.empty())) shape.push_back(from[d]);
    }
    return add(newOperator(Kind::reshape, {tensorInput(0)}), std::move(shape));
  }

  Value convertConcatenation() {
    if (node_->inputs.size() < 2) node_->fail("has too few inputs");
    const std::size_t count = node_->inputs.size() - 1;
    const Integers axis = integersInput(count);
    Shape joined = shapeOf(tensorInput(0));
    const auto rank = static_cast<std::int64_t>(joined.size());
    if (axis.size() != 1 || axis[0] < -rank || axis[0] >= rank) node_->fail("has an impossible axis");
    const auto along = static_cast<std::size_t>(axis[0] < 0 ? axis[0] + rank : axis[0]);
    std::vector<int> inputs;
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      Shape part = shapeOf(tensorInput(i));
      inputs.push_back(tensorInput(i));
      if (part.size() != joined.size()) node_->fail("joins tensors of different shapes");
      sum += std::exchange(part[along], joined[along]);
      if (part != joined) node_->fail("joins tensors of different shapes");
    }
    if (sum > static_cast<std::int64_t>(maxElements)) node_->fail("makes an impossible shape");
    joined[along] = static_cast<int>(sum);
    Operator op = newOperator(Kind::concatenation, std::move(inputs));
    op.axis = static_cast<int>(along);
    return add(std::move(op), std::move(joined));
  }

  // ---- arithmetic of shapes, done here

  Value convertShape() {
    const Shape shape = shapeOf(tensorInput(0));
    return {-1, "", Integers(shape.begin(), shape.end())};
  }

  /// A piece of a list of integers.
  Value convertSlice() {
    node_->requireInputs(4);
    const Integers list = integersInput(0), begin = integersInput(1), end = integersInput(2),
                   step = integersInput(3);
    const auto size = static_cast<std::int64_t>(list.size());
    if (begin.size() != 1 || end.size() != 1 || step != Integers{1} ||
        node_->integer("ellipsis_mask", 0) != 0 || node_->integer("new_axis_mask", 0) != 0)
      node_->fail("has a slice that is not supported", ErrorCode::unsupportedFile);
    const auto clamped = [&](std::int64_t at) {
      return std::clamp<std::int64_t>(at < 0 ? at + size : at, 0, size);
    };
    const auto first = node_->integer("begin_mask", 0) != 0 ? 0 : clamped(begin[0]);
    auto last = node_->integer("end_mask", 0) != 0 ? size : clamped(end[0]);
    if (node_->integer("shrink_axis_mask", 0) != 0) last = first + 1;
    if (first >= last || last > size) node_->fail("has an empty slice");
    return {-1, "", Integers(list.begin() + first, list.begin() + last)};
  }

  /// A list of single integers.
  Value convertPack() {
    Integers list;
    for (std::size_t i = 0; i < node_->inputs.size(); ++i) {
      const Integers one = integersInput(i);
      if (one.size() != 1) node_->fail("packs more than single integers", ErrorCode::unsupportedFile);
      list.push_back(one[0]);
    }
    return {-1, "", std::move(list)};
  }

  const Section& section_;
  Weights weights_;
  Nodes nodes_;
  std::map<const Node*, Value> values_;  ///< values of the nodes done so far
  const Node* node_ = nullptr;           ///< being converted
  std::size_t constants_ = 0;            ///< elements in network_.weights
  Network network_;
};

}  // namespace

Network readGraph(const fs::path& modelJson, const Section& section) {
  return readJson(modelJson,
                  [&](const Json& model) { return Reader(model, modelJson.parent_path(), section).read(); });
}

}  // namespace estancia::tfjs
