#include "estancia/label/convert.hpp"

#include <fmt/format.h>
#include <onnx/checker.h>
#include <onnx/onnx_pb.h>
#include <onnx/shape_inference/implementation.h>

#include <algorithm>
#include <exception>
#include <set>

#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/label/network_file.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

OnnxSummary::Tensor summaryOf(const onnx::ValueInfoProto& value) {
  OnnxSummary::Tensor tensor{value.name(), {}};
  for (const auto& size : value.type().tensor_type().shape().dim()) tensor.second.push_back(size.dim_value());
  return tensor;
}

OnnxSummary summaryOf(const onnx::ModelProto& model) {
  OnnxSummary summary;
  std::set<std::string> weights;
  for (const auto& weight : model.graph().initializer()) weights.insert(weight.name());
  for (const auto& input : model.graph().input())
    if (!weights.contains(input.name())) summary.inputs.push_back(summaryOf(input));
  for (const auto& output : model.graph().output()) summary.outputs.push_back(summaryOf(output));
  for (const auto& set : model.opset_import())
    if (set.domain().empty() || set.domain() == "ai.onnx") summary.operatorSet = set.version();
  summary.nodes = static_cast<std::size_t>(model.graph().node_size());
  return summary;
}

/// Throws what ONNX's checker and its inference of shapes say against the model.
void check(onnx::ModelProto model) {
  onnx::checker::check_model(model);
  onnx::shape_inference::InferShapes(model, onnx::OpSchemaRegistry::Instance(), {true, 1, false});
}

}  // namespace

ModelSpec specOfFile(const fs::path& network) {
  ModelSpec spec;
  const fs::path folder = network.parent_path();
  spec.folder = folder.empty() ? "." : folder;
  spec.file = network.filename();
  spec.name = network.stem().string();
  spec.preprocessing.width = spec.preprocessing.height = 0;
  return spec;
}

OnnxSummary convertToOnnx(const ModelSpec& spec, const fs::path& target, bool overwrite) {
  if (fs::exists(target) && !overwrite)
    throw Error(fmt::format("{} exists; replace it with --overwrite", target.string()));
  const fs::path source = modelFile(spec, spec.file);
  if (!isOnnxOrConvertible(spec))
    throw Error(
        fmt::format("{} is of a kind that cannot be converted; known are .tflite, .lite, .json and .onnx",
                    source.string()));
  const std::string bytes = readAsOnnx(spec);
  onnx::ModelProto model;
  model.ParseFromString(bytes);
  try {
    check(model);
  } catch (const std::exception& e) {
    std::string reason = std::string(e.what()).substr(0, 300);
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw Error(
        fmt::format("{} makes no sound ONNX network, nothing was written: {}", source.string(), reason));
  }
  writeWhole(target, bytes);
  return summaryOf(model);
}

}  // namespace estancia
