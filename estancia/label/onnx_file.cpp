#include "estancia/label/onnx_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/io/files.hpp"
#include "estancia/label/model_files.hpp"
#include "estancia/label/protobuf.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

using protobuf::FieldReader;
using protobuf::forEachField;
using protobuf::withChanged;
using std::string_view;

constexpr std::size_t maxBytes = std::size_t{1} << 31;  // more than protobuf can hold
constexpr int maxDepth = 100;                           // of messages inside of messages, as in protobuf

/// The messages of onnx.proto that may hold tensors, and the fields that lead from one to the next.
enum class Message { model, training, function, graph, node, attribute, sparse, tensor };
struct Child {
  Message parent;
  std::uint32_t field;
  Message child;
};
constexpr Child kChildren[] = {
    {Message::model, 7, Message::graph},          // graph
    {Message::model, 20, Message::training},      // training_info
    {Message::model, 25, Message::function},      // functions
    {Message::training, 1, Message::graph},       // initialization
    {Message::training, 2, Message::graph},       // algorithm
    {Message::function, 7, Message::node},        // node
    {Message::function, 11, Message::attribute},  // attribute_proto
    {Message::graph, 1, Message::node},           // node
    {Message::graph, 5, Message::tensor},         // initializer
    {Message::graph, 15, Message::sparse},        // sparse_initializer
    {Message::node, 5, Message::attribute},       // attribute
    {Message::attribute, 5, Message::tensor},     // t
    {Message::attribute, 6, Message::graph},      // g
    {Message::attribute, 10, Message::tensor},    // tensors
    {Message::attribute, 11, Message::graph},     // graphs
    {Message::attribute, 22, Message::sparse},    // sparse_tensor
    {Message::attribute, 23, Message::sparse},    // sparse_tensors
    {Message::sparse, 1, Message::tensor},        // values
    {Message::sparse, 2, Message::tensor},        // indices
};
namespace model {
constexpr std::uint32_t graph = 7;
}
namespace graph {
constexpr std::uint32_t initializer = 5, input = 11;
}
namespace tensor {
constexpr std::uint32_t name = 8, dataLocation = 14;
}
namespace input {  // ValueInfoProto, TypeProto, TypeProto.Tensor, TensorShapeProto, Dimension
constexpr std::uint32_t name = 1, type = 2, tensorType = 1, shape = 2, dimension = 1, value = 1,
                        parameter = 2;
}

/// The text in a field; "" when there is none.
std::string textIn(string_view message, std::uint32_t number) {
  std::string text;
  forEachField(message, number, [&](string_view bytes) { text = bytes; });
  return text;
}

/// Engines look for weights in other files wherever the process happens to run, outside of the model's
/// digest.
void requireWeightsInside(string_view bytes, Message kind, const fs::path& path, int depth = 0) {
  if (depth > maxDepth) throw protobuf::Malformed();
  FieldReader reader(bytes);
  while (const auto field = reader.next()) {
    if (kind == Message::tensor && field->number == tensor::dataLocation && field->value.value_or(0) != 0)
      fail(ErrorCode::unsafePath, "{} keeps its weights ({}) in another file; save the network as one file",
           path.string(), io::printable(textIn(bytes, tensor::name)));
    if (!field->bytes) continue;
    for (const Child& child : kChildren)
      if (child.parent == kind && child.field == field->number)
        requireWeightsInside(*field->bytes, child.child, path, depth + 1);
  }
}

/// The size that a dimension has; 0 = any.
std::int64_t sizeOf(string_view dimension) {
  std::int64_t size = 0;
  FieldReader reader(dimension);
  while (const auto field = reader.next())
    if (field->number == input::value && field->value)
      size = static_cast<std::int64_t>(*field->value);
    else if (field->number == input::parameter)
      size = 0;
  return size;
}

std::string withSize(string_view dimension, std::int64_t size) {
  std::string changed = protobuf::varintField(input::value, static_cast<std::uint64_t>(size));
  FieldReader reader(dimension);
  while (const auto field = reader.next())
    if (field->number != input::value && field->number != input::parameter) changed += field->whole;
  return changed;
}

/// The shape N×C×H×W of an input that fits the preprocessing, sizes that it leaves open fixed. Engines would
/// run a network on sizes that it was not made for, or fail late.
std::string withFixedShape(string_view shape, const ModelSpec& spec, const fs::path& path) {
  const std::vector<std::int64_t> ours{1, 3, spec.preprocessing.height, spec.preprocessing.width};
  std::vector<std::int64_t> sizes;
  forEachField(shape, input::dimension, [&](string_view dimension) { sizes.push_back(sizeOf(dimension)); });
  const auto fits = [](std::int64_t theirs, std::int64_t own) { return theirs <= 0 || theirs == own; };
  if (sizes.size() != ours.size() || !std::equal(sizes.begin(), sizes.end(), ours.begin(), fits))
    fail(ErrorCode::mismatch, "{} takes an input of [{}] where model.toml makes [{}]; correct `input`",
         path.string(), fmt::join(sizes, "×"), fmt::join(ours, "×"));
  std::size_t i = 0;
  return withChanged(shape, input::dimension, [&](string_view dimension) {
    const std::int64_t size = ours[i++];
    return sizeOf(dimension) > 0 ? std::string(dimension) : withSize(dimension, size);
  });
}

/// The model with inputs of fixed sizes.
std::string withFixedInputs(std::string bytes, const ModelSpec& spec, const fs::path& path) {
  std::set<std::string> weights;  // older files list them among the inputs, too
  forEachField(bytes, model::graph, [&](string_view graph) {
    forEachField(graph, graph::initializer,
                 [&](string_view weight) { weights.insert(textIn(weight, tensor::name)); });
  });
  const auto fixedInput = [&](string_view input) {
    if (weights.contains(textIn(input, input::name))) return std::string(input);
    return withChanged(input, input::type, [&](string_view type) {
      return withChanged(type, input::tensorType, [&](string_view tensor) {
        return withChanged(tensor, input::shape,
                           [&](string_view shape) { return withFixedShape(shape, spec, path); });
      });
    });
  };
  bool isFixed = true;
  forEachField(bytes, model::graph, [&](string_view graph) {
    forEachField(graph, graph::input,
                 [&](string_view input) { isFixed = fixedInput(input) == input && isFixed; });
  });
  if (isFixed) return bytes;
  return withChanged(bytes, model::graph,
                     [&](string_view graph) { return withChanged(graph, graph::input, fixedInput); });
}

}  // namespace

bool isOnnx(const ModelSpec& spec) {
  return spec.file.extension() == ".onnx";
}

std::string readOnnx(const ModelSpec& spec) try {
  const fs::path path = modelFile(spec, spec.file);
  std::string bytes = io::readBytes(path, maxBytes);
  bool hasGraph = false;
  forEachField(bytes, model::graph, [&](string_view) { hasGraph = true; });
  if (!hasGraph) throw protobuf::Malformed();
  requireWeightsInside(bytes, Message::model, path);
  const bool anySize = spec.preprocessing.width == 0;
  return anySize ? bytes : withFixedInputs(std::move(bytes), spec, path);
} catch (const protobuf::Malformed&) {
  fail(ErrorCode::malformedFile, "{} is no ONNX file, or cut short; fetch it again",
       (spec.folder / spec.file).string());
}

}  // namespace estancia
