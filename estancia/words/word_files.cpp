// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_files.hpp"

#include <algorithm>
#include <type_traits>

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

/// Calls use() with each member of a word graph that files hold, in their order.
template <class Graph, class Use>
void forEachMember(Graph& graph, const Use& use) {
  const auto each = [&use](auto&... members) { (use(members), ...); };
  auto& lexicon = graph.lexicon;
  each(lexicon.text, lexicon.starts, lexicon.senseStarts, lexicon.senseSynsets, lexicon.senseWeights,
       lexicon.frequencies, lexicon.firstSynset, graph.nameText, graph.nameStarts, graph.categories,
       graph.offsets, graph.edgeStarts, graph.edgeTargets, graph.edgeWeights, graph.edgeLinks,
       graph.purposes.starts, graph.purposes.synsets, graph.purposes.shares);
}

template <class Member>
constexpr bool isText = std::is_same_v<Member, std::string>;
template <class Member>
constexpr bool isArray = std::is_same_v<Member, decltype(Lexicon::firstSynset)>;

constexpr std::string_view associationsMagic = "ESTASSOC";
constexpr std::uint32_t associationsVersion = 4;  // goes up with the format, and with the labels of words

}  // namespace

std::string packWordGraph(const WordGraph& graph, std::string_view source) {
  ByteWriter writer;
  writer.raw(magic);
  writer.number(version);
  writer.text(source);
  forEachMember(graph, [&]<class Member>(const Member& member) {
    if constexpr (isText<Member>)
      writer.numbers(std::vector<char>(member.begin(), member.end()));
    else if constexpr (isArray<Member>)
      for (const std::uint32_t number : member) writer.number(number);
    else
      writer.numbers(member);
  });
  return writer.bytes();
}

WordGraph unpackWordGraph(std::string_view bytes, std::string_view source, const std::string& name) {
  ByteReader reader(bytes, name, "delete it; it is made anew from WordNet");
  if (reader.raw(magic.size()) != magic) reader.fail("it is no word graph");
  if (reader.number<std::uint32_t>() != version)
    reader.fail("it has another version", ErrorCode::unsupportedFile);
  if (reader.text() != source) reader.fail("it was made from another WordNet", ErrorCode::unsupportedFile);
  WordGraph graph;
  forEachMember(graph, [&]<class Member>(Member& member) {
    if constexpr (isText<Member>)
      member = reader.raw(reader.count(1));
    else if constexpr (isArray<Member>)
      for (std::uint32_t& number : member) number = reader.number<std::uint32_t>();
    else
      member = reader.numbers<typename Member::value_type>();
  });
  if (reader.remaining() != 0 || !isSound(graph)) reader.fail("it is damaged", ErrorCode::corruptFile);
  graph.sumDegrees();
  return graph;
}

std::string packAssociationsFile(const std::vector<WordAssociation>& associations, std::string_view source) {
  ByteWriter writer;
  writer.raw(associationsMagic);
  writer.number(associationsVersion);
  writer.text(source);
  writer.number(static_cast<std::uint32_t>(associations.size()));
  for (const WordAssociation& association : associations) {
    writer.text(association.word);
    writer.number(static_cast<std::uint8_t>(association.isFrequent));
    writer.number(static_cast<std::uint32_t>(association.labels.size()));
    for (const WordAssociation::Meant& meant : association.labels) {
      writer.number(meant.label);
      writer.number(meant.percent);
    }
  }
  return writer.bytes();
}

std::vector<WordAssociation> unpackAssociationsFile(std::string_view bytes, std::string_view source,
                                                    std::size_t labels, const std::string& name) {
  ByteReader reader(bytes, name, "delete it; it is made anew from WordNet");
  if (reader.raw(associationsMagic.size()) != associationsMagic) reader.fail("it holds no word associations");
  if (reader.number<std::uint32_t>() != associationsVersion)
    reader.fail("it has another version", ErrorCode::unsupportedFile);
  if (reader.text() != source)
    reader.fail("it was made from another WordNet or other labels", ErrorCode::unsupportedFile);
  const auto count = reader.number<std::uint32_t>();
  std::vector<WordAssociation> associations;
  for (std::uint32_t i = 0; i < count; ++i) {  // a count that lies soon meets the end
    WordAssociation& association = associations.emplace_back();
    association.word = reader.text();
    association.isFrequent = reader.number<std::uint8_t>() != 0;
    const auto meantLabels = reader.number<std::uint32_t>();
    for (std::uint32_t l = 0; l < meantLabels; ++l) {
      const auto label = reader.number<std::uint32_t>();
      const auto percent = reader.number<std::uint8_t>();
      association.labels.push_back({label, percent});
      if (label >= labels || percent > 100) reader.fail("it is damaged", ErrorCode::corruptFile);
    }
    const bool isSorted = i == 0 || associations[i - 1].word < association.word;
    if (!isSorted || !isTypedWord(association.word)) reader.fail("it is damaged", ErrorCode::corruptFile);
  }
  if (reader.remaining() != 0) reader.fail("it is damaged", ErrorCode::corruptFile);
  return associations;
}

}  // namespace estancia
