// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_graph_file.hpp"

#include <algorithm>

#include "estancia/core/bytes.hpp"

namespace estancia {
namespace {

constexpr std::string_view magic = "ESTWORDS";
constexpr float maxWeight = 1e6F;     // sums of so large weights stay finite
constexpr std::uint32_t version = 4;  // goes up with the format, and with how the graph is built

/// Whether these are offsets into a list of `end` items: from 0, never falling, one more than `count`.
bool areOffsets(const std::vector<std::uint32_t>& starts, std::size_t count, std::size_t end) {
  return starts.size() == count + 1 && starts.front() == 0 && starts.back() == end &&
         std::is_sorted(starts.begin(), starts.end());
}

bool areBelow(const std::vector<std::uint32_t>& indices, std::size_t limit) {
  return std::all_of(indices.begin(), indices.end(), [&](std::uint32_t i) { return i < limit; });
}

bool arePositive(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](float value) { return value > 0 && value < maxWeight; });
}

bool isSound(const WordGraph& graph) {
  const Lexicon& lexicon = graph.lexicon;
  const auto& first = lexicon.firstSynset;
  const WordPurposes& purposes = graph.purposes;
  return areOffsets(lexicon.starts, lexicon.size(), lexicon.text.size()) &&
         areOffsets(lexicon.senseStarts, lexicon.size(), lexicon.senseSynsets.size()) &&
         lexicon.senseWeights.size() == lexicon.senseSynsets.size() &&
         areBelow(lexicon.senseSynsets, graph.size()) && arePositive(lexicon.senseWeights) &&
         first.front() == 0 && first.back() == graph.size() && std::is_sorted(first.begin(), first.end()) &&
         graph.categories.size() == graph.size() &&
         areOffsets(graph.nameStarts, graph.size(), graph.nameText.size()) &&
         areOffsets(graph.edgeStarts, graph.size(), graph.edgeTargets.size()) &&
         areBelow(graph.edgeTargets, graph.size()) && graph.edgeWeights.size() == graph.edgeTargets.size() &&
         arePositive(graph.edgeWeights) && graph.edgeLinks.size() == graph.edgeTargets.size() &&
         areOffsets(purposes.starts, graph.size(), purposes.synsets.size()) &&
         areBelow(purposes.synsets, graph.size()) && purposes.shares.size() == purposes.synsets.size() &&
         arePositive(purposes.shares);
}

std::string textOf(ByteReader& reader) {
  return std::string(reader.raw(reader.count(1)));
}

}  // namespace

std::string packWordGraph(const WordGraph& graph, std::string_view source) {
  const auto characters = [](const std::string& text) { return std::vector<char>(text.begin(), text.end()); };
  ByteWriter writer;
  writer.raw(magic);
  writer.number(version);
  writer.text(source);
  const Lexicon& lexicon = graph.lexicon;
  writer.numbers(characters(lexicon.text));
  writer.numbers(lexicon.starts);
  writer.numbers(lexicon.senseStarts);
  writer.numbers(lexicon.senseSynsets);
  writer.numbers(lexicon.senseWeights);
  writer.numbers(lexicon.frequencies);
  for (const std::uint32_t first : lexicon.firstSynset) writer.number(first);
  writer.numbers(characters(graph.nameText));
  writer.numbers(graph.nameStarts);
  writer.numbers(graph.categories);
  writer.numbers(graph.offsets);
  writer.numbers(graph.edgeStarts);
  writer.numbers(graph.edgeTargets);
  writer.numbers(graph.edgeWeights);
  writer.numbers(graph.edgeLinks);
  writer.numbers(graph.purposes.starts);
  writer.numbers(graph.purposes.synsets);
  writer.numbers(graph.purposes.shares);
  return writer.bytes();
}

WordGraph unpackWordGraph(std::string_view bytes, std::string_view source, const std::string& name) {
  ByteReader reader(bytes, name, "delete it; it is made anew from WordNet");
  if (reader.raw(magic.size()) != magic) reader.fail("it is no word graph");
  if (reader.number<std::uint32_t>() != version)
    reader.fail("it has another version", ErrorCode::unsupportedFile);
  if (reader.text() != source) reader.fail("it was made from another WordNet", ErrorCode::unsupportedFile);
  WordGraph graph;
  Lexicon& lexicon = graph.lexicon;
  lexicon.text = textOf(reader);
  lexicon.starts = reader.numbers<std::uint32_t>();
  lexicon.senseStarts = reader.numbers<std::uint32_t>();
  lexicon.senseSynsets = reader.numbers<std::uint32_t>();
  lexicon.senseWeights = reader.numbers<float>();
  lexicon.frequencies = reader.numbers<std::uint32_t>();
  for (std::uint32_t& first : lexicon.firstSynset) first = reader.number<std::uint32_t>();
  graph.nameText = textOf(reader);
  graph.nameStarts = reader.numbers<std::uint32_t>();
  graph.categories = reader.numbers<std::uint8_t>();
  graph.offsets = reader.numbers<std::uint32_t>();
  graph.edgeStarts = reader.numbers<std::uint32_t>();
  graph.edgeTargets = reader.numbers<std::uint32_t>();
  graph.edgeWeights = reader.numbers<float>();
  graph.edgeLinks = reader.numbers<std::uint8_t>();
  graph.purposes.starts = reader.numbers<std::uint32_t>();
  graph.purposes.synsets = reader.numbers<std::uint32_t>();
  graph.purposes.shares = reader.numbers<float>();
  if (reader.remaining() != 0 || !isSound(graph)) reader.fail("it is damaged", ErrorCode::corruptFile);
  graph.sumDegrees();
  return graph;
}

}  // namespace estancia
