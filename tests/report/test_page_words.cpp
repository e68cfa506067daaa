// What the search box of a map's page understands.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "estancia/report/map_page.hpp"
#include "estancia/report/page_words.hpp"
#include "estancia/words/word_associations.hpp"
#include "support/html_checks.hpp"
#include "support/report_map.hpp"
#include "support/sample_world.hpp"

namespace estancia {
namespace {

using test::count;
using test::expectNothingFromOutside;
using test::expectWellFormed;

TopologicalMap mapOf(std::vector<std::string> labels, std::size_t used) {
  TopologicalMap map = test::sampleMap({.labels = labels.size()});
  map.vocabulary = Vocabulary(std::move(labels));
  for (Node& node : map.nodes)
    for (std::size_t label = 0; label < node.mean.size(); ++label)
      node.mean[label] = label < used ? 1.0F / static_cast<float>(used) : 0;
  return map;
}

/// Twenty labels, of which a place shows the first ten.
std::vector<std::string> twentyLabels() {
  std::vector<std::string> labels;
  for (char c = 'a'; c < 'a' + 20; ++c) labels.push_back(std::string("thing ") + c + c);
  return labels;
}

TEST(PageWords, HoldTheWordsOfLabelsThatTheMapShows) {
  const TopologicalMap map = mapOf(twentyLabels(), 10);
  const std::vector<WordAssociation> words{{"bed", true, {{12, 95}, {3, 90}, {4, 35}}},
                                           {"cot", false, {{12, 94}, {13, 93}}},
                                           {"rarely", false, {{13, 93}}},
                                           {"truth", true, {}}};
  MapPage page{map};
  page.words = &words;
  const nlohmann::json data = report::pageWords(page);
  EXPECT_EQ(data["labels"], nlohmann::json({3, 4}));
  EXPECT_EQ(data["text"], "0bed002I010Z0truth") << "known words stay, so that none is taken for misspelled";
  const std::vector<WordAssociation> named{{"mm", true, {{12, 95}}}, {"nn", true, {{12, 95}}}};
  page.words = &named;
  EXPECT_EQ(report::pageWords(page)["labels"], nlohmann::json({12})) << "a label that the word names";
}

TEST(PageWords, AreLeftOutWithoutWordNet) {
  const TopologicalMap map = mapOf(twentyLabels(), 10);
  const std::vector<WordAssociation> none;
  MapPage page{map};
  EXPECT_TRUE(report::pageWords(page).is_null());
  const std::string before = renderMapPage(page);
  page.words = &none;
  EXPECT_EQ(renderMapPage(page), before);
  EXPECT_EQ(count(before, "\"grammar\""), 0U);
}

TEST(PageWords, LeaveRareWordsOutWhereTheyAreTooMany) {
  const TopologicalMap map = mapOf(twentyLabels(), 10);
  std::vector<WordAssociation> words;
  for (char a = 'a'; a <= 'z'; ++a)
    for (char b = 'a'; b <= 'z'; ++b) {
      std::string word = "qa";
      word[0] = a;
      word[1] = b;
      words.push_back({word, a == 'x', {{1, static_cast<std::uint8_t>(a < 'm' ? 65 : 95)}}});
    }
  MapPage page{map};
  page.words = &words;
  const auto bytes = [&page](std::size_t most) {
    page.wordBytes = most;
    return report::pageWords(page)["text"].get<std::string>().size();
  };
  const std::size_t all = bytes(100'000), likely = bytes(all - 1), frequent = bytes(likely - 1);
  EXPECT_LT(likely, all);
  EXPECT_LT(frequent, likely);
  EXPECT_EQ(bytes(1), frequent) << "frequent words stay";
}

TEST(PageWords, HostileLabelsCannotBreakOut) {
  std::vector<std::string> labels = twentyLabels();
  labels[0] = "</script><script>alert(1)</script>";
  labels[1] = "quotes \" ' ` and <!--";
  labels[2] = std::string("control \x01\x02 and \xFF bytes");
  const TopologicalMap map = mapOf(labels, 10);
  const std::vector<WordAssociation> words{{"alert", true, {{0, 90}, {1, 80}, {2, 70}}}};
  MapPage page{map};
  page.words = &words;
  const std::string html = renderMapPage(page);
  expectWellFormed(html);
  expectNothingFromOutside(html);
  EXPECT_EQ(count(html, "<script"), 2U) << "data and ours";
  EXPECT_EQ(count(html, "0alert002I0128021Y"), 1U);
  EXPECT_EQ(renderMapPage(page), html);
}

}  // namespace
}  // namespace estancia
