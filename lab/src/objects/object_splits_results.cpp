// SPDX-License-Identifier: Apache-2.0
#include "objects/object_splits_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <set>

#include "estancia/core/label_words.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "findings/pivot.hpp"
#include "findings/thesis.hpp"

namespace estancia::experiments {
namespace {

using Results = ObjectSplitsResults;

constexpr std::size_t maxClasses = 20;  // classes of a confusion matrix …
constexpr std::size_t maxClouds = 24;   // … and objects that have a cloud each

std::string nameOf(PseudoLabeling pseudoLabeling) {
  return pseudoLabelings()[static_cast<std::size_t>(pseudoLabeling)].name;
}

/// Splits that were drawn; all where there is no baseline beside them.
std::size_t firstDrawn(const ObjectTask& task) {
  return task.hasBaseline() && task.splits.size() > 1 ? 1 : 0;
}

/// In percent, of the drawn splits.
std::vector<double> drawn(const Results& results, std::size_t method, std::size_t noise) {
  std::vector<double> values;
  for (std::size_t s = firstDrawn(*results.task); s < results.task->splits.size(); ++s)
    values.push_back(100 * results.accuracy(method, noise, s));
  return values;
}

std::vector<double> drawnLabeled(const Results& results) {
  std::vector<double> values;
  for (std::size_t s = firstDrawn(*results.task); s < results.task->splits.size(); ++s)
    values.push_back(100 * *results.labelerAccuracy(s));
  return values;
}

/// The method that is right most often without noise of ours, on average over the drawn splits.
std::size_t bestMethod(const Results& results) {
  std::size_t best = 0;
  for (std::size_t m = 1; m < results.methods.size(); ++m)
    if (meanOf(drawn(results, m, 0)) > meanOf(drawn(results, best, 0))) best = m;
  return best;
}

/// Under `head` columns of percent, the labeler's, then the methods', which beat it or not; and the rows that
/// labeler() and method(m) give of each of `rows`.
template <class Row, class OfLabeler, class OfMethod>
ResultTable tableOf(const Results& results, ResultTable head,
                    const std::vector<std::pair<std::string, Row>>& rows, const OfLabeler& labeler,
                    const OfMethod& method) {
  std::vector<Measure<Row>> measures;
  const bool asked = !results.labeled.empty();
  if (asked) measures.push_back({{"labeler [%]", 1}, labeler});
  for (std::size_t m = 0; m < results.methods.size(); ++m) {
    measures.push_back(
        {{results.methods[m].name() + " [%]", 1}, [&method, m](const Row& row) { return method(row, m); }});
    if (asked) measures.back().column.beats = 0;
  }
  return pivot<Row>(std::move(head), rows, measures);
}

std::string noiseText(const ObjectTask& task) {
  const double noise = task.data->trials.noises.front();
  return noise > 0 ? fmt::format(", label noise {:g} %", 100 * noise) : "";
}

/// Mean, best and worst; beside the thesis' where it is asked for and the protocol is its.
void addProtocol(const Results& results, Findings& findings) {
  const ObjectTask& task = *results.task;
  using Values = std::vector<double>;
  using Sum = std::function<double(const Values&)>;
  struct Row {
    std::vector<std::size_t> splits;
    Sum sum;
  };
  std::vector<std::size_t> drawnSplits(task.splits.size() - firstDrawn(task));
  std::iota(drawnSplits.begin(), drawnSplits.end(), firstDrawn(task));
  std::vector<std::pair<std::string, Row>> rows;
  if (task.hasBaseline()) rows.emplace_back("baseline", Row{{0}, meanOf});
  if (drawnSplits.size() == 1) rows.emplace_back(task.splits[drawnSplits[0]].name, Row{drawnSplits, meanOf});
  if (drawnSplits.size() > 1) {
    rows.emplace_back(fmt::format("mean of {}", drawnSplits.size()), Row{drawnSplits, meanOf});
    rows.emplace_back("best", Row{drawnSplits, [](const Values& v) { return *std::ranges::max_element(v); }});
    rows.emplace_back("worst",
                      Row{drawnSplits, [](const Values& v) { return *std::ranges::min_element(v); }});
  }
  const auto of = [](const Row& row, const auto& accuracy) {
    Values values;
    for (const std::size_t split : row.splits) values.push_back(100 * accuracy(split));
    return row.sum(values);
  };
  ResultTable table = tableOf<Row>(
      results, {fmt::format("{}: accuracy{}", task.data->name, noiseText(task)), "", "splits", {}, {}}, rows,
      [&](const Row& row) { return of(row, [&](std::size_t s) { return *results.labelerAccuracy(s); }); },
      [&](const Row& row, std::size_t m) {
        return of(row, [&](std::size_t s) { return results.accuracy(m, 0, s); });
      });
  if (results.thesisTables && task.data->split == ObjectSplitsOptions::Split::instances &&
      task.data->machineNames) {
    const ThesisTable thesis = readThesisTable(thesisObjectsCsv, 1);
    table.caption = "Best and worst: of each column by itself. The thesis: other data, as many splits.";
    table.columns.push_back({"thesis: labeler [%]", 1});
    table.columns.push_back({"thesis: classifier [%]", 2});
    for (ResultTable::Row& row : table.rows) {
      const bool named = row.name == "baseline" || row.name == "best" || row.name == "worst";
      const auto printed = std::ranges::find_if(thesis.rows, [&](const auto& known) {
        return known.name().starts_with(named ? row.name : "mean");  // "best (29)": names the split
      });
      row.values.insert(row.values.end(), printed->values.begin(), printed->values.end());
    }
  }
  findings.sections.emplace_back(std::move(table));
}

/// Fig. 6.7; without a labeler beside it there is nothing to see.
void addSplits(const Results& results, Findings& findings) {
  const ObjectTask& task = *results.task;
  if (task.splits.size() < 2 || results.labeled.empty()) return;
  std::vector<std::pair<std::string, std::size_t>> splits;
  for (std::size_t s = 0; s < task.splits.size(); ++s) splits.emplace_back(task.splits[s].name, s);
  findings.sections.emplace_back(tableOf<std::size_t>(
      results,
      {fmt::format("{}: the splits{}", task.data->name, noiseText(task)),
       "Green: shape is right more often than the labeler (Fig. 6.7).",
       "split",
       {},
       {}},
      splits, [&](std::size_t split) { return 100 * *results.labelerAccuracy(split); },
      [&](std::size_t split, std::size_t m) { return 100 * results.accuracy(m, 0, split); }));
}

/// Objects that a split tests, by their names.
std::set<std::string> testedIn(const ObjectTask& task, std::size_t split) {
  std::set<std::string> objects;
  for (const std::size_t sample : task.splits[split].test)
    objects.insert(task.objectNames[static_cast<std::size_t>(task.objects[sample])]);
  return objects;
}

/// The splits, those where the method is worst first; the drawn ones alone, if some were.
std::vector<std::size_t> worstSplits(const Results& results, std::size_t method) {
  const std::size_t first = firstDrawn(*results.task);
  std::vector<std::size_t> splits(results.task->splits.size() - first);
  std::iota(splits.begin(), splits.end(), first);
  std::ranges::stable_sort(splits, {}, [&](std::size_t s) { return results.accuracy(method, 0, s); });
  return splits;
}

/// Which objects each split tests (Table 6.7).
void addTested(const Results& results, Findings& findings) {
  const ObjectTask& task = *results.task;
  if (task.data->split != ObjectSplitsOptions::Split::instances || task.splits.size() < 2) return;
  std::set<std::string> all;
  std::vector<std::set<std::string>> tested;
  for (std::size_t s = 0; s < task.splits.size(); ++s) {
    tested.push_back(testedIn(task, s));
    all.insert(tested.back().begin(), tested.back().end());
  }
  if (all.size() > maxClouds) return;
  const std::vector<std::string> objects(all.begin(), all.end());
  std::vector<std::string> splits;
  for (const ObjectSplit& split : task.splits) splits.push_back(split.name);
  ResultTable table{fmt::format("{}: objects that a split tests", task.data->name),
                    "The others are learned from (Table 6.7).",
                    "split",
                    columnsOf(objects, 0),
                    {}};
  for (ResultTable::Column& column : table.columns) column.form = ResultTable::Form::yesNo;
  findings.sections.emplace_back(pivot(std::move(table), splits, [&](std::size_t split, std::size_t object) {
    return tested[split].contains(objects[object]) ? 1.0 : 0.0;
  }));
}

/// Share of each object's views whose best label is right; absent of an object that no split tests.
std::vector<CellValue> labelerByObject(const Results& results) {
  const ObjectTask& task = *results.task;
  std::vector<double> right(task.objectNames.size()), all(task.objectNames.size());
  for (std::size_t s = 0; s < task.splits.size(); ++s)
    for (std::size_t i = 0; i < task.splits[s].test.size(); ++i) {
      const std::size_t sample = task.splits[s].test[i];
      const auto object = static_cast<std::size_t>(task.objects[sample]);
      ++all[object];
      right[object] += results.labeled[s][i] == task.classes[sample] ? 1 : 0;
    }
  std::vector<CellValue> shares(all.size());
  for (std::size_t o = 0; o < all.size(); ++o)
    if (all[o] > 0) shares[o] = right[o] / all[o];
  return shares;
}

/// How often the labeler names each object rightly (Fig. 6.5), by which the baseline is chosen.
void addInstances(const Results& results, Findings& findings) {
  const ObjectTask& task = *results.task;
  if (results.labeled.empty() || task.objectNames.size() > maxClouds) return;
  ResultTable table{fmt::format("{}: the labeler, object by object", task.data->name),
                    "Share of the views whose best label is right (Fig. 6.5).",
                    "object",
                    {{"top-1 [%]", 1}},
                    {}};
  const auto shares = labelerByObject(results);
  for (std::size_t o = 0; o < shares.size(); ++o)
    if (shares[o]) table.rows.push_back({task.objectNames[o], {100 * *shares[o]}});
  findings.sections.emplace_back(std::move(table));
}

/// The objects that the labeler knows worst, and which of the worst splits learn from them (Table 6.8).
void addWorst(const Results& results, Findings& findings) {
  const ObjectTask& task = *results.task;
  if (task.data->split != ObjectSplitsOptions::Split::instances || task.splits.size() < 2) return;
  if (results.labeled.empty() || task.objectNames.size() > maxClouds) return;
  const auto shares = labelerByObject(results);
  auto objects = ascending(shares.size(), [&](std::size_t o) { return shares[o].value_or(2); });
  objects.resize(std::min<std::size_t>(objects.size(), 3));
  // The thesis learns from the labels as they come.
  const auto top =
      std::ranges::find(results.methods, PseudoLabeling::top, [](const auto& m) { return m.pseudoLabeling; });
  const auto method = top == results.methods.end() ? bestMethod(results)
                                                   : static_cast<std::size_t>(top - results.methods.begin());
  auto splits = worstSplits(results, method);
  splits.resize(std::min<std::size_t>(splits.size(), 5));

  ResultTable table{fmt::format("{}: objects that the labeler knows worst", task.data->name),
                    fmt::format("Whether they are learned from in the {} worst splits of {} (Table 6.8).",
                                splits.size(), results.methods[method].name()),
                    "object",
                    {{"top-1 [%]", 1}},
                    {}};
  std::vector<std::set<std::string>> tested;
  for (const std::size_t s : splits) {
    tested.push_back(testedIn(task, s));
    const double percent = 100 * results.accuracy(method, 0, s);
    ResultTable::Column column{fmt::format("{}, {:.1f} %", task.splits[s].name, percent), 0};
    column.form = ResultTable::Form::yesNo;
    table.columns.push_back(column);
  }
  std::vector<std::string> names;
  for (const std::size_t o : objects) names.push_back(task.objectNames[o]);
  findings.sections.emplace_back(
      pivot(std::move(table), names, [&](std::size_t object, std::size_t column) -> CellValue {
        if (column > 0) return tested[column - 1].contains(names[object]) ? 0.0 : 1.0;
        const CellValue share = shares[objects[object]];
        return share ? CellValue(100 * *share) : std::nullopt;
      }));
}

void addNoise(const Results& results, Findings& findings) {
  const ObjectTask& task = *results.task;
  const auto& noises = task.data->trials.noises;
  if (noises.size() < 2) return;
  const std::string title = fmt::format("{}: label noise", task.data->name);
  std::vector<std::string> rows, methods;
  for (const double noise : noises) rows.push_back(fmt::format("{:g} %", 100 * noise));
  for (const ObjectMethod& method : results.methods) methods.push_back(method.name());
  std::vector<std::string> columns;
  for (const std::string& method : methods) columns.push_back(method + " [%]");
  const ResultTable table = pivot(
      {title,
       fmt::format("Mean over {} splits; names of training samples swapped on purpose, {}.",
                   task.splits.size() - firstDrawn(task),
                   task.data->noise == NoiseKind::view   ? "view by view"
                   : task.data->noise == NoiseKind::pair ? "view by view, always for the next class"
                                                         : "all views of an object alike"),
       "label noise",
       columnsOf(columns, 1),
       {}},
      rows, [&](std::size_t noise, std::size_t method) { return meanOf(drawn(results, method, noise)); });
  findings.sections.emplace_back(table);
  if (!std::is_sorted(noises.begin(), noises.end())) return;
  LineChart chart{title, "", "label noise [%]", "accuracy [%]", false, {}, {}, true};
  for (const double noise : noises) chart.x.push_back(100 * noise);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    chart.lines.push_back({methods[m], {}});
    for (const auto& row : table.rows) chart.lines.back().y.push_back(*row.values[m]);
  }
  findings.sections.emplace_back(std::move(chart));
}

/// Rows of a confusion in percent.
HeatTable matrixOf(const ObjectTask& task, const std::string& title, std::vector<double> counts) {
  const std::size_t classes = task.targets.classes.size();
  for (std::size_t r = 0; r < classes; ++r) {
    const auto row = counts.begin() + static_cast<std::ptrdiff_t>(r * classes);
    const auto end = row + static_cast<std::ptrdiff_t>(classes);
    const double all = std::accumulate(row, end, 0.0);
    std::transform(row, end, row, [all](double n) {
      return all > 0 ? 100 * n / all : std::numeric_limits<double>::quiet_NaN();
    });
  }
  return {title, "Share of a true class's views (row) by what they are taken for (column) [%]",
          task.targets.names(), std::move(counts), 0};
}

/// Fig. 6.6, of the baseline or the first split.
void addConfusions(const Results& results, Findings& findings) {
  const ObjectTask& task = *results.task;
  const std::size_t classes = task.targets.classes.size();
  const bool one = task.data->split == ObjectSplitsOptions::Split::instances && !task.hasBaseline();
  if (classes > maxClasses || one) return;  // one of many splits by chance is no evidence
  const std::string where = fmt::format("{}, {}", task.data->name, task.splits[0].name);
  const auto add = [&](const std::string& who, std::vector<double> counts) {
    findings.sections.emplace_back(matrixOf(task, fmt::format("{}: {}", where, who), std::move(counts)));
  };
  const SceneTest test = testOf(task, task.splits[0]);
  const auto addConfusion = [&](const std::string& who, const std::vector<std::size_t>& samples,
                                const std::vector<int>& answers) {
    std::vector<double> counts(classes * classes);
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (answers[i] >= 0)
        counts[static_cast<std::size_t>(task.classes[samples[i]]) * classes +
               static_cast<std::size_t>(answers[i])] += 1;
    add(who, std::move(counts));
  };
  if (task.data->machineNames)
    addConfusion("names learned from (top)", task.splits[0].train, results.learnedFrom);
  if (!results.labeled.empty()) addConfusion("labeler", task.splits[0].test, results.labeled[0]);
  const std::size_t shown = task.data->machineNames ? results.methods.size() : 1;
  for (std::size_t m = 0; m < shown; ++m)
    add(results.methods[m].name(), results.cells[results.indexOf(m, 0, 0)].answers.confusion(test));
}

/// Fig. 6.3: of each object, or of each class where there are many objects.
void addClouds(const Results& results, Findings& findings) {
  const ObjectTask& task = *results.task;
  if (!task.labels || !task.data->machineNames) return;
  const bool byObject = task.objectNames.size() <= maxClouds;
  WordClouds clouds{fmt::format("What the labeler says of each {}", byObject ? "object" : "class"),
                    "Mean of all its labels, not only the study's (Fig. 6.3).",
                    {}};
  for (const auto& known : findings.sections)
    if (const auto* other = std::get_if<WordClouds>(&known); other != nullptr && other->title == clouds.title)
      return;
  const auto& of = byObject ? task.objects : task.classes;
  const auto names = byObject ? task.objectNames : task.targets.names();
  const std::size_t labels = task.labels->vocabulary.size();
  for (std::size_t t = 0; t < names.size(); ++t) {
    std::vector<double> sum(labels);
    std::size_t count = 0;
    for (std::size_t i = 0; i < of.size(); ++i) {
      if (of[i] != static_cast<int>(t)) continue;
      const auto row = task.labels->descriptors.row(i);
      for (std::size_t l = 0; l < labels; ++l) sum[l] += row[l];
      ++count;
    }
    if (count == 0) continue;
    const std::vector<float> means(sum.begin(), sum.end());
    WordClouds::Cloud cloud{names[t], {}};
    if (byObject)
      cloud.name +=
          fmt::format(" ({})", task.targets.classes[static_cast<std::size_t>(task.classOfObject[t])].name);
    for (const std::size_t l : bestLabels(means, 20))
      if (const double weight = sum[l] / static_cast<double>(count); weight > 1e-3)
        cloud.words.emplace_back(shortLabel(task.labels->vocabulary[l]), weight);
    clouds.clouds.push_back(std::move(cloud));
  }
  findings.sections.emplace_back(std::move(clouds));
}

/// Where shape is right and the labeler wrong (Tables 6.3, 6.5), or the reverse (6.4, 6.6): one of each
/// class, then more.
Images examples(const Results& results, std::size_t splitIndex, std::size_t method, bool success) {
  constexpr std::size_t most = 6;
  constexpr int side = 192;
  const ObjectTask& task = *results.task;
  const ObjectSplit& split = task.splits[splitIndex];
  const std::vector<int>& labeled = results.labeled[splitIndex];
  const auto& answers = results.cells[results.indexOf(method, 0, splitIndex)].answers.answers[0];
  const auto name = [&](int index) {
    return index < 0 ? std::string("nothing") : task.targets.classes[static_cast<std::size_t>(index)].name;
  };
  Images images{
      fmt::format("{}, {}: {}", task.data->name, split.name,
                  success ? "shape is right, the labeler wrong" : "the labeler is right, shape wrong"),
      "",
      {}};
  std::vector<std::size_t> wanted;
  std::set<int> objects;
  for (std::size_t i = 0; i < split.test.size(); ++i) {
    const int truth = task.classes[split.test[i]];
    if ((answers[i] == truth) == success && (labeled[i] == truth) != success &&
        objects.insert(task.objects[split.test[i]]).second)
      wanted.push_back(i);
  }
  // Spread over all of them, where there are many objects.
  const std::size_t count = std::min(most, wanted.size());
  const auto patches = cropsOf(*task.views);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = wanted[k * wanted.size() / count], sample = split.test[i];
    images.images.push_back({encodeImage(patches->image(task.view[sample]), side),
                             fmt::format("{}: {}; labeler {}, shape {}",
                                         task.objectNames[static_cast<std::size_t>(task.objects[sample])],
                                         name(task.classes[sample]), name(labeled[i]), name(answers[i]))});
  }
  return images;
}

void addExamples(const Results& results, Findings& findings) {
  if (results.labeled.empty() || !results.task->data->machineNames) return;
  const std::size_t method = bestMethod(results);
  for (const std::size_t split : std::set{std::size_t{0}, worstSplits(results, method).front()})
    for (const bool success : {true, false})
      if (Images images = examples(results, split, method, success); !images.images.empty())
        findings.sections.emplace_back(std::move(images));
}

}  // namespace

std::string ObjectMethod::name() const {
  return classifier + " " + nameOf(pseudoLabeling);
}

std::vector<ObjectMethod> methodsOf(const ObjectSplitsOptions::Trials& trials) {
  std::vector<ObjectMethod> methods;
  for (const std::string& classifier : trials.classifiers)
    for (const PseudoLabeling pseudoLabeling : trials.pseudoLabelings)
      methods.push_back({classifier, pseudoLabeling});
  return methods;
}

std::optional<double> ObjectSplitsResults::labelerAccuracy(std::size_t split) const {
  if (labeled.empty()) return std::nullopt;
  const auto& test = task->splits[split].test;
  std::size_t right = 0;
  for (std::size_t i = 0; i < test.size(); ++i) right += labeled[split][i] == task->classes[test[i]];
  return static_cast<double>(right) / static_cast<double>(test.size());
}

SceneTest testOf(const ObjectTask& task, const ObjectSplit& split) {
  SceneTest test;
  test.roomCount = static_cast<int>(task.targets.classes.size());
  std::vector<int> objects;
  for (const std::size_t i : split.test) {
    test.rooms.push_back(task.classes[i]);
    const auto known = std::find(objects.begin(), objects.end(), task.objects[i]);
    test.runs.push_back(static_cast<int>(known - objects.begin()));
    if (known == objects.end()) objects.push_back(task.objects[i]);
  }
  test.runCount = static_cast<int>(objects.size());
  return test;
}

void addFindings(const ObjectSplitsResults& results, Findings& findings) {
  addProtocol(results, findings);
  addNoise(results, findings);
  addSplits(results, findings);
  addTested(results, findings);
  addInstances(results, findings);
  addWorst(results, findings);
  addConfusions(results, findings);
  addExamples(results, findings);
  addClouds(results, findings);
}

std::string summaryOf(const ObjectSplitsResults& results) {
  const std::size_t best = bestMethod(results);
  std::string text = fmt::format("{}: {} is right about {:.1f} %", results.task->data->name,
                                 results.methods[best].name(), meanOf(drawn(results, best, 0)));
  if (!results.labeled.empty())
    text += fmt::format(", the labeler about {:.1f} %", meanOf(drawnLabeled(results)));
  return text + ".";
}

}  // namespace estancia::experiments
