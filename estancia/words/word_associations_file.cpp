// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_associations_file.hpp"

#include "estancia/core/bytes.hpp"
#include "estancia/words/wordnet.hpp"

namespace estancia {
namespace {

constexpr std::string_view associationsMagic = "ESTASSOC";
constexpr std::uint32_t associationsVersion =
    4;  // goes up with the format, and with what labels are found for a word

}  // namespace

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
