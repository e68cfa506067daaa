// SPDX-License-Identifier: Apache-2.0
#include "scenes/scenes_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "estancia/files/csv.hpp"
#include "findings/pivot.hpp"
#include "scenes/scenes_rankings.hpp"
#include "scenes/scenes_statistics.hpp"
#include "scenes/scenes_subsets.hpp"

namespace estancia::experiments {
namespace {

using Best = ResultTable::Best;
using Descriptor = ScenesResults::Descriptor;
using Pair = ScenesResults::Pair;

constexpr std::size_t maxCells = 25;
constexpr std::size_t maxImages = 15;
constexpr std::uint64_t choiceSeed = 1;

class Sections {
 public:
  explicit Sections(const ScenesResults& results) : results_(results) {}

  using Of = std::function<double(const SceneAnswers&, const SceneTest&)>;
  using Which = std::function<bool(const Pair&)>;

  std::size_t cellCount() const { return results_.descriptors.size() * results_.classifiers.size(); }
  const SceneAnswers& cell(std::size_t pair, std::size_t number) const {
    return results_.cells[pair * cellCount() + number];
  }
  const Descriptor& descriptorOf(std::size_t number) const {
    return results_.descriptors[number / results_.classifiers.size()];
  }
  std::string nameOf(std::size_t number) const {
    return descriptorOf(number).name + "/" + results_.classifiers[number % results_.classifiers.size()];
  }

  /// Mean over some pairs, in percent; absent where there are none.
  CellValue percent(std::size_t number, const Of& of, const Which& which) const {
    std::vector<double> values;
    for (std::size_t p = 0; p < results_.pairs.size(); ++p)
      if (which(results_.pairs[p])) values.push_back(100 * of(cell(p, number), results_.pairs[p].images));
    return values.empty() ? std::nullopt : CellValue(meanOf(values));
  }

  /// Descriptors down, classifiers across.
  ResultTable byDescriptor(const std::string& title, const std::string& caption, const Of& of,
                           const Which& which) const {
    return pivot({results_.name + ": " + title,
                  caption,
                  "descriptor",
                  columnsOf(results_.classifiers, 1, Best::largest),
                  {}},
                 namesIn(results_.descriptors), [&](std::size_t descriptor, std::size_t classifier) {
                   return percent(descriptor * results_.classifiers.size() + classifier, of, which);
                 });
  }

  /// Cells down, the pairs that are wanted across, each by its `end`: train or test.
  ResultTable byPair(const std::string& title, const Which& which, std::string Pair::*end) const {
    std::vector<std::size_t> pairs;
    std::vector<std::string> ends, names;
    for (std::size_t p = 0; p < results_.pairs.size(); ++p)
      if (which(results_.pairs[p])) pairs.push_back(p), ends.push_back(results_.pairs[p].*end);
    for (std::size_t c = 0; c < cellCount(); ++c) names.push_back(nameOf(c));
    return pivot({results_.name + ": accuracy, " + title,
                  "In percent; the images of each pair are below.",
                  "descriptor, classifier",
                  columnsOf(ends, 1, Best::largest),
                  {},
                  100},
                 names, [&](std::size_t row, std::size_t column) -> CellValue {
                   const std::size_t p = pairs[column];
                   return 100 * cell(p, row).accuracy(results_.pairs[p].images);
                 });
  }

  /// The cells whose descriptor is wanted, best mean accuracy first.
  std::vector<std::size_t> ranked(const std::function<bool(const Descriptor&)>& wanted) const {
    std::vector<std::size_t> cells, sorted;
    for (std::size_t c = 0; c < cellCount(); ++c)
      if (wanted(descriptorOf(c))) cells.push_back(c);
    const auto means = meanAccuracies(results_, cells);
    for (const std::size_t i : ascending(cells.size(), [&](std::size_t c) { return -means[c]; }))
      sorted.push_back(cells[i]);
    return sorted;
  }

  ResultTable best() const {
    const bool one = results_.pairs.size() == 1;
    auto best = ranked([](const Descriptor&) { return true; });
    best.resize(std::min(best.size(), maxCells));
    std::vector<std::pair<std::string, std::size_t>> cells;
    for (const std::size_t c : best) cells.emplace_back(nameOf(c), c);
    const Which tells = [this](const Pair& pair) { return results_.tells(pair); };
    return pivot<std::size_t>(
        {fmt::format("{}: the best {} of {} cells", results_.name, cells.size(), cellCount()),
         one ? "Accuracy in percent with its 95 % interval: Wilson's, with as many images as independent "
               "ones "
               "would tell as much, since images of one room taken one after another are no independent "
               "witnesses (docs/measured/scenes.md). The best of many cells looks better than it is. All "
               "cells are in "
               "results.csv."
             : "Accuracy in percent, the mean over pairs of training and test, and its worst and best pair. "
               "Intervals of each pair are in results.csv.",
         "descriptor, classifier",
         {},
         {}},
        cells,
        {{{"accuracy", 1, Best::largest}, [&](auto c) { return percent(c, &SceneAnswers::accuracy, tells); }},
         {{one ? "low" : "worst pair", 1}, [&](auto c) { return bounds(c).first; }},
         {{one ? "high" : "best pair", 1}, [&](auto c) { return bounds(c).second; }},
         {{"balanced", 1, Best::largest},
          [&](auto c) { return percent(c, &SceneAnswers::balancedAccuracy, tells); }}});
  }

  /// For each true room, the share of its images that were taken for each other one; over all pairs that
  /// tells() accepts.
  HeatTable confusion(std::size_t number, const std::string& what) const {
    const std::size_t rooms = results_.rooms.size();
    std::vector<double> sums(rooms * rooms);
    for (std::size_t p = 0; p < results_.pairs.size(); ++p) {
      if (!results_.tells(results_.pairs[p])) continue;
      const auto counts = cell(p, number).confusion(results_.pairs[p].images);
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += counts[i];
    }
    HeatTable matrix{fmt::format("{}: rooms taken for others by {}", results_.name, nameOf(number)),
                     fmt::format("{}. A row is a room, the percent of its images that were taken for each of "
                                 "the rooms. All confusions are in {}-confusions.csv.",
                                 what, results_.name),
                     results_.rooms,
                     {},
                     0};
    for (std::size_t r = 0; r < rooms; ++r) {
      const auto begin = sums.begin() + static_cast<std::ptrdiff_t>(r * rooms);
      const double images = std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(rooms), 0.0);
      for (std::size_t a = 0; a < rooms; ++a)
        matrix.values.push_back(images > 0 ? 100 * sums[r * rooms + a] / images
                                           : std::numeric_limits<double>::quiet_NaN());
    }
    return matrix;
  }

  ResultTable hardest() const {
    ResultTable table{
        results_.name + ": the most difficult images",
        fmt::format("Share of the cells that were wrong, in percent, and what most of them took "
                    "the image for. All images are in {}-images.csv.",
                    results_.name),
        "image",
        {{"wrong", 0}},
        {}};
    const auto rows = images();
    for (std::size_t i = 0; i < std::min(rows.size(), maxImages); ++i) {
      const auto& row = rows[i];
      const Pair& pair = results_.pairs[row.pair];
      table.rows.push_back(
          {fmt::format("{}{}, {} taken for {}", results_.pairs.size() > 1 ? pair.test + ", " : "",
                       pair.names[row.image], room(pair.images.rooms[row.image]), room(row.takenFor)),
           {100 * row.wrong / static_cast<double>(cellCount())}});
    }
    return table;
  }

  struct Image {
    std::size_t pair, image;
    double wrong;  // cells
    int takenFor;  // the most frequent wrong answer
  };

  /// Images that any cell was wrong about, the most difficult first.
  std::vector<Image> images() const {
    std::vector<Image> all;
    for (std::size_t p = 0; p < results_.pairs.size(); ++p) {
      const SceneTest& test = results_.pairs[p].images;
      if (!results_.tells(results_.pairs[p])) continue;
      for (std::size_t i = 0; i < test.rooms.size(); ++i) {
        std::vector<double> votes(results_.rooms.size());
        for (std::size_t c = 0; c < cellCount(); ++c)
          for (const auto& seed : cell(p, c).answers)
            votes[static_cast<std::size_t>(seed[i])] += 1 / static_cast<double>(cell(p, c).answers.size());
        votes[static_cast<std::size_t>(test.rooms[i])] = 0;
        const double wrong = std::accumulate(votes.begin(), votes.end(), 0.0);
        if (wrong > 0)
          all.push_back(
              {p, i, wrong, static_cast<int>(std::max_element(votes.begin(), votes.end()) - votes.begin())});
      }
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Image& a, const Image& b) { return a.wrong > b.wrong; });
    return all;
  }

  const std::string& room(int number) const { return results_.rooms[static_cast<std::size_t>(number)]; }

  /// "inception-v3, svm-rbf 76.8 % (95 %: 72.1–80.9; 75.9 once its choice is paid for)".
  std::string told(const std::vector<std::size_t>& cells) const {
    const std::size_t best = cells.front();
    std::string text =
        fmt::format("{} {:.1f} %", nameOf(best), 100 * meanAccuracies(results_, {best}).front());
    std::vector<std::string> more;
    if (results_.pairs.size() == 1) {
      const Share share = shareRight(results_.pairs[0].images, cell(0, best).right(results_.pairs[0].images));
      more.push_back(fmt::format("95 %: {:.1f}–{:.1f}", 100 * share.low, 100 * share.high));
    }
    if (cells.size() > 1)
      more.push_back(fmt::format("{:.1f} % once the choice among {} is paid for",
                                 100 * accuracyOfChoice(results_, cells, choiceSeed), cells.size()));
    if (!more.empty()) text += fmt::format(" ({})", fmt::join(more, "; "));
    return text;
  }

 private:
  /// In percent: of one pair the interval of its accuracy, else the worst and the best pair.
  std::pair<double, double> bounds(std::size_t number) const {
    if (results_.pairs.size() == 1) {
      const SceneTest& images = results_.pairs[0].images;
      const Share share = shareRight(images, cell(0, number).right(images));
      return {100 * share.low, 100 * share.high};
    }
    double low = 100, high = 0;
    for (std::size_t p = 0; p < results_.pairs.size(); ++p) {
      if (!results_.tells(results_.pairs[p])) continue;
      const double value = 100 * cell(p, number).accuracy(results_.pairs[p].images);
      low = std::min(low, value);
      high = std::max(high, value);
    }
    return {low, high};
  }

  const ScenesResults& results_;
};

void addAccuracies(const ScenesResults& results, const Sections& sections, Findings& findings) {
  const auto all = [](const Pair&) { return true; };
  const auto different = [](const Pair& pair) { return !pair.same; };
  const auto same = [](const Pair& pair) { return pair.same; };
  const auto count = [&](const Sections::Which& which) {
    return std::count_if(results.pairs.begin(), results.pairs.end(), which);
  };
  const auto add = [&](const std::string& what, const Sections::Which& which, const std::string& caption) {
    findings.sections.emplace_back(
        sections.byDescriptor("accuracy" + what, caption, &SceneAnswers::accuracy, which));
  };
  findings.sections.emplace_back(sections.best());
  if (results.pairs.size() == 1) {
    const Pair& pair = results.pairs[0];
    add("", all,
        fmt::format("In percent, of {} images in {} runs; learned from {} images.", pair.names.size(),
                    pair.runs.size(), pair.learned));
  } else if (count(same) > 0 && count(different) > 0) {
    add(", different sequences (Fig. 3.8, bottom)", different,
        fmt::format("In percent, the mean over {} pairs of training and test.", count(different)));
    add(", the same sequence (Fig. 3.8, top)", same,
        "In percent: what was learned is asked. It tells how well a classifier remembers, not what it is "
        "worth.");
  } else {
    add("", all,
        fmt::format("In percent, the mean over {} pairs of training and test.", results.pairs.size()));
  }
  std::string last;
  for (const Pair& each : results.pairs)
    if (results.pairs.size() > 1 && each.train != std::exchange(last, each.train))
      findings.sections.emplace_back(sections.byPair(
          "learned from " + each.train + " (Fig. 3.7)",
          [&](const Pair& pair) { return pair.train == each.train; }, &Pair::test));
  findings.sections.emplace_back(sections.byDescriptor(
      "balanced accuracy",
      "In percent: the mean over the rooms of the share of their images that were recognized.",
      &SceneAnswers::balancedAccuracy, [&](const Pair& pair) { return results.tells(pair); }));
}

/// Fig. 3.9 and 3.10: what only shows where a sequence in another building is learned from or asked about.
void addFocus(const ScenesResults& results, Findings& findings) {
  if (results.focus.empty()) return;
  const ScenesResults focused = results.withFocus();
  const Sections sections(focused);
  if (focused.pairs.empty()) {
    findings.notes.push_back("focus: no pair has " + results.focus);
    return;
  }
  for (const bool isTest : {true, false}) {
    const auto which = [&](const Pair& pair) { return (isTest ? pair.test : pair.train) == results.focus; };
    findings.sections.emplace_back(
        sections.byPair(fmt::format("{} {} (Fig. 3.9, {})", isTest ? "asked about" : "learned from",
                                    results.focus, isTest ? "top: by what was learned from" : "bottom"),
                        which, isTest ? &Pair::train : &Pair::test));
  }
  addRankings(focused, results.name + "-focus", findings);
}

}  // namespace

ScenesResults ScenesResults::withFocus() const {
  ScenesResults some = *this;
  some.pairs.clear();
  some.cells.clear();
  some.thesisTables = false;
  some.name = fmt::format("{}, pairs with {}", name, focus);
  const std::size_t each = descriptors.size() * classifiers.size();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (pairs[p].same || (pairs[p].train != focus && pairs[p].test != focus)) continue;
    some.pairs.push_back(pairs[p]);
    const auto begin = cells.begin() + static_cast<std::ptrdiff_t>(p * each);
    some.cells.insert(some.cells.end(), begin, begin + static_cast<std::ptrdiff_t>(each));
  }
  return some;
}

bool ScenesResults::tells(const Pair& pair) const {
  return !pair.same || std::all_of(pairs.begin(), pairs.end(), [](const Pair& other) { return other.same; });
}

Findings findingsOf(const ScenesResults& results) {
  const Sections sections(results);
  Findings findings;
  findings.title = "Which room is this";
  addAccuracies(results, sections, findings);
  addRankings(results, results.name, findings);
  addFocus(results, findings);

  const auto lexical = sections.ranked([](const Descriptor& d) { return d.isLexical && d.parts == 1; });
  const auto together = sections.ranked([](const Descriptor& d) { return d.parts > 1; });
  const auto others = sections.ranked([](const Descriptor& d) { return !d.isLexical && d.parts == 1; });
  std::vector<std::string> told;
  if (!lexical.empty()) told.push_back("labels of one model: " + sections.told(lexical));
  if (!others.empty()) told.push_back("other single descriptors: " + sections.told(others));
  if (!together.empty()) told.push_back("conjunctions: " + sections.told(together));
  findings.summary =
      fmt::format("{}: right answers by the best of {}.", results.name, fmt::join(told, "; of "));
  if (!lexical.empty())
    findings.sections.emplace_back(sections.confusion(lexical.front(), "The best single lexical descriptor"));
  if (!together.empty())
    findings.sections.emplace_back(sections.confusion(together.front(), "The best conjunction"));
  if (!results.curves.empty()) {
    findings.sections.emplace_back(subsetCurve(results));
    findings.sections.emplace_back(subsetTable(results));
    if (const std::string answer = subsetAnswer(results); !answer.empty()) findings.summary += " " + answer;
  }
  findings.sections.emplace_back(sections.hardest());

  for (const Pair& pair : results.pairs)
    findings.facts.emplace_back(fmt::format("{}→{}", pair.train, pair.test),
                                fmt::format("learned from {} images; asked about {} in {} runs", pair.learned,
                                            pair.names.size(), pair.runs.size()));
  return findings;
}

std::string confusionsCsv(const ScenesResults& results) {
  std::string text = "descriptor,classifier,train,test,room,answer,images\n";
  const std::size_t rooms = results.rooms.size();
  for (std::size_t p = 0; p < results.pairs.size(); ++p)
    for (std::size_t d = 0; d < results.descriptors.size(); ++d)
      for (std::size_t c = 0; c < results.classifiers.size(); ++c) {
        const auto counts = results.cell(p, d, c).confusion(results.pairs[p].images);
        for (std::size_t i = 0; i < counts.size(); ++i)
          if (counts[i] > 0)
            text += fmt::format("{},{},{},{},{},{},{}\n", io::csvCell(results.descriptors[d].name),
                                io::csvCell(results.classifiers[c]), io::csvCell(results.pairs[p].train),
                                io::csvCell(results.pairs[p].test), io::csvCell(results.rooms[i / rooms]),
                                io::csvCell(results.rooms[i % rooms]), counts[i]);
      }
  return text;
}

std::string imagesCsv(const ScenesResults& results) {
  const Sections sections(results);
  std::string text = "train,test,image,room,wrong,cells,taken_for\n";
  for (const auto& row : sections.images()) {
    const Pair& pair = results.pairs[row.pair];
    text += fmt::format("{},{},{},{},{},{},{}\n", io::csvCell(pair.train), io::csvCell(pair.test),
                        io::csvCell(pair.names[row.image]),
                        io::csvCell(sections.room(pair.images.rooms[row.image])), row.wrong,
                        sections.cellCount(), io::csvCell(sections.room(row.takenFor)));
  }
  return text;
}

}  // namespace estancia::experiments
