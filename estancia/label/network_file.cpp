#include "estancia/label/network_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/stubs/logging.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/label/tfjs_reader.hpp"
#include "estancia/label/tfjs_weights.hpp"
#include "estancia/label/tflite_reader.hpp"
#include "estancia/label/tflite_to_onnx.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

bool isTflite(const ModelSpec& spec) {
  const std::string extension = spec.file.extension().string();
  return extension == ".tflite" || extension == ".lite";
}

bool isTfjs(const ModelSpec& spec) {
  return spec.file.extension() == ".json";
}

std::string readAll(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  if (!file) throw Error(fmt::format("cannot read {}", path.string()));
  return bytes;
}

/// `shape` is what the network says of its input, N×C×H×W; 0 = any size.
void requireInputShape(const ModelSpec& spec, const fs::path& path, const std::vector<std::int64_t>& shape) {
  const auto& pre = spec.preprocessing;
  const std::vector<std::int64_t> ours{1, 3, pre.height, pre.width};
  const auto fits = [](std::int64_t theirs, std::int64_t own) { return theirs <= 0 || theirs == own; };
  if (shape.size() == ours.size() && std::equal(shape.begin(), shape.end(), ours.begin(), fits)) return;
  throw Error(fmt::format("{} takes an input of [{}] where model.toml makes [{}]; correct `input`",
                          path.string(), fmt::join(shape, "×"), fmt::join(ours, "×")));
}

/// Engines run an ONNX network on sizes that it was not made for, or fail late: the file's own word is asked
/// first.
void checkOnnx(const ModelSpec& spec, const fs::path& path, const std::string& bytes) {
  onnx::ModelProto model;
  if (!model.ParseFromString(bytes) || !model.has_graph())
    throw Error(fmt::format("{} is no ONNX file, or cut short; fetch it again", path.string()));
  std::set<std::string> weights;  // older files list them among the inputs, too
  for (const auto& weight : model.graph().initializer()) weights.insert(weight.name());
  for (const auto& input : model.graph().input()) {
    if (weights.contains(input.name()) || !input.type().tensor_type().has_shape()) continue;
    std::vector<std::int64_t> shape;
    for (const auto& size : input.type().tensor_type().shape().dim()) shape.push_back(size.dim_value());
    requireInputShape(spec, path, shape);
  }
}

std::string readTflite(const ModelSpec& spec, const fs::path& path) {
  const std::string bytes = readAll(path);
  const auto graph =
      tflite::readGraph({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, path.string());
  const auto& shape = graph.tensors[static_cast<std::size_t>(graph.input)].shape;
  if (shape.size() != 4) throw Error(fmt::format("{} takes no picture as its input", path.string()));
  requireInputShape(spec, path, {shape[0], shape[3], shape[1], shape[2]});
  return tflite::toOnnx(graph, path.string());
}

std::string readTfjs(const ModelSpec& spec, const fs::path& path) {
  const auto network = tfjs::readGraph(
      path, {spec.inputNode, spec.output, spec.preprocessing.width, spec.preprocessing.height});
  return tflite::toOnnx(network.graph, path.string());
}

}  // namespace

std::vector<fs::path> networkFiles(const ModelSpec& spec) {
  std::vector<fs::path> files;
  for (const auto& file : {spec.file, spec.config})
    if (!file.empty()) files.push_back(file);
  if (isTfjs(spec))
    for (const auto& weights : tfjs::weightFiles(modelFile(spec, spec.file)))
      files.push_back(spec.file.parent_path() / weights);
  return files;
}

bool isOnnxOrConvertible(const ModelSpec& spec) {
  return isTflite(spec) || isTfjs(spec) || spec.file.extension() == ".onnx";
}

std::string readAsOnnx(const ModelSpec& spec) {
  const google::protobuf::LogSilencer quiet;  // protobuf complains to stderr; our Error says more
  const fs::path path = modelFile(spec, spec.file);
  if (isTflite(spec)) return readTflite(spec, path);
  if (isTfjs(spec)) return readTfjs(spec, path);
  std::string bytes = readAll(path);
  checkOnnx(spec, path, bytes);
  return bytes;
}

}  // namespace estancia
