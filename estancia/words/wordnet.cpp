// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/wordnet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <string_view>
#include <unordered_map>

#include "estancia/core/ascii.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/home.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::array<const char*, partsOfSpeech> fileEndings = {"noun", "verb", "adj", "adv"};
constexpr std::uintmax_t maxFileBytes = 256u << 20;  // WordNet 3.0's largest has 15 MB

/// Where something stands in a file.
struct WordNetLine {
  const fs::path* path;
  std::size_t line;

  [[noreturn]] void fail(std::string_view why) const {
    estancia::fail(ErrorCode::malformedFile, "{}, line {}: {}; reinstall WordNet (Debian: wordnet-base)",
                   path->string(), line, why);
  }
};

/// The fields of one line, separated by blanks.
class Fields {
 public:
  Fields(std::string_view line, WordNetLine place) : rest_(line), place_(place) {}

  std::string_view next() {
    const std::size_t from = rest_.find_first_not_of(' ');
    if (from == std::string_view::npos) fail("it ends too early");
    rest_.remove_prefix(from);
    const std::string_view field = rest_.substr(0, rest_.find(' '));
    rest_.remove_prefix(field.size());
    return field;
  }
  std::uint32_t number(int base = 10) {
    const std::string_view field = next();
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value, base);
    if (error != std::errc() || end != field.data() + field.size()) fail("a number is malformed");
    return value;
  }
  bool atEnd() const { return rest_.find_first_not_of(' ') == std::string_view::npos; }
  [[noreturn]] void fail(std::string_view why) const { place_.fail(why); }

 private:
  std::string_view rest_;
  WordNetLine place_;
};

/// Calls `use(line, place)` for each line that is no part of the license at the head of a file.
template <class Use>
void forEachLine(const fs::path& path, const Use& use) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file)
    fail(ErrorCode::fileUnreadable, "cannot read {}; install WordNet (Debian: wordnet-base)", path.string());
  if (bytes > maxFileBytes)
    fail(ErrorCode::tooLarge, "{}: {} bytes are no WordNet; set ESTANCIA_WORDNET to the folder of data.noun",
         path.string(), bytes);
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line.front() == ' ') continue;
    use(std::string_view(line), WordNetLine{&path, number});
  }
}

PartOfSpeech posOf(std::string_view letter, const Fields& fields) {
  if (letter == "n") return PartOfSpeech::noun;
  if (letter == "v") return PartOfSpeech::verb;
  if (letter == "a" || letter == "s") return PartOfSpeech::adjective;
  if (letter == "r") return PartOfSpeech::adverb;
  fields.fail("a part of speech is unknown");
}

std::string withSpaces(std::string_view word) {
  std::string text(word);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

/// "lemma%1:06:00::" of cntlist.rev (senseidx(5WN)): the key of one meaning of a word; satellites of
/// adjectives (type 5) name their head, which is dropped here: their counts are not used apart.
std::string senseKey(std::string_view word, int type, unsigned category, unsigned lexicalId) {
  return fmt::format("{}%{}:{:02}:{:02}", word, type, category, lexicalId);
}

using TagCounts = std::unordered_map<std::string, std::uint32_t>;

TagCounts readTagCounts(const fs::path& path) {
  TagCounts counts;
  forEachLine(path, [&](std::string_view line, WordNetLine place) {
    Fields fields(line, place);
    const std::string_view key = fields.next();
    fields.next();
    std::size_t colons = 0, end = 0;
    for (; end < key.size() && colons < 3; ++end) colons += key[end] == ':';
    counts[std::string(key.substr(0, end - (colons == 3 ? 1 : 0)))] = fields.number();
  });
  return counts;
}

int senseType(char type) {
  return type == 'n' ? 1 : type == 'v' ? 2 : type == 'a' ? 3 : type == 'r' ? 4 : 5;
}

/// One line of data.POS. Relations name byte offsets until all files are read.
WordNetSynset readSynset(std::string_view line, Fields fields, PartOfSpeech pos, const TagCounts& counts) {
  WordNetSynset synset;
  synset.pos = pos;
  synset.offset = fields.number();
  const std::uint32_t category = fields.number();
  synset.category = static_cast<WordCategory>(std::min(category, 255u));
  const std::string_view type = fields.next();
  if (posOf(type, fields) != pos) fields.fail("a synset stands in the file of another part of speech");
  for (std::uint32_t left = fields.number(16); left > 0; --left) {
    std::string_view word = fields.next();
    const std::uint32_t lexicalId = fields.number(16);
    if (const std::size_t marker = word.find('('); marker != std::string_view::npos && marker > 0)
      word = word.substr(0, marker);  // "(a)", "(p)", "(ip)": where an adjective may stand
    const auto count =
        counts.find(senseKey(lowerCase(std::string(word)), senseType(type.front()), category, lexicalId));
    synset.words.push_back(withSpaces(word));
    synset.tagCounts.push_back(count == counts.end() ? 0 : count->second);
  }
  for (std::uint32_t left = fields.number(); left > 0; --left) {
    WordNetSynset::Relation relation;
    relation.symbol = std::string(fields.next());
    relation.target = fields.number();
    relation.pos = posOf(fields.next(), fields);
    fields.next();  // which words are related: all of the synset here
    synset.relations.push_back(std::move(relation));
  }
  if (synset.words.empty()) fields.fail("a synset has no words");
  if (const std::size_t bar = line.find(" | "); bar != std::string_view::npos)
    synset.gloss = std::string(line.substr(bar + 3));
  return synset;
}

/// From byte offsets to indices of synsets, for each part of speech.
using SynsetIndex = std::array<std::unordered_map<std::uint32_t, std::uint32_t>, partsOfSpeech>;

std::optional<std::uint32_t> synsetAt(const SynsetIndex& index, PartOfSpeech pos, std::uint32_t offset) {
  const auto& offsets = index[static_cast<std::size_t>(pos)];
  const auto found = offsets.find(offset);
  return found == offsets.end() ? std::nullopt : std::optional(found->second);
}

void readEntries(const fs::path& path, PartOfSpeech pos, const SynsetIndex& index, WordNet& wordNet) {
  forEachLine(path, [&](std::string_view line, WordNetLine place) {
    Fields fields(line, place);
    WordNetEntry entry{withSpaces(fields.next()), pos, {}};
    fields.next();
    const std::uint32_t count = fields.number();
    for (std::uint32_t symbols = fields.number(); symbols > 0; --symbols) fields.next();
    fields.next();
    fields.next();
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::optional<std::uint32_t> synset = synsetAt(index, pos, fields.number());
      if (!synset) fields.fail("it names a synset that is not there");
      entry.synsets.push_back(*synset);
    }
    wordNet.entries.push_back(std::move(entry));
  });
}

void readIrregularForms(const fs::path& path, PartOfSpeech pos, WordNet& wordNet) {
  forEachLine(path, [&](std::string_view line, WordNetLine place) {
    Fields fields(line, place);
    const std::string form = withSpaces(fields.next());
    if (fields.atEnd()) fields.fail("an irregular form has no word");
    while (!fields.atEnd()) wordNet.irregularForms.push_back({form, withSpaces(fields.next()), pos});
  });
}

}  // namespace

std::vector<fs::path> wordNetFiles(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const std::string ending : fileEndings)
    for (const std::string& name : {"data." + ending, "index." + ending, ending + ".exc"})
      files.push_back(folder / name);
  files.push_back(folder / "cntlist.rev");
  return files;
}

std::optional<fs::path> findWordNet() {
  std::string folder = environment("ESTANCIA_WORDNET");
  if (folder.empty()) folder = "/usr/share/wordnet";
  std::error_code error;
  return fs::exists(fs::path(folder) / "data.noun", error) ? std::optional<fs::path>(folder) : std::nullopt;
}

WordNet readWordNet(const fs::path& folder) {
  WordNet wordNet;
  const TagCounts counts = readTagCounts(folder / "cntlist.rev");
  SynsetIndex index;
  std::array<fs::path, partsOfSpeech> paths;
  std::vector<std::size_t> lines;  // line numbers of the synsets
  for (std::size_t p = 0; p < partsOfSpeech; ++p) {
    paths[p] = folder / fmt::format("data.{}", fileEndings[p]);
    forEachLine(paths[p], [&](std::string_view line, WordNetLine place) {
      wordNet.synsets.push_back(readSynset(line, Fields(line, place), static_cast<PartOfSpeech>(p), counts));
      if (!index[p].emplace(wordNet.synsets.back().offset, static_cast<std::uint32_t>(lines.size())).second)
        place.fail("a synset above has the same number");
      lines.push_back(place.line);
    });
  }
  for (std::size_t s = 0; s < wordNet.synsets.size(); ++s)
    for (WordNetSynset::Relation& relation : wordNet.synsets[s].relations) {
      const std::optional<std::uint32_t> target = synsetAt(index, relation.pos, relation.target);
      if (!target)
        WordNetLine{&paths[static_cast<std::size_t>(wordNet.synsets[s].pos)], lines[s]}.fail(
            "it names a synset that is not there");
      relation.target = *target;
    }
  for (std::size_t p = 0; p < partsOfSpeech; ++p) {
    const auto pos = static_cast<PartOfSpeech>(p);
    const fs::path path = folder / fmt::format("index.{}", fileEndings[p]);
    const std::size_t before = wordNet.entries.size();
    readEntries(path, pos, index, wordNet);
    if (wordNet.entries.size() == before) WordNetLine{&path, 1}.fail("there are no words");
    readIrregularForms(folder / fmt::format("{}.exc", fileEndings[p]), pos, wordNet);
  }
  return wordNet;
}

}  // namespace estancia
