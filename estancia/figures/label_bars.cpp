// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/label_bars.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/words/label_concepts.hpp"

namespace estancia::report {

namespace {

/// "couch 0.21, studio couch, day bed 0.1": what a word stands for; of one label its line.
std::string titleOf(const FamiliarWord& word, const Vocabulary& vocabulary, DescriptorView mean) {
  if (word.labels.size() == 1) return shorten(vocabulary[word.labels.front()], 200);
  std::string title;
  for (const std::size_t label : word.labels)
    title += fmt::format("{}{} {}", title.empty() ? "" : ", ", firstSynonym(vocabulary[label]),
                         significant(mean[label]));
  return shorten(title, 200);
}

}  // namespace

Markup labelBars(const Vocabulary& vocabulary, const LabelConcepts& concepts, DescriptorView mean,
                 DescriptorView sigma, std::size_t count) {
  const std::vector<FamiliarWord> words = familiarWords(vocabulary, concepts, mean, count);
  const float largest = words.empty() ? 1 : std::max(words.front().probability, 1e-6F);
  Markup list;
  list.open("ol", {{"class", sigma.empty() ? "labels" : "labels spread"}});
  for (const FamiliarWord& word : words) {
    const float p = word.probability;
    list.open("li").element("span", {{"class", "label"}, {"title", titleOf(word, vocabulary, mean)}},
                            shorten(word.name, 40));
    list.open("span", {{"class", "bar"}})
        .element("i", {{"style", fmt::format("width:{}%", number(p > 0 ? 100 * p / largest : 0, 1))}}, "")
        .close();
    std::string text = significant(p);
    if (!sigma.empty() && word.labels.size() == 1) text += " ± " + significant(sigma[word.labels.front()]);
    list.element("span", {{"class", "p"}}, text).close();
  }
  return list.close();
}

}  // namespace estancia::report
