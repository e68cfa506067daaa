// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/model_files.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

using std::string_view;

// ---- fields of a serialized message in the protobuf wire format (protobuf.dev, "Encoding")

enum WireType : std::uint32_t { varintType = 0, fixed64Type = 1, bytesType = 2, fixed32Type = 5 };

/// Thrown when bytes are no message.
struct Malformed {};

struct Field {
  std::uint32_t number = 0;
  /// Value of a varint field.
  std::optional<std::uint64_t> value = {};
  /// Content of a length-delimited field: a text, bytes, or a message.
  std::optional<string_view> bytes = {};
  /// The whole field with its tag.
  string_view whole = {};
};

/// Walks over a message. Views point into it.
class FieldReader {
 public:
  explicit FieldReader(string_view message) : rest_(message) {}
  /// The next field, or nothing at the end. Throws Malformed.
  std::optional<Field> next() {
    if (rest_.empty()) return {};
    const string_view start = rest_;
    const std::uint64_t tag = varint();
    Field field{.number = static_cast<std::uint32_t>(tag >> 3U)};
    switch (tag & 7U) {
      case varintType:
        field.value = varint();
        break;
      case fixed64Type:
        take(8);
        break;
      case bytesType:
        field.bytes = take(varint());
        break;
      case fixed32Type:
        take(4);
        break;
      default:
        throw Malformed();
    }
    if (field.number == 0) throw Malformed();
    field.whole = start.substr(0, start.size() - rest_.size());
    return field;
  }

 private:
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const auto byte = static_cast<unsigned char>(take(1)[0]);
      value |= std::uint64_t{byte & 0x7FU} << shift;
      if (byte < 0x80) return value;
    }
    throw Malformed();
  }
  string_view take(std::uint64_t size) {
    if (size > rest_.size()) throw Malformed();
    const string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }

  string_view rest_;
};

std::string varintBytes(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7U) bytes += static_cast<char>(value | 0x80U);
  return bytes + static_cast<char>(value);
}

/// Calls use(bytes) for each length-delimited field of this number.
void forEachField(string_view message, std::uint32_t number, const std::function<void(string_view)>& use) {
  FieldReader reader(message);
  while (const auto field = reader.next())
    if (field->number == number && field->bytes) use(*field->bytes);
}

/// Fields as bytes.
std::string varintField(std::uint32_t number, std::uint64_t value) {
  return varintBytes(number << 3U | varintType) + varintBytes(value);
}

std::string bytesField(std::uint32_t number, string_view bytes) {
  std::string field = varintBytes(number << 3U | bytesType) + varintBytes(bytes.size());
  return field.append(bytes);
}

/// The message with change(bytes) in the place of each length-delimited field of this number.
std::string withChanged(string_view message, std::uint32_t number,
                        const std::function<std::string(string_view)>& change) {
  std::string changed;
  changed.reserve(message.size() + 64);
  FieldReader reader(message);
  while (const auto field = reader.next())
    if (field->number == number && field->bytes)
      changed += bytesField(number, change(*field->bytes));
    else
      changed += field->whole;
  return changed;
}

// ---- ONNX

constexpr std::size_t maxBytes = std::size_t{1} << 31;  // more than protobuf can hold
constexpr int maxDepth = 100;                           // nesting depth of messages, as in protobuf

/// The messages of onnx.proto that may hold tensors, and the fields that lead from one to the next.
enum class Message { model, training, function, graph, node, attribute, sparse, tensor };
struct Child {
  Message parent;
  std::uint32_t field;
  Message child;
};
constexpr Child children[] = {
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
constexpr std::uint32_t node = 1, initializer = 5, input = 11, output = 12;
}
namespace node {
constexpr std::uint32_t output = 2;
}
namespace tensor {
constexpr std::uint32_t name = 8, dataLocation = 14;
}
namespace input {  // ValueInfoProto, TypeProto, TypeProto.Tensor, TensorShapeProto, Dimension
constexpr std::uint32_t name = 1, type = 2, tensorType = 1, elementType = 1, shape = 2, dimension = 1,
                        value = 1, parameter = 2;
}

/// The text in a field; "" when there is none.
std::string textIn(string_view message, std::uint32_t number) {
  std::string text;
  forEachField(message, number, [&](string_view bytes) { text = bytes; });
  return text;
}

/// Engines look for weights in other files wherever the process runs, outside of the model's digest.
void requireWeightsInside(string_view bytes, Message kind, const fs::path& path, int depth = 0) {
  if (depth > maxDepth) throw Malformed();
  FieldReader reader(bytes);
  while (const auto field = reader.next()) {
    if (kind == Message::tensor && field->number == tensor::dataLocation && field->value.value_or(0) != 0)
      fail(ErrorCode::unsafePath, "{} keeps its weights ({}) in another file; save the network as one file",
           path.string(), io::printable(textIn(bytes, tensor::name)));
    if (!field->bytes) continue;
    for (const Child& child : children)
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
  std::string changed = varintField(input::value, static_cast<std::uint64_t>(size));
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

/// The model with the value `name` among its outputs: engines give no value inside of a network otherwise.
/// Where there is none, NetworkLabeler::chooseOutput() lists the outputs.
std::string withOutput(std::string bytes, string_view name) {
  bool isOutput = false, isInside = false;
  forEachField(bytes, model::graph, [&](string_view graph) {
    forEachField(graph, graph::output,
                 [&](string_view output) { isOutput = isOutput || textIn(output, input::name) == name; });
    forEachField(graph, graph::node, [&](string_view node) {
      forEachField(node, node::output, [&](string_view output) { isInside = isInside || output == name; });
    });
  });
  if (isOutput || !isInside) return bytes;
  constexpr std::uint64_t float32 = 1;  // TensorProto.DataType
  const std::string tensor = bytesField(input::tensorType, varintField(input::elementType, float32));
  const std::string output = bytesField(input::name, name) + bytesField(input::type, tensor);
  return withChanged(bytes, model::graph, [&](string_view graph) {
    return std::string(graph) + bytesField(graph::output, output);
  });
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
  if (!hasGraph) throw Malformed();
  requireWeightsInside(bytes, Message::model, path);
  const bool anySize = spec.preprocessing.width == 0;
  if (!anySize) bytes = withFixedInputs(std::move(bytes), spec, path);
  return spec.output.empty() ? bytes : withOutput(std::move(bytes), spec.output);
} catch (const Malformed&) {
  fail(ErrorCode::malformedFile, "{} is no ONNX file, or cut short; fetch it again",
       (spec.folder / spec.file).string());
}

}  // namespace estancia
