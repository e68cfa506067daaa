// SPDX-License-Identifier: Apache-2.0
#include "convert/quantize.hpp"

#include <fmt/format.h>
#include <onnx/onnx_pb.h>
#include <onnx/shape_inference/implementation.h>
#include <onnx/version_converter/convert.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <set>

#include "convert/fold_pads.hpp"
#include "convert/quantization_plan.hpp"
#include "estancia/core/error.hpp"

namespace estancia::convert {
namespace {

static_assert(std::endian::native == std::endian::little);  // the byte order of ONNX's raw data

constexpr int operatorSet = 13;  // the first in which weights may have a scale a filter
constexpr int irVersion = 7;     // the first that knows it

/// The network in the operator set of our nodes.
onnx::ModelProto readModel(const std::string& bytes, const std::string& source) try {
  onnx::ModelProto model;
  if (!model.ParseFromString(bytes) || !model.has_graph())
    throw Error(ErrorCode::malformedFile,
                fmt::format("{} is no ONNX file, or cut short; fetch it again", source));
  std::int64_t version = 0;
  for (const auto& set : model.opset_import())
    if (set.domain().empty() || set.domain() == "ai.onnx") version = set.version();
  if (version < operatorSet) {
    onnx::shape_inference::InferShapes(model);  // the new form of Softmax needs the shape of what it reads
    model = onnx::version_conversion::ConvertVersion(model, operatorSet);
  }
  foldPads(*model.mutable_graph());
  model.set_ir_version(std::max<std::int64_t>(model.ir_version(), irVersion));
  return model;
} catch (const Error&) {
  throw;
} catch (const std::exception& e) {
  std::string reason = std::string(e.what()).substr(0, 300);
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  throw Error(ErrorCode::unsupportedFile,
              fmt::format("{} cannot be brought to operator set {}: {}", source, operatorSet, reason));
}

/// Throws Error when nothing in it would compute in 8 bits.
QuantizationPlan planOf(const onnx::ModelProto& model, const std::string& source) {
  for (const auto& node : model.graph().node())
    if (node.op_type() == "DequantizeLinear" || node.op_type().starts_with("QLinear"))
      throw Error(ErrorCode::unsupportedFile,
                  fmt::format("{} computes in 8 bits already; quantize a float network", source));
  QuantizationPlan plan(model.graph());
  if (plan.values().empty())
    throw Error(ErrorCode::unsupportedFile,
                fmt::format("{} has no convolutions before its last layer; it would gain nothing", source));
  return plan;
}

std::vector<float> floatsOf(const onnx::TensorProto& tensor, const std::string& source) {
  std::vector<float> values(tensor.float_data().begin(), tensor.float_data().end());
  std::size_t count = 1;
  for (const auto size : tensor.dims()) count *= static_cast<std::size_t>(size);
  if (tensor.has_raw_data() && tensor.raw_data().size() / sizeof(float) == count) {
    values.resize(count);
    std::memcpy(values.data(), tensor.raw_data().data(), count * sizeof(float));
  }
  if (values.size() != count || count == 0 ||
      !std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }))
    throw Error(
        ErrorCode::malformedFile,
        fmt::format("{}: the weights {} are cut short or not finite; fetch it again", source, tensor.name()));
  return values;
}

/// real = scale · (stored − zero)
struct Scale {
  float scale = 1;
  int zero = 0;
};

/// Zero is a stored number, and the largest is not above `high`: a limit there (ReLU6) then needs no node.
Scale scaleOf(const ActivationRange& range) {
  Scale result{(range.high - range.low) / 255, 0};
  if (!(result.scale >= std::numeric_limits<float>::min())) return {1, 0};
  result.zero = static_cast<int>(std::nearbyint(-range.low / result.scale));
  while (range.low == 0 && result.scale * 255 > range.high) result.scale = std::nextafter(result.scale, 0.0F);
  return result;
}

/// Writes the quantized graph of one network.
class Quantizer {
 public:
  Quantizer(const onnx::ModelProto& model, const QuantizationPlan& plan, const ActivationRanges& ranges,
            const std::string& source)
      : model_(model), plan_(plan), source_(source), result_(model), graph_(*result_.mutable_graph()) {
    chooseScales(ranges);
  }

  std::string write() {
    graph_.clear_node();
    graph_.clear_value_info();  // shapes are inferred again
    for (const auto& input : model_.graph().input()) quantize(input.name());
    for (int i = 0; i < model_.graph().node_size(); ++i) {
      onnx::NodeProto node = model_.graph().node(i);
      if (isSaturation(i)) {
        quantize(node.output(0), node.input(0));
        continue;
      }
      if (plan_.isQuantized(i) && hasWeights(node)) quantizeWeights(node);
      for (auto& value : *node.mutable_input())
        if (plan_.isQuantized(value)) value += "_dequantized";
      *graph_.add_node() = node;
      for (const std::string& value : node.output()) quantize(value);
    }
    dropUnused();
    std::string bytes;
    if (!result_.SerializeToString(&bytes))
      throw Error(ErrorCode::tooLarge, fmt::format("{} is too large", source_));
    return bytes;
  }

 private:
  void chooseScales(const ActivationRanges& ranges) {
    ActivationRanges joined;
    for (const std::string& value : plan_.values()) {
      const auto found = ranges.find(value);
      if (found == ranges.end())
        throw Error(
            ErrorCode::mismatch,
            fmt::format("there is no range of the value {} of {}; measure the ranges again", value, source_));
      ActivationRange& range = joined[plan_.scaleOf(value)];
      range.low = std::min(range.low, found->second.low);
      range.high = std::max(range.high, found->second.high);
    }
    for (const auto& [value, range] : joined) {
      const Scale scale = scaleOf(range);
      scales_[value] = scale;
      addFloats(value + "_scale", {}, {scale.scale});
      addBytes(value + "_zero", onnx::TensorProto::UINT8, Shape{}, {static_cast<char>(scale.zero)});
    }
  }

  template <class Dimensions>
  onnx::TensorProto& addTensor(const std::string& name, int type, const Dimensions& dimensions,
                               const void* data, std::size_t bytes) {
    onnx::TensorProto& tensor = *graph_.add_initializer();
    tensor.set_name(name);
    tensor.set_data_type(type);
    for (const auto size : dimensions) tensor.add_dims(static_cast<std::int64_t>(size));
    tensor.set_raw_data(data, bytes);
    return tensor;
  }
  using Shape = std::vector<std::size_t>;
  void addFloats(const std::string& name, const Shape& shape, const std::vector<float>& values) {
    addTensor(name, onnx::TensorProto::FLOAT, shape, values.data(), values.size() * sizeof(float));
  }
  template <class Dimensions>
  void addBytes(const std::string& name, int type, const Dimensions& dimensions,
                const std::vector<char>& values) {
    addTensor(name, type, dimensions, values.data(), values.size());
  }

  onnx::NodeProto& addNode(const char* type, const std::vector<std::string>& inputs,
                           const std::string& output) {
    onnx::NodeProto& node = *graph_.add_node();
    node.set_op_type(type);
    node.set_name(output);
    for (const std::string& input : inputs) node.add_input(input);
    node.add_output(output);
    return node;
  }

  /// Constants of 8 or 32 bits with a scale an index of `axis`, as the real numbers that they stand for.
  std::string addDequantized(const std::string& name, const std::vector<float>& scales, int zeroType,
                             int axis) {
    const std::size_t zeroBytes = zeroType == onnx::TensorProto::INT8 ? 1 : sizeof(std::int32_t);
    addFloats(name + "_scale", {scales.size()}, scales);
    addBytes(name + "_zero", zeroType, Shape{scales.size()}, std::vector<char>(scales.size() * zeroBytes, 0));
    onnx::NodeProto& node =
        addNode("DequantizeLinear", {name, name + "_scale", name + "_zero"}, name + "_dequantized");
    onnx::AttributeProto& attribute = *node.add_attribute();
    attribute.set_name("axis");
    attribute.set_type(onnx::AttributeProto::INT);
    attribute.set_i(axis);
    return name + "_dequantized";
  }

  /// Whether the stored numbers of the clamp's output end where it clamps what is computed together with it.
  /// ONNX Runtime finds that of a ReLU by itself, and fails on a Clip (1.28).
  bool isSaturation(int i) const {
    const auto& node = model_.graph().node(i);
    return node.op_type() == "Clip" && plan_.isQuantized(i) && !plan_.isQuantized(node.input(0));
  }

  void quantize(const std::string& value) { quantize(value, value); }
  /// `computed`: what the node before it calls the value.
  void quantize(const std::string& value, const std::string& computed) {
    if (!plan_.isQuantized(value)) return;
    const std::string scale = plan_.scaleOf(value) + "_scale", zero = plan_.scaleOf(value) + "_zero";
    addNode("QuantizeLinear", {computed, scale, zero}, value + "_quantized");
    addNode("DequantizeLinear", {value + "_quantized", scale, zero}, value + "_dequantized");
  }

  /// Filters are the first dimension of the weights, of a Gemm whose B is not transposed the second.
  static int axisOf(const onnx::NodeProto& node) {
    if (node.op_type() == "Conv") return 0;
    for (const auto& attribute : node.attribute())
      if (attribute.name() == "transB" && attribute.i() != 0) return 0;
    return 1;
  }

  void quantizeWeights(onnx::NodeProto& node) {
    const onnx::TensorProto& stored = *plan_.findConstant(node.input(1));
    const int axis = axisOf(node);
    if (stored.dims_size() <= axis)
      throw Error(ErrorCode::malformedFile,
                  fmt::format("{}: the weights {} are no filters; fetch it again", source_, stored.name()));
    const std::vector<float> weights = floatsOf(stored, source_);
    const auto filters = static_cast<std::size_t>(stored.dims(axis));
    const auto filterOf = [&, inner = weights.size() / filters](std::size_t i) {
      return axis == 0 ? i / inner : i % filters;
    };
    std::vector<std::vector<float>> ofFilter(filters);
    for (std::size_t i = 0; i < weights.size(); ++i) ofFilter[filterOf(i)].push_back(weights[i]);
    const float step = weightStep(weights);
    std::vector<float> scales;
    for (const auto& filter : ofFilter) scales.push_back(weightScale(filter, step));
    std::vector<char> bytes(weights.size());
    for (std::size_t i = 0; i < weights.size(); ++i)
      bytes[i] =
          static_cast<char>(std::clamp(std::nearbyint(weights[i] / scales[filterOf(i)]), -127.0F, 127.0F));
    const std::string name = node.output(0) + "_weights8";
    addBytes(name, onnx::TensorProto::INT8, stored.dims(), bytes);
    node.set_input(1, addDequantized(name, scales, onnx::TensorProto::INT8, axis));
    if (node.input_size() > 2 && !node.input(2).empty()) quantizeBias(node, scales);
  }

  /// Biases are added to sums of products, whose scale is that of the input times that of the weights.
  void quantizeBias(onnx::NodeProto& node, const std::vector<float>& weightScales) {
    const onnx::TensorProto& stored = *plan_.findConstant(node.input(2));
    const std::vector<float> biases = floatsOf(stored, source_);
    if (biases.size() != weightScales.size())
      throw Error(ErrorCode::malformedFile, fmt::format("{}: {} biases for {} filters; fetch it again",
                                                        source_, biases.size(), weightScales.size()));
    constexpr double largest = std::numeric_limits<std::int32_t>::max();
    const float inputScale = scales_.at(plan_.scaleOf(node.input(0))).scale;
    std::vector<float> scales;
    std::vector<std::int32_t> numbers;
    for (std::size_t f = 0; f < biases.size(); ++f) {
      scales.push_back(std::max(inputScale * weightScales[f], std::numeric_limits<float>::min()));
      const double steps = std::nearbyint(static_cast<double>(biases[f]) / scales[f]);
      numbers.push_back(static_cast<std::int32_t>(std::clamp(steps, -largest, largest)));
    }
    const std::string name = node.output(0) + "_bias32";
    addTensor(name, onnx::TensorProto::INT32, Shape{numbers.size()}, numbers.data(),
              numbers.size() * sizeof(std::int32_t));
    node.set_input(2, addDequantized(name, scales, onnx::TensorProto::INT32, 0));
  }

  /// The float weights, also where older files list them among the inputs.
  void dropUnused() {
    std::set<std::string> used;
    for (const auto& node : graph_.node()) used.insert(node.input().begin(), node.input().end());
    for (const auto& output : graph_.output()) used.insert(output.name());
    const auto erase = [&](auto* list, const auto& isGone) {
      list->erase(std::remove_if(list->begin(), list->end(), isGone), list->end());
    };
    erase(graph_.mutable_input(), [&](const auto& input) {
      return plan_.findConstant(input.name()) != nullptr && !used.contains(input.name());
    });
    erase(graph_.mutable_initializer(),
          [&](const auto& constant) { return !used.contains(constant.name()); });
  }

  const onnx::ModelProto& model_;
  const QuantizationPlan& plan_;
  const std::string& source_;
  onnx::ModelProto result_;
  onnx::GraphProto& graph_;
  std::map<std::string, Scale> scales_;  ///< scales of representatives
};

double squaredError(const std::vector<float>& weights, float scale) {
  double error = 0;
  for (const float weight : weights) {
    const float stored = std::clamp(std::nearbyint(weight / scale), -127.0F, 127.0F);
    const double difference = static_cast<double>(stored) * scale - weight;
    error += difference * difference;
  }
  return error;
}

}  // namespace

float weightStep(const std::vector<float>& weights) {
  float step = std::numeric_limits<float>::max(), largest = 0;
  for (const float weight : weights) {
    if (weight != 0) step = std::min(step, std::abs(weight));
    largest = std::max(largest, std::abs(weight));
  }
  constexpr float maxSteps = 255, tolerance = 1e-3F;
  if (largest == 0 || largest / step > maxSteps + 0.5F) return 0;
  const bool all = std::all_of(weights.begin(), weights.end(), [step](float weight) {
    const float steps = weight / step;
    return std::abs(steps - std::nearbyint(steps)) < tolerance;
  });
  return all ? step : 0;
}

float weightScale(const std::vector<float>& weights, float step) {
  constexpr int candidates = 25;  // from all weights inside, to half of the range
  constexpr float stride = 0.02F;
  float largest = 0;
  for (const float weight : weights) largest = std::max(largest, std::abs(weight));
  const float full = std::max(largest / 127, std::numeric_limits<float>::min());
  float best = full;
  double least = squaredError(weights, full);
  const auto propose = [&](float scale) {
    if (!(scale >= std::numeric_limits<float>::min())) return;
    if (const double error = squaredError(weights, scale); error < least) {
      least = error;
      best = scale;
    }
  };
  for (int k = 1; k < candidates; ++k) propose(full * (1 - stride * static_cast<float>(k)));
  propose(step);
  return best;
}

std::vector<std::string> valuesToQuantize(const std::string& onnx, const std::string& source) {
  const onnx::ModelProto model = readModel(onnx, source);
  return planOf(model, source).values();
}

std::string quantizedOnnx(const std::string& onnx, const ActivationRanges& ranges,
                          const std::string& source) {
  const onnx::ModelProto model = readModel(onnx, source);
  return Quantizer(model, planOf(model, source), ranges, source).write();
}

}  // namespace estancia::convert
