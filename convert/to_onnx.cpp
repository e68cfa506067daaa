// SPDX-License-Identifier: Apache-2.0
#include "convert/to_onnx.hpp"

#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <onnx/checker.h>
#include <onnx/onnx_pb.h>
#include <onnx/shape_inference/implementation.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <set>

#include "convert/quantize.hpp"
#include "convert/tfjs_reader.hpp"
#include "convert/tflite_reader.hpp"
#include "convert/tflite_to_onnx.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"

namespace estancia::convert {
namespace fs = std::filesystem;
namespace {

constexpr std::uintmax_t maxBytes = std::uintmax_t{1} << 31;  // more than protobuf can hold

bool isTflite(const fs::path& file) {
  return file.extension() == ".tflite" || file.extension() == ".lite";
}

bool isTfjs(const fs::path& file) {
  return file.extension() == ".json";
}

std::string readBytes(const fs::path& path) {
  if (fs::file_size(path) > maxBytes)
    throw Error(ErrorCode::tooLarge,
                fmt::format("{} is larger than the 2 GiB of an ONNX file", path.string()));
  std::ifstream file(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  if (!file) throw Error(ErrorCode::fileUnreadable, fmt::format("{} cannot be read", path.string()));
  return bytes;
}

std::string readTflite(const fs::path& path) {
  const std::string bytes = readBytes(path);
  const auto graph =
      tflite::readGraph({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, path.string());
  if (graph.tensors[static_cast<std::size_t>(graph.input)].shape.size() != 4)
    throw Error(ErrorCode::unsupportedFile, fmt::format("{} takes no image as its input", path.string()));
  return tflite::toOnnx(graph, path.string());
}

std::string readTfjs(const NetworkSource& source) {
  const auto network =
      tfjs::readGraph(source.file, {source.inputNode, source.outputNode, source.width, source.height});
  return tflite::toOnnx(network.graph, source.file.string());
}

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

/// The model, once ONNX's checker and shape inference have accepted it.
onnx::ModelProto checkedModel(const std::string& bytes, const fs::path& source) {
  onnx::ModelProto model;
  if (!model.ParseFromString(bytes) || !model.has_graph())
    throw Error(ErrorCode::malformedFile,
                fmt::format("{} is no ONNX file, or cut short; fetch it again", source.string()));
  try {
    onnx::checker::check_model(model);
    onnx::ModelProto inferred = model;
    onnx::shape_inference::InferShapes(inferred, onnx::OpSchemaRegistry::Instance(), {true, 1, false});
  } catch (const std::exception& e) {
    std::string reason = std::string(e.what()).substr(0, 300);
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw Error(
        ErrorCode::malformedFile,
        fmt::format("{} gives an invalid ONNX network, nothing was written: {}", source.string(), reason));
  }
  return model;
}

}  // namespace

bool needsConversion(const fs::path& file) {
  return isTflite(file) || isTfjs(file);
}

std::string readAsOnnx(const NetworkSource& source) {
  const fs::path& file = source.file;
  if (!needsConversion(file) && file.extension() != ".onnx")
    throw Error(
        ErrorCode::unsupportedFile,
        fmt::format("{} cannot be converted; give a .tflite, .lite, .json (TensorFlow.js) or .onnx file",
                    file.string()));
  if (!fs::is_regular_file(file))
    throw Error(ErrorCode::fileNotFound, fmt::format("{} is missing; check the name", file.string()));
  return isTflite(file) ? readTflite(file) : isTfjs(file) ? readTfjs(source) : readBytes(file);
}

OnnxSummary writeOnnx(const NetworkSource& source, const fs::path& target, bool overwrite) {
  const google::protobuf::LogSilencer quiet;  // protobuf prints to stderr; our Error is more specific
  if (fs::exists(target) && !overwrite)
    throw Error(ErrorCode::fileExists,
                fmt::format("{} exists; replace it with --overwrite", target.string()));
  const std::string bytes = readAsOnnx(source);
  const onnx::ModelProto model = checkedModel(bytes, source.file);
  writeWhole(target, bytes);
  return summaryOf(model);
}

void writeQuantized(const fs::path& network, const fs::path& ranges, const fs::path& target) {
  const google::protobuf::LogSilencer quiet;
  if (network.extension() != ".onnx")
    throw Error(ErrorCode::unsupportedFile,
                fmt::format("{} is no .onnx file; convert it first", network.string()));
  writeQuantized(readAsOnnx({.file = network}), network.string(), readRanges(ranges), target);
}

void writeQuantized(const std::string& onnx, const std::string& source, const ActivationRanges& ranges,
                    const fs::path& target) {
  const std::string quantized = quantizedOnnx(onnx, ranges, source);
  checkedModel(quantized, source);
  writeWhole(target, quantized);
}

}  // namespace estancia::convert
