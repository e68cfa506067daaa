// The tables, figures and sentences that each experiment makes of made-up cells, as a whole.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "estancia/stats/linkage.hpp"
#include "estancia/zones/zones.hpp"
#include "features/feature_study.hpp"
#include "objects/object_segmentation_findings.hpp"
#include "objects/object_splits_results.hpp"
#include "odometry/odometry_errors.hpp"
#include "places/further_drives.hpp"
#include "places/localization_errors.hpp"
#include "places/model_choice_findings.hpp"
#include "places/revisits.hpp"
#include "places/room_agreement.hpp"
#include "places/word_positions.hpp"
#include "recognition/recognition_findings.hpp"
#include "scenes/scenes_findings.hpp"
#include "support/golden_findings.hpp"
#include "words/few_examples.hpp"
#include "words/rooms_by_name.hpp"
#include "words/words_experiment.hpp"
#include "zones/category_spread.hpp"
#include "zones/zone_tables_findings.hpp"

namespace estancia::experiments {
namespace {

/// Equal numbers in [0, 1) in every run of a test, all different.
class Numbers {
 public:
  double next() { return static_cast<double>(state_ = (state_ * 421 + 1663) % 7875) / 7875; }
  std::size_t below(std::size_t end) { return static_cast<std::size_t>(next() * static_cast<double>(end)); }

 private:
  std::size_t state_ = 5;
};

RecognitionResults recognitionResults() {
  Numbers numbers;
  RecognitionResults results;
  results.presets = {"default", "thesis"};
  results.keypoints = {"uniform", "iss"};
  results.descriptors = {"shot", "esf"};
  results.modelFilters = {"none", "gng"};
  results.sceneFilters = {{"none", 0}, {"gng", 10000}, {"gng", 20000}};
  results.noises = {0.005, 0, 0.01};
  results.cells.resize(results.indexOf(2, 0, 0, 0, 0, 0));
  for (RecognitionCell& cell : results.cells) {
    cell.seeds = 1;
    cell.pairs = 49;
    cell.absent = 20;
    cell.verified = numbers.below(50);
    cell.correct = numbers.below(cell.verified + 1);
    cell.falsePositives = numbers.below(21);
    cell.failed = numbers.below(3);
    cell.seconds = numbers.next();
  }
  results.thesisTables = true;
  results.failures = {{"flat", "mug in hall", 3},
                      {"empty", "pan in hall", 5},
                      {"far", "mug in lab", 2},
                      {"near", "pan in lab", 1}};
  return results;
}

TEST(Golden, Recognition) {
  test::expectGolden("recognition", findingsOf(recognitionResults()));
}

TEST(Golden, RecognitionOfOneDescriptorAtOneNoise) {
  RecognitionResults results = recognitionResults();
  results.presets = {"default"};
  results.keypoints = {"uniform"};
  results.descriptors = {"shot"};
  results.noises = {0.005};
  results.cells.resize(results.indexOf(1, 0, 0, 0, 0, 0));
  results.failures.clear();
  test::expectGolden("recognition-one", findingsOf(results));
}

ZoneTablesResults zoneResults() {
  Numbers numbers;
  ZoneTablesResults results;
  results.data = {{"tour", 90, {"hall", "lab"}, 4, {"hall 1", "hall 2", "lab 1"}, {}},
                  {"nyu", 40, {"bath", "den"}, 2, {"bath", "den"}, {}}};
  for (auto& data : results.data)
    for (const char* distance : {"jensen-shannon", "ks"}) {
      ClassMatrix matrix{distance, distance == std::string_view("ks"), {}};
      for (std::size_t i = 0; i < data.matrixNames.size() * data.matrixNames.size(); ++i)
        matrix.values.push_back(i == 1 ? NAN : numbers.next());
      data.matrices.push_back(matrix);
    }
  const std::vector<std::string> classes{"hall 1", "hall 1", "hall 2", "lab 1"};
  results.data[0].histograms =
      classHistograms(std::vector{3, 4, 4, 4}, classes, {"over zones", "", "class", {}, {}});
  results.models = {"places", "imagenet"};
  results.distances = {ZoneOptions{}.distance, "ks", ZoneOptions::thesis().distance};
  results.linkages = {ZoneOptions{}.linkage, "average"};
  results.cuts = {"0.2", "0.5", "0.9", "auto", "best"};
  results.thesisTables = true;
  for (std::size_t i = 0; i < 2U * 2 * 3 * 2; ++i) {
    if (i % 6 == 2) {  // the two do not go together
      results.cells.emplace_back();
      continue;
    }
    ZoneCell cell;
    for (int k = 0; k < 12; ++k) cell.vMeasures.push_back(numbers.next());
    for (const std::string& cut : results.cuts) {
      ZoneReading reading{cut, 1 + numbers.below(14), numbers.next(), numbers.next(), numbers.next(), {}, {}};
      if (i < 12) {
        reading.m = numbers.next();
        reading.within = {{"hall 1 · hall 2", numbers.next()}, {"lab 1 · lab 2", numbers.next()}};
      }
      cell.readings.push_back(reading);
    }
    results.cells.emplace_back(cell);
  }
  return results;
}

TEST(Golden, Zones) {
  test::expectGolden("zones", findingsOf(zoneResults()));
}

TEST(Golden, ZonesWithoutTheDefault) {
  ZoneTablesResults results = zoneResults();
  results.data.resize(1);
  results.models = {"places"};
  results.distances = {"ks"};
  results.linkages = {"average"};
  results.cuts = {"auto", "best"};
  results.cells.resize(1);
  test::expectGolden("zones-few", findingsOf(results));
}

/// Two sequences and two rooms, each asked by the other; `pairs` of them.
ScenesResults sceneResults(std::size_t pairs) {
  Numbers numbers;
  ScenesResults results;
  results.name = "study";
  results.thesisTables = true;
  results.rooms = {"hall", "lab", "shop"};
  const std::vector<std::string> names{"day", "night", "dusk"};
  for (std::size_t p = 0; p < pairs; ++p) {
    ScenesResults::Pair pair{
        names[p / 3 % 3], names[p % 3], {}, {}, {}, 20 + p, p / 3 % 3 == p % 3 && pairs > 2};
    pair.images.roomCount = 3;
    pair.images.runCount = 4;
    pair.runs = {"hall 1", "hall 2", "lab 1", "shop 1"};
    for (int i = 0; i < 16; ++i) {
      pair.images.runs.push_back(i / 4);
      pair.images.rooms.push_back(i < 8 ? 0 : i / 4 - 1);
      pair.names.push_back(fmt::format("{:02}.png", i));
    }
    results.pairs.push_back(pair);
  }
  results.descriptors = {{"places", true, 1}, {"gist", false, 1}, {"places+gist", false, 2}};
  results.classifiers = {"svm-rbf", "knn"};
  const auto answers = [&](const SceneTest& test, double right) {
    SceneAnswers found;
    for (int seed = 0; seed < 2; ++seed) {
      auto& said = found.answers.emplace_back();
      for (const int room : test.rooms)
        said.push_back(numbers.next() < right ? room : static_cast<int>(numbers.below(3)));
    }
    return found;
  };
  for (const auto& pair : results.pairs)
    for (std::size_t cell = 0; cell < 6; ++cell)
      results.cells.push_back(answers(pair.images, 0.3 + 0.1 * static_cast<double>(cell)));
  results.curveDescriptor = "places";
  results.curveClassifier = "svm-rbf";
  results.counts = {10, 75, 365};
  results.labels = 365;
  for (const char* rule : {"mean", "chi2"}) {
    ScenesResults::Curve curve{rule, {}};
    for (std::size_t k = 0; k < results.counts.size(); ++k) {
      auto& all = curve.answers.emplace_back();
      for (const auto& pair : results.pairs) all.push_back(answers(pair.images, 0.5));
    }
    results.curves.push_back(curve);
  }
  return results;
}

TEST(Golden, ScenesOfOnePair) {
  test::expectGolden("scenes-one", findingsOf(sceneResults(1)));
}

TEST(Golden, ScenesOfTwoPairs) {
  test::expectGolden("scenes-two", findingsOf(sceneResults(2)));
}

TEST(Golden, ScenesOfManyPairs) {
  ScenesResults results = sceneResults(9);
  results.focus = "dusk";
  test::expectGolden("scenes-many", findingsOf(results));
}

ModelChoiceResults choiceResults(std::size_t drives) {
  Numbers numbers;
  ModelChoiceResults results;
  results.models = {"places", "imagenet", "clip"};
  results.distances = {"l2", "hellinger"};
  const std::vector<ModelChoiceResults::Drive> all{
      {"tour", 120, 2.5, true}, {"idol", 80, 0.75, false}, {"single", 30, 1, false}};
  results.drives.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(drives));
  for (std::size_t i = 0; i < 2 * drives * 3; ++i) {
    ModelChoiceCell cell;
    for (int k = 0; k < 9; ++k)
      cell.variance.push_back({k == 0 ? 12.5 : 12 * numbers.next(), k == 0 ? 12.5 : numbers.next()});
    const bool seenTwice = i / 3 % drives != 2;
    cell.recognition = {seenTwice ? 40U : 0U, seenTwice ? numbers.next() : 0, seenTwice ? 0.125 : 0};
    results.cells.push_back(cell);
  }
  return results;
}

TEST(Golden, ModelChoice) {
  test::expectGolden("model-choice", findingsOf(choiceResults(3), {2, 5, 50}));
}

TEST(Golden, ModelChoiceOnOneDrive) {
  test::expectGolden("model-choice-one", findingsOf(choiceResults(1), {4}));
}

TEST(Golden, ObjectSegmentation) {
  const SegmentationMeasures good{{0.9, 0.8, 0.85}, {0.75, 0.5, 0.6}, 1}, bad{{0.5, 0.25, 0.3}, {0, 0, 0}, 0};
  std::vector<SegmentedScene> scenes{
      {"a", "boxes", {4, 3, 1, 0, 2.75}, {4, 2, 0, 2, 2.125}, good, bad, 1, 4, 1},
      {"b", "cups", {3, 3, 0, 0, 2.5}, {3, 1, 1, 1, 1.5}, good, good, 1, 2, 0},
      {"c", "boxes", {2, 1, 0, 1, 1.25}, {2, 2, 0, 0, 1.75}, bad, bad, 1, 2, 0},
      {"d", "empty", {0, 0, 0, 0, 0}, {0, 0, 0, 0, 0}, good, good, 1, 0, 0}};
  test::expectGolden("object-segmentation", findingsOf(scenes));
}

/// Two words of two things each, six samples of each thing; the first split is the baseline.
struct Splits {
  ObjectSplitsOptions::Data data;
  ObjectTask task{nullptr, {}, nullptr, {}, {{}, {}, DescriptorMatrix(1)}, {}, {}, {}, {}, {}, {}, {}, ""};
  ObjectSplitsResults results;

  explicit Splits(bool labeler) {
    Numbers numbers;
    data.name = "shop";
    data.machineNames = labeler;
    data.trials.pseudoLabelings = {PseudoLabeling::top, PseudoLabeling::voted};
    data.trials.noises = {0, 0.25};
    task.data = &data;
    task.targets = targetClassesOf({"cup", "box"});
    task.objectNames = {"cup 0", "cup 1", "box 0", "box 1"};
    task.classOfObject = {0, 0, 1, 1};
    for (int i = 0; i < 24; ++i) {
      task.objects.push_back(i / 6);
      task.groups.push_back(i / 3);
      task.classes.push_back(i / 12);
    }
    for (const char* name : {"baseline", "1", "2", "3"}) {
      ObjectSplit split{name, {}, {}};
      const int cup = static_cast<int>(numbers.below(2)), box = 2 + static_cast<int>(numbers.below(2));
      for (std::size_t i = 0; i < 24; ++i)
        (task.objects[i] == cup || task.objects[i] == box ? split.test : split.train).push_back(i);
      task.splits.push_back(split);
    }
    results.task = &task;
    results.thesisTables = true;
    results.methods = methodsOf(data.trials);
    for (std::size_t i = 0; i < results.methods.size() * 2 * task.splits.size(); ++i) {
      const ObjectSplit& split = task.splits[i % task.splits.size()];
      ObjectAnswers cell;
      auto& said = cell.answers.answers.emplace_back();
      for (const std::size_t sample : split.test)
        said.push_back(numbers.next() < 0.8 ? task.classes[sample] : 1 - task.classes[sample]);
      cell.accuracy = cell.answers.accuracy(testOf(task, split));
      results.cells.push_back(cell);
    }
    if (!labeler) {  // labels to compare with, not to learn from
      for (const ObjectSplit& split : task.splits) {
        auto& said = results.labeled.emplace_back();
        for (const std::size_t sample : split.test)
          said.push_back(numbers.next() < 0.6 ? task.classes[sample]
                                              : static_cast<int>(numbers.below(3)) - 1);
      }
      return;
    }
    ObjectLabels answers{
        "labeler", Vocabulary({"cup", "box", "cat"}), DescriptorMatrix(3), {DescriptorMatrix(2), {}}};
    for (std::size_t i = 0; i < 24; ++i) {
      const auto cup = static_cast<float>(numbers.next()), box = 1 - cup;
      answers.descriptors.append(std::vector<float>{cup / 2, box / 2, 0.5F});
      answers.restricted.probabilities.append(std::vector<float>{cup, box});
      answers.restricted.coverage.push_back(0.5F);
    }
    task.labels = answers;
    for (const std::size_t sample : task.splits[0].train)
      results.learnedFrom.push_back(numbers.next() < 0.7 ? task.classes[sample] : -1);
  }
};

Findings findingsOfSplits(const Splits& splits) {
  Findings findings;
  findings.summary = summaryOf(splits.results);
  addFindings(splits.results, findings);
  return findings;
}

TEST(Golden, ObjectSplitsNamedByALabeler) {
  test::expectGolden("object-splits-labeler", findingsOfSplits(Splits(true)));
}

TEST(Golden, ObjectSplitsNamedByPeople) {
  test::expectGolden("object-splits-true", findingsOfSplits(Splits(false)));
}

CellResults someOf(Numbers& numbers, const std::vector<std::string>& measures, const std::string& at = "") {
  CellResults results;
  for (const std::string& measure : measures) results.push_back({measure, at, numbers.next()});
  return results;
}

TEST(Golden, RoomAgreement) {
  Numbers numbers;
  DriveResults results{{"places", "imagenet"}, {"day", "night"}, {"places", "rooms"}, {}};
  results.cells.resize(8);
  auto measures = roomAgreementColumns().measures;
  for (int i = 0; i < 8; ++i) {
    const int method = i / 4, drive = i / 2 % 2, model = i % 2;
    results.cells[4 * model + 2 * drive + method] = someOf(numbers, measures);
    if (i == 4) measures.erase(measures.begin() + 7, measures.end());  // a drive without a home.json
  }
  test::expectGolden("room-agreement", roomAgreementFindings(results));
}

TEST(Golden, Features) {
  Numbers numbers;
  FeatureResults results{
      {"words", "orb-words"}, {"standardized-clr", "l2"}, {{"tour"}, {"rooms", false}}, {}};
  std::vector<std::string> measures;
  for (const auto& measure : featureMeasures()) measures.push_back(measure.first);
  measures.pop_back();  // what FAB-MAP alone has
  for (int descriptor = 0; descriptor < 2; ++descriptor)
    results.cells.push_back(
        {{someOf(numbers, measures), someOf(numbers, measures)}, {someOf(numbers, {"accuracy"})}});
  results.recognizers.emplace_back(
      "fab-map, orb", std::vector<CellResults>{someOf(numbers, {"one_image", "filtered", "unknown"})});
  test::expectGolden("features", featureFindings(results));
  const FeatureResults both = results;
  results.distances.pop_back();
  test::expectGolden("features-one-distance", featureFindings(results));
  results = both;
  results.descriptors.pop_back();
  results.cells.pop_back();
  test::expectGolden("features-one-descriptor", featureFindings(results));
}

TEST(Golden, Localization) {
  Numbers numbers;
  DriveResults results{{"places"}, {"day", "night"}, {""}, {}};
  auto measures = localizationErrorsColumns().measures;
  for (int i = 0; i < 2; ++i) {
    CellResults& cell = results.cells.emplace_back();
    for (const std::string answer : {"nearest image", "believed image"})
      for (const CellResult& result : someOf(numbers, measures, answer)) cell.push_back(result);
    measures.pop_back();  // no poses
  }
  test::expectGolden("localization", localizationFindings(results));
}

TEST(Golden, Odometry) {
  Numbers numbers;
  DriveResults results{{"places"}, {"day", "night"}, {"as it is", "noise"}, {}};
  for (int i = 0; i < 4; ++i) results.cells.push_back(someOf(numbers, odometryErrorsColumns().measures));
  test::expectGolden("odometry", odometryFindings(results));
}

TEST(Golden, Revisits) {
  Numbers numbers;
  DriveResults results{{"places"}, {"day", "night"}, {"with poses", "words alone"}, {}};
  auto measures = revisitsColumns().measures;
  for (int i = 0; i < 4; ++i) {
    results.cells.push_back(someOf(numbers, measures));
    if (i == 2) measures.pop_back();  // nothing found
  }
  test::expectGolden("revisits", revisitsFindings(results));
}

TEST(Golden, FurtherDrives) {
  Numbers numbers;
  DriveResults results{{"places"}, {"evening", "morning"}, {"continued", "merged"}, {}};
  auto measures = furtherDrivesColumns().measures;
  for (int i = 0; i < 4; ++i) {
    results.cells.push_back(i == 3 ? CellResults() : someOf(numbers, measures));
    if (i == 1) measures.pop_back();  // no depth
  }
  test::expectGolden("further-drives", furtherDrivesFindings(results));
}

TEST(Golden, RoomsByName) {
  Numbers numbers;
  DriveResults results{{"places", "imagenet"}, {"day", "night"}, {"six rooms", "no list"}, {}};
  for (int i = 0; i < 8; ++i) {
    CellResults& cell = results.cells.emplace_back();
    for (const CellResult& result :
         someOf(numbers,
                {"images", "chance", "accuracy", "accuracy_low", "accuracy_high", "groups", "pooled_accuracy",
                 "pooled_low", "pooled_high", "sure", "sure_accuracy"},
                "(all)"))
      if (i != 3 || result.measure != "sure_accuracy") cell.push_back(result);  // nothing was sure
    for (const std::string room : {"kitchen", "study"})
      if (i != 2 || room == "kitchen")
        for (const CellResult& result : someOf(numbers, {"images", "accuracy"}, room)) cell.push_back(result);
    if (i % 4 == 1)
      for (const CellResult& result : someOf(numbers, {"images", "probability"}, "area 0 in study: study"))
        cell.push_back(result);
  }
  test::expectGolden("rooms-by-name", roomsByNameFindings(results));
}

TEST(Golden, FewExamples) {
  Numbers numbers;
  DriveResults results{{"places", "imagenet"}, {"day"}, {"2", "10"}, {}};
  for (int i = 0; i < 4; ++i) {
    CellResults& cell = results.cells.emplace_back();
    for (const std::string by : {"examples", "names", "both"})
      for (const CellResult& result : someOf(numbers, {"accuracy", "log_loss"}, by)) cell.push_back(result);
  }
  test::expectGolden("few-examples", fewExamplesFindings(results));
}

TEST(Golden, WordPositions) {
  Numbers numbers;
  DriveResults results{{"places", "imagenet"}, {"day"}, {"words, depth", "words alone"}, {}};
  for (int i = 0; i < 4; ++i) {
    CellResults& cell = results.cells.emplace_back();
    for (const std::string category : {"sofa", "stove"})
      if (i != 2 || category == "stove") cell.push_back({"distance", category, numbers.next()});
    for (const CellResult& result : someOf(numbers, {"categories", "found", "share"})) cell.push_back(result);
  }
  test::expectGolden("word-map", wordPositionsFindings(results));
}

TEST(Golden, Words) {
  Numbers numbers;
  std::vector<WordAnswer> answers;
  for (int i = 0; i < 9; ++i) {
    WordAnswer& answer = answers.emplace_back();
    answer.kind = i < 5 ? "synonym" : "room";
    answer.query = fmt::format("query {}", i);
    answer.answers = 1 + numbers.below(9);
    for (int method = 0; method < 5; ++method) answer.averagePrecisions.push_back(numbers.next());
    answer.returned = i == 3 ? 0 : 1 + numbers.below(9);  // once nothing
    answer.correct = numbers.below(std::min(answer.returned, answer.answers) + 1);
    answer.milliseconds = 10 * numbers.next();
  }
  test::expectGolden("words", wordsFindings("imagenet", answers));
}

}  // namespace
}  // namespace estancia::experiments
