// SPDX-License-Identifier: Apache-2.0
#include "own_words.hpp"

#include "estancia/words/dictionary.hpp"
#include "estancia/words/label_choice.hpp"
#include "estancia/world_query/ask_world.hpp"

namespace estancia::apps {

void addDictionaryOption(CLI::App& command, std::string& dictionary) {
  command
      .add_option(
          "--dictionary", dictionary,
          "A text file of words and what they are in English, a tab between them; words that nothing in the "
          "map has as its name are looked up in English")
      ->type_name("FILE");
}

std::vector<std::string> describeMeaning(const Meaning& meaning, const Vocabulary& vocabulary) {
  std::vector<std::string> texts = describeMatches(vocabulary, meaning.matches);
  for (const std::string& room : meaning.rooms) texts.push_back("room " + room);
  return texts;
}

std::string inEnglish(const std::string& words, const std::string& dictionary, const WorldMap& world) {
  if (dictionary.empty()) return words;
  const std::string english = Dictionary(dictionary).translate(words);
  return findMeaning(world, words).empty() ? english : words;
}

}  // namespace estancia::apps
