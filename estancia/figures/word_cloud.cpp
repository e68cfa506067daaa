// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/word_cloud.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace estancia::report {
namespace {

constexpr double largestSize = 40, smallestSize = 9;
// shares of the font's size; fit ascenders and descenders
constexpr double lineHeight = 1.16, baseline = 0.9;

/// The free place nearest to the middle along an Archimedean spiral, flattened to the box's shape.
std::optional<Box> findPlace(double width, double height, const Box& frame,
                             const std::vector<PlacedWord>& placed) {
  constexpr double pitch = 3, stride = 4;  // between turns, along the spiral
  const double flat = frame.height / frame.width;
  const double furthest = std::hypot(frame.width, frame.height) / 2 / std::min(flat, 1.0);
  for (double angle = 0, radius = 0; radius < furthest; angle += stride / std::max(radius, stride)) {
    radius = pitch * angle / 6.2832;
    const Box box{frame.x + frame.width / 2 + radius * std::cos(angle) - width / 2,
                  frame.y + frame.height / 2 + radius * flat * std::sin(angle) - height / 2, width, height};
    if (box.inside(frame) &&
        std::ranges::none_of(placed, [&](const PlacedWord& word) { return word.box.overlaps(box); }))
      return box;
  }
  return std::nullopt;
}

}  // namespace

std::vector<PlacedWord> packWords(const std::vector<std::pair<std::string, double>>& words, double width,
                                  double height) {
  const Box frame{0, 0, width, height};
  std::vector<PlacedWord> placed;
  // All words shrink together until all fit, so that sizes stay comparable; the last try drops what does not.
  for (double largest = largestSize;; largest *= 0.92) {
    const bool lastTry = largest * 0.92 < 1.6 * smallestSize;
    placed.clear();
    bool complete = true;
    for (const auto& [text, weight] : words) {
      const double size = smallestSize + (largest - smallestSize) * std::sqrt(weight / words.front().second);
      const double wide = 1.12 * size * textWidth(text) + 0.3 * size;  // semi-bold, and air between words
      if (const auto box = findPlace(wide, lineHeight * size, frame, placed))
        placed.push_back({text, size, *box});
      else
        complete = false;
      if (!complete && !lastTry) break;
    }
    if (complete || lastTry) return placed;
  }
}

Markup wordCloud(const std::vector<std::pair<std::string, double>>& words) {
  constexpr double width = 340, height = 150;
  std::string spoken;
  for (std::size_t i = 0; i < std::min<std::size_t>(words.size(), 5); ++i)
    spoken += (i == 0 ? "" : ", ") + words[i].first;

  Markup svg;
  svg.open("svg", {{"class", "cloud"},
                   {"viewBox", fmt::format("0 0 {} {}", width, height)},
                   {"role", "img"},
                   {"aria-label", "Word cloud: " + spoken}});
  const auto placed = packWords(words, width, height);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const PlacedWord& word = placed[i];
    const double air = 0.15 * word.size;
    // textLength holds the estimated width whatever font the browser has
    svg.element("text",
                {{"class", fmt::format("w{}", i % 5)},
                 {"x", word.box.x + air},
                 {"y", word.box.y + baseline * word.size},
                 {"font-size", word.size},
                 {"textLength", word.box.width - 2 * air},
                 {"lengthAdjust", "spacingAndGlyphs"}},
                word.text);
  }
  return svg.close();
}

Markup wordCloud(const Vocabulary& vocabulary, const LabelConcepts& concepts, DescriptorView mean) {
  std::vector<std::pair<std::string, double>> words;
  for (const FamiliarWord& word : familiarWords(vocabulary, concepts, mean, 25))
    if (word.probability > 1e-4F)  // less is no word of this place
      words.emplace_back(shorten(word.name, 28), word.probability);
  return wordCloud(words);
}

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
    list.add(bar(p > 0 ? 100 * p / largest : 0));
    std::string text = significant(p);
    if (!sigma.empty() && word.labels.size() == 1) text += " ± " + significant(sigma[word.labels.front()]);
    list.element("span", {{"class", "p"}}, text).close();
  }
  return list.close();
}

}  // namespace estancia::report
