#include "estancia/label/cached_words.hpp"

#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

namespace estancia {
namespace {

template <class Value>
void append(std::string& bytes, Value value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// The words in `bytes`, or nothing when they are none.
std::optional<std::vector<LabelProbability>> wordsIn(std::string_view bytes) {
  std::vector<LabelProbability> words;
  while (!bytes.empty()) {
    float probability = 0;
    std::uint32_t length = 0;
    if (bytes.size() < sizeof probability + sizeof length) return std::nullopt;
    std::memcpy(&probability, bytes.data(), sizeof probability);
    std::memcpy(&length, bytes.data() + sizeof probability, sizeof length);
    bytes.remove_prefix(sizeof probability + sizeof length);
    if (length == 0 || length > bytes.size() || !(probability >= 0 && probability <= 1)) return std::nullopt;
    words.push_back({std::string(bytes.substr(0, length)), probability});
    bytes.remove_prefix(length);
  }
  return words;
}

}  // namespace

std::string packWords(DescriptorView descriptor, const Labeler& labeler) {
  if (!labeler.discovers())
    return {reinterpret_cast<const char*>(descriptor.data()), descriptor.size_bytes()};
  std::string bytes;
  for (std::size_t i = 0; i < descriptor.size(); ++i) {
    if (descriptor[i] == 0) continue;
    const std::string& label = labeler.vocabulary()[i];
    append(bytes, descriptor[i]);
    append(bytes, static_cast<std::uint32_t>(label.size()));
    bytes += label;
  }
  return bytes;
}

bool holdsWords(std::string_view bytes, const Labeler& labeler) {
  if (labeler.discovers()) return wordsIn(bytes).has_value();
  return bytes.size() == labeler.vocabulary().size() * sizeof(float);
}

LexicalDescriptor unpackWords(std::string_view bytes, Labeler& labeler) {
  if (labeler.discovers()) return labeler.adopt(wordsIn(bytes).value());
  LexicalDescriptor values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

}  // namespace estancia
