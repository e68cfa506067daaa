// SPDX-License-Identifier: Apache-2.0
#include "words/few_examples.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "estancia/classify/predict_rooms.hpp"
#include "estancia/classify/zero_shot_rooms.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/word_graph.hpp"
#include "findings/pivot.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

constexpr int fewExamplesVersion = 1;  // version of the code below: cells of another one are computed anew

const std::vector<std::string> waysToTell{"examples", "names", "both"};

/// Rows of the images in each room, in a random order.
std::map<std::string, std::vector<std::size_t>> shuffledRooms(const std::vector<Frame>& frames,
                                                              const std::vector<std::string>& rooms,
                                                              std::uint64_t seed) {
  std::map<std::string, std::vector<std::size_t>> shuffled;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (std::ranges::find(rooms, frames[i].room) != rooms.end()) shuffled[frames[i].room].push_back(i);
  std::mt19937_64 random(seed);
  for (const std::string& room : rooms)
    for (std::size_t i = shuffled[room].size(); i > 1; --i)
      // deterministic with any standard library
      std::swap(shuffled[room][i - 1], shuffled[room][random() % i]);
  return shuffled;
}

struct Draw {
  std::vector<std::size_t> examples;
  /// Images in the rooms that are no examples.
  std::vector<std::size_t> others;
};

Draw drawExamples(const std::vector<Frame>& frames, const std::vector<std::string>& rooms, std::size_t count,
                  std::uint64_t seed) {
  Draw draw;
  for (const auto& [room, rows] : shuffledRooms(frames, rooms, seed)) {
    if (rows.size() <= count)
      throw Error(ErrorCode::insufficientData,
                  fmt::format("{} images of {} are too few to draw {} examples", rows.size(), room, count));
    const auto end = rows.begin() + static_cast<std::ptrdiff_t>(count);
    draw.examples.insert(draw.examples.end(), rows.begin(), end);
    draw.others.insert(draw.others.end(), end, rows.end());
  }
  std::ranges::sort(draw.examples);
  std::ranges::sort(draw.others);
  return draw;
}

/// Accuracy and log loss [nats]; a probability below 0.001 counts as 0.001.
void addScores(const RoomPredictions& predictions, const std::vector<Frame>& frames, const std::string& by,
               std::map<std::pair<std::string, std::string>, double>& sums) {
  double right = 0, loss = 0;
  for (std::size_t i = 0; i < frames.size(); ++i)
    for (const auto& [room, probability] : rankedRooms(predictions, i)) {
      if (room != frames[i].room) continue;
      loss -= std::log(std::max(probability, 1e-3));
      right += rankedRooms(predictions, i).front().room == room ? 1 : 0;
    }
  const double n = static_cast<double>(frames.size());
  sums[{"accuracy", by}] += right / n;
  sums[{"log_loss", by}] += loss / n;
}

CellResults learnAndTest(const FewExamplesOptions& options, const WordGraph& graph,
                         const LabeledDrive& training, const LabeledDrive& test, std::size_t count) {
  const Features known = featuresOf(training.recording), asked = featuresOf(test.recording);
  const bool isSame = &training == &test;
  std::map<std::pair<std::string, std::string>, double> sums;
  for (int d = 0; d < options.draws; ++d) {
    const auto seed = static_cast<std::uint64_t>(d) + 1;
    const Draw draw = drawExamples(training.recording.frames, options.rooms, count, seed);
    const RoomClassifier classifier = trainRoomClassifier(
        withRows(known, draw.examples), {.type = options.classifier, .seed = seed, .threads = 1});
    const Features images =
        withRows(asked, isSame ? draw.others : drawExamples(asked.frames, options.rooms, 0, seed).others);
    const RoomPredictions learned = predictRooms(classifier, images, images.frames, 1);
    const RoomPredictions named =
        predictRoomsByNames(graph, test.recording.vocabulary, images.values, classifier.rooms());
    addScores(learned, images.frames, waysToTell[0], sums);
    addScores(named, images.frames, waysToTell[1], sums);
    addScores(withNames(learned, named, shareOfNames(static_cast<double>(count))), images.frames,
              waysToTell[2], sums);
  }
  CellResults results;
  for (const auto& [measure, sum] : sums)
    results.push_back({measure.first, measure.second, sum / options.draws});
  return results;
}

}  // namespace

FewExamplesOptions readFewExamples(ConfigFile& config) {
  FewExamplesOptions options;
  const toml::array* data = nullptr;
  const auto text = [&config](const toml::node& node) { return config.text(node); };
  const auto number = [&config](const toml::node& node) {
    return static_cast<std::size_t>(config.integer(node, 2, 100000));
  };
  const auto classifier = oneOf(config, classifierTypes());
  config.read({{"type", true, "the kind of experiment", [](auto&) {}},
               {"models", false, "the models whose labels tell", each(config, options.models, text)},
               {"rooms", true, "the rooms to tell apart", each(config, options.rooms, text)},
               {"images", false, "examples of each room", each(config, options.images, number)},
               {"draws", false, "random draws of examples",
                [&](auto& n) { options.draws = static_cast<int>(config.integer(n, 1, 1000)); }},
               {"classifier", false, "that learns", [&](auto& n) { options.classifier = classifier(n); }},
               {"train", true, "the data that examples are drawn from",
                [&](auto& n) { options.train = config.text(n); }},
               {"data", true, "[[data]] names images with rooms", [&](auto& n) { data = &config.list(n); }}});
  for (const toml::node& node : *data)
    options.drives.push_back(readNamedDrive(config, config.subtable(node)));
  if (std::ranges::find(options.drives, options.train, &NamedDrive::name) == options.drives.end())
    config.fail(data->front(), fmt::format("no [[data]] is called {}, which `train` names", options.train));
  return options;
}

GridColumns fewExamplesColumns() {
  return {{"model", "data", "images"}, "by", {"accuracy", "log_loss"}};
}

Findings learnFromFew(const FewExamplesOptions& options, Grid& grid, const ExperimentRun& run,
                      Progress& progress) {
  const WordGraph* graph = installedWordGraph();
  if (graph == nullptr) throw Error(ErrorCode::missingDependency, wordNetHint());
  std::vector<std::string> counts;
  for (const std::size_t count : options.images) counts.push_back(std::to_string(count));
  const NamedDrive& training = *std::ranges::find(options.drives, options.train, &NamedDrive::name);
  const auto inputs = [&](const NamedDrive&, std::size_t) {
    return fmt::format("{} {} {} {} {} {}", fewExamplesVersion, fmt::join(options.rooms, ","), options.draws,
                       options.classifier, options.train, graph->degreeSum);
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& drive, std::size_t variant) {
    return learnAndTest(options, *graph, labeled.of(training.images), labeled.of(drive.images),
                        options.images[variant]);
  };
  return studyDrives({options.models, options.drives, counts, inputs, compute}, fewExamplesFindings, grid,
                     run, progress);
}

Findings fewExamplesFindings(const DriveResults& results) {
  Findings findings;
  findings.title = "Rooms from a few examples and their names";
  double without = 0, with = 0;
  results.each([&](std::size_t model, std::size_t drive) {
    for (const std::string measure : {"accuracy", "log_loss"}) {
      const bool isAccuracy = measure == "accuracy";
      ResultTable head{
          fmt::format("{}: {}", results.titleOf(model, drive), isAccuracy ? "accuracy" : "log loss"),
          "By a classifier that is trained on so many images of each room, by the rooms' names "
          "alone, and by both; means over the draws.",
          "images a room",
          columnsOf(waysToTell, 3, isAccuracy ? ResultTable::Best::largest : ResultTable::Best::smallest),
          {}};
      findings.sections.emplace_back(
          pivot(std::move(head), results.variants, [&](std::size_t count, std::size_t way) {
            return valueOf(results.of(model, drive, count), measure, waysToTell[way]);
          }));
    }
    without += valueOf(results.of(model, drive), "accuracy", waysToTell[0]).value_or(0);
    with += valueOf(results.of(model, drive), "accuracy", waysToTell[2]).value_or(0);
  });
  const double cells = static_cast<double>(results.models.size() * results.drives.size());
  findings.summary = fmt::format(
      "{} images of each room name {:.1f} % of the others right, and {:.1f} % with the rooms' names.",
      results.variants.front(), 100 * without / cells, 100 * with / cells);
  return findings;
}

}  // namespace estancia::experiments
