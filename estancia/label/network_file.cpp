#include "estancia/label/network_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/stubs/logging.h>
#include <google/protobuf/unknown_field_set.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <set>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/io/files.hpp"
#include "estancia/label/tfjs_reader.hpp"
#include "estancia/label/tfjs_weights.hpp"
#include "estancia/label/tflite_reader.hpp"
#include "estancia/label/tflite_to_onnx.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t mostBytes = std::size_t{1} << 31;  // more than protobuf can hold

bool isTflite(const ModelSpec& spec) {
  const std::string extension = spec.file.extension().string();
  return extension == ".tflite" || extension == ".lite";
}

bool isTfjs(const ModelSpec& spec) {
  return spec.file.extension() == ".json";
}

/// Whether the spec wants the network as it is, whatever its input.
bool anySize(const ModelSpec& spec) {
  return spec.preprocessing.width == 0;
}

/// What the preprocessing makes, N×C×H×W.
std::vector<std::int64_t> inputShape(const ModelSpec& spec) {
  return {1, 3, spec.preprocessing.height, spec.preprocessing.width};
}

/// `shape` is what the network says of its input, N×C×H×W; 0 = any size.
void requireInputShape(const ModelSpec& spec, const fs::path& path, const std::vector<std::int64_t>& shape) {
  if (anySize(spec)) return;
  const auto ours = inputShape(spec);
  const auto fits = [](std::int64_t theirs, std::int64_t own) { return theirs <= 0 || theirs == own; };
  if (shape.size() == ours.size() && std::equal(shape.begin(), shape.end(), ours.begin(), fits)) return;
  throw Error(fmt::format("{} takes an input of [{}] where model.toml makes [{}]; correct `input`",
                          path.string(), fmt::join(shape, "×"), fmt::join(ours, "×")));
}

[[noreturn]] void failOnDamage(const fs::path& path) {
  throw Error(fmt::format("{} is no ONNX file, or cut short; fetch it again", path.string()));
}

void requireWeightsInside(const google::protobuf::Message& message, const fs::path& path);

/// The default values of a function's attributes (FunctionProto.attribute_proto), which came after ONNX 1.12:
/// engines may know the field where our library does not.
void requireDefaultsInside(const onnx::FunctionProto& function, const fs::path& path) {
  constexpr int attributeProto = 11;
  const auto& unknown = function.GetReflection()->GetUnknownFields(function);
  for (int i = 0; i < unknown.field_count(); ++i) {
    const auto& field = unknown.field(i);
    if (field.number() != attributeProto ||
        field.type() != google::protobuf::UnknownField::TYPE_LENGTH_DELIMITED)
      continue;
    onnx::AttributeProto attribute;
    if (!attribute.ParseFromString(field.length_delimited())) failOnDamage(path);
    requireWeightsInside(attribute, path);
  }
}

/// Weights in files of their own would be looked for wherever the program happens to run, outside of the
/// model's digest. Looks at every tensor of the message, wherever it stands: dense and sparse, in subgraphs,
/// functions and training. The depth is bounded: protobuf parses at most 100 messages one inside the other.
void requireWeightsInside(const google::protobuf::Message& message, const fs::path& path) {
  if (const auto* weights = dynamic_cast<const onnx::TensorProto*>(&message);
      weights != nullptr && weights->data_location() == onnx::TensorProto::EXTERNAL)
    throw Error(fmt::format("{} keeps its weights ({}) in another file; save the network as one file",
                            path.string(), weights->name()));
  if (const auto* function = dynamic_cast<const onnx::FunctionProto*>(&message))
    requireDefaultsInside(*function, path);
  const auto* reflection = message.GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const auto* field : fields) {
    if (field->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) {
      requireWeightsInside(reflection->GetMessage(message, field), path);
      continue;
    }
    for (int i = 0; i < reflection->FieldSize(message, field); ++i)
      requireWeightsInside(reflection->GetRepeatedMessage(message, field, i), path);
  }
}

/// Engines run an ONNX network on sizes that it was not made for, or fail late: the file's own word is asked
/// first. A network for any size is fixed to ours.
std::string readOnnx(const ModelSpec& spec, const fs::path& path) {
  std::string bytes = io::readBytes(path, mostBytes);
  onnx::ModelProto model;
  if (!model.ParseFromString(bytes) || !model.has_graph()) failOnDamage(path);
  requireWeightsInside(model, path);
  std::set<std::string> weights;  // older files list them among the inputs, too
  for (const auto& weight : model.graph().initializer()) weights.insert(weight.name());
  bool fixed = false;
  for (auto& input : *model.mutable_graph()->mutable_input()) {
    if (weights.contains(input.name()) || !input.type().tensor_type().has_shape()) continue;
    std::vector<std::int64_t> shape;
    for (const auto& size : input.type().tensor_type().shape().dim()) shape.push_back(size.dim_value());
    requireInputShape(spec, path, shape);
    if (anySize(spec)) continue;
    const auto ours = inputShape(spec);
    for (int i = 0; i < 4; ++i) {
      auto* size = input.mutable_type()->mutable_tensor_type()->mutable_shape()->mutable_dim(i);
      if (size->dim_value() > 0) continue;
      size->set_dim_value(ours[static_cast<std::size_t>(i)]);
      fixed = true;
    }
  }
  return fixed ? model.SerializeAsString() : bytes;
}

std::string readTflite(const ModelSpec& spec, const fs::path& path) {
  const std::string bytes = io::readBytes(path, mostBytes);
  const auto graph =
      tflite::readGraph({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, path.string());
  const auto& shape = graph.tensors[static_cast<std::size_t>(graph.input)].shape;
  if (shape.size() != 4) throw Error(fmt::format("{} takes no image as its input", path.string()));
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
  for (const auto& file : {spec.file, spec.config, spec.embeddings})
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
  return readOnnx(spec, path);
}

}  // namespace estancia
