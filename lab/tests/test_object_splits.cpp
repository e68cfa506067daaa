// Splits of made-up things: balls, boxes and rods, three of each, six views of each.
// SPDX-License-Identifier: Apache-2.0
#include "objects/object_splits.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "counting.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/readers/object_samples.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::ElementsAre;

constexpr int instances = 3, views = 6;
const std::vector<std::string> kinds{"ball", "box", "rod"};

/// One view of a thing; `size` distinguishes instances.
PointCloud shapeOf(const std::string& kind, double size, std::uint64_t seed) {
  cv::RNG random(seed);
  PointCloud cloud;
  for (int i = 0; i < 300; ++i) {
    cv::Vec3d p(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    if (kind == "ball") p /= std::max(cv::norm(p), 1e-3);
    if (kind == "box") p[i % 3] = p[i % 3] < 0 ? -1 : 1;
    if (kind == "rod") p = {p[0], 0.08 * p[1], 0.08 * p[2]};
    p *= 0.1 * size;
    cloud.points.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]),
                              static_cast<float>(p[2] + 1));
  }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

class ObjectSplits : public testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = scratch_ / "things";
    for (const char* part : {"images", "clouds"}) std::filesystem::create_directories(folder / part);
    for (const std::string& kind : kinds)
      for (int i = 0; i < instances; ++i)
        for (int v = 0; v < views; ++v) {
          ObjectSample sample;
          sample.view.instance = fmt::format("{} {}", kind, i);
          sample.view.name = fmt::format("{}_{}_{}", kind, i, v);
          sample.view.category = kind;
          sample.view.split = i == 2 ? "test" : "train";
          sample.box = {2, 2, 12, 12};
          samples_.push_back(sample);
          writeCloud(
              shapeOf(kind, 1 + 0.1 * i, 100 * static_cast<std::uint64_t>(i) + static_cast<std::uint64_t>(v)),
              cloudOf(folder, sample.view.name));
          cv::imwrite(imageOf(folder, sample.view.name), cv::Mat(16, 16, CV_8UC3, cv::Scalar(50, 90, 200)));
        }
    writeObjectSamples(samples_, folder);
    // A labeler that is wrong about one view in three of every thing, and about all of ball 1.
    writeLabels([](const ObjectSample& sample) {
      const std::string& kind = sample.view.category;
      const bool wrong = sample.view.name.ends_with("_1") || sample.view.name.ends_with("_4") ||
                         sample.view.instance == "ball 1";
      return wrong ? (kind == "ball" ? "box" : "ball") : kind;
    });
    writeFile(scratch_ / "study.toml", "[classes.ball]\n[classes.box]\n[classes.rod]\n");
  }

  void writeLabels(const std::function<std::string(const ObjectSample&)>& wordOf) {
    std::string text = "image,ball,box,\"rod, stick\",cat\n";
    for (const ObjectSample& sample : samples_) {
      const std::string word = wordOf(sample);
      text += sample.view.name;
      for (const std::string& label : kinds) text += label == word ? ",0.6" : ",0.05";
      text += ",0.2\n";
    }
    writeFile(scratch_ / "words.csv", text);
  }

  const std::string things_ = "[[data]]\nname = \"things\"\nviews = \"things\"\nsamples = 1000\n";
  const std::string study_ = "study = \"study.toml\"\n";
  const std::string machine_ = "names = \"machine\"\nlabels = \"words.csv\"\nprior = \"none\"\n";
  const std::string few_ = "splits = 4\nclassifiers = [\"knn\"]\nfolds = 2\n";

  Findings run(const std::string& text, int threads = 2, const std::string& out = "out") {
    writeFile(scratch_ / "splits.toml", "type = \"object-splits\"\n" + text);
    return runExperiment({scratch_ / "splits.toml"}, {scratch_ / out, {}, {"", threads}, nullptr}, progress_);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  using Row = std::vector<std::string>;
  std::vector<Row> rows() const {
    std::vector<Row> all;
    for (const auto& row : io::readCsv(scratch_ / "out/results.csv")) all.push_back(row.cells);
    return all;
  }
  /// Accuracy by data, split, classifier and noise.
  std::map<std::string, double> accuracies() const {
    std::map<std::string, double> found;
    for (const Row& row : rows())
      if (row[0] != "data") found[row[0] + "|" + row[1] + "|" + row[3] + "|" + row[4]] = std::stod(row[5]);
    return found;
  }

  test::ScratchFolder scratch_;
  std::vector<ObjectSample> samples_;
  test::Counting progress_{{"learning"}};
};

TEST_F(ObjectSplits, HaveARowEachWithTheLabelerBeside) {
  const Findings findings =
      run(few_ + "pseudo_labels = [\"top\", \"voted\"]\n" + things_ + study_ + machine_);
  const auto all = rows();
  EXPECT_THAT(all[0],
              ElementsAre("data", "split", "labeler_accuracy", "classifier", "label_noise", "accuracy"));
  ASSERT_EQ(all.size(), 1U + 2 * 5) << "a baseline and four random splits, two ways of pseudo-labeling";
  std::set<std::string> splits;
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_EQ(all[i][0], "things");
    splits.insert(all[i][1]);
    EXPECT_EQ(all[i][4], "0");
    // Two thirds are labeled rightly, none of ball 1.
    EXPECT_THAT(std::stod(all[i][2]),
                testing::AnyOf(testing::DoubleNear(2 / 3.0, 1e-9), testing::DoubleNear(4 / 9.0, 1e-9)));
    EXPECT_EQ(all[i][3], i <= 5 ? "knn top" : "knn voted");
  }
  EXPECT_EQ(splits.size(), 5U);
  EXPECT_EQ(all[1][1], "baseline");
  EXPECT_NEAR(std::stod(all[1][2]), 4 / 9.0, 1e-9) << "the worst labeled things are tested";
  EXPECT_EQ(std::stod(all[6][5]), 1) << "the others' names are put right by a vote";
  EXPECT_THAT(findings.summary, testing::StartsWith("things: knn "));
}

TEST_F(ObjectSplits, OfOwnObjectsSayNothingOfTheThesis) {
  const Findings findings = run(few_ + "pseudo_labels = [\"voted\"]\n" + things_ + study_ + machine_);
  for (const auto& section : findings.sections)
    if (const auto* table = std::get_if<ResultTable>(&section)) {
      EXPECT_THAT(table->title + table->caption, testing::Not(testing::HasSubstr("hesis")));
      if (table->title == "things: accuracy") {
        EXPECT_EQ(table->columns.size(), 2U) << "the labeler's and the method's";
      }
    }
}

TEST_F(ObjectSplits, ShowTablesConfusionsCloudsAndExamples) {
  const Findings findings =
      run(few_ + "pseudo_labels = [\"voted\"]\nlabel_noises = [0, 0.3]\nthesis_tables = true\n" + things_ +
          study_ + machine_);
  std::map<std::string, std::size_t> sections;
  for (const auto& section : findings.sections)
    std::visit([&](const auto& part) { sections[part.title] = section.index(); }, section);
  for (const char* title :
       {"things: accuracy", "things: the splits", "things: label noise", "things, baseline: labeler",
        "things, baseline: names learned from (top)", "things, baseline: knn voted",
        "things, baseline: shape is right, the labeler wrong", "What the labeler says of each object",
        "The thesis, other data"})
    EXPECT_TRUE(sections.contains(title)) << title;
  for (const auto& section : findings.sections) {
    if (const auto* table = std::get_if<ResultTable>(&section); table && table->title == "things: accuracy") {
      ASSERT_EQ(table->rows.size(), 4U);
      EXPECT_EQ(table->rows[0].name, "baseline");
      EXPECT_THAT(table->rows[0].values,
                  ElementsAre(testing::Optional(testing::DoubleNear(400 / 9.0, 1e-6)), 100.0, 57.1, 93.5));
      EXPECT_EQ(table->columns[1].beats, 0U);
    }
    if (const auto* clouds = std::get_if<WordClouds>(&section)) {
      ASSERT_EQ(clouds->clouds.size(), 9U);
      EXPECT_EQ(clouds->clouds[1].name, "ball 1 (ball)");
      EXPECT_EQ(clouds->clouds[1].words[0].first, "box");
      EXPECT_NEAR(clouds->clouds[1].words[0].second, 0.6, 1e-6);
    }
    if (const auto* matrix = std::get_if<HeatTable>(&section);
        matrix && matrix->title == "things, baseline: labeler") {
      EXPECT_EQ(matrix->at(0, 1), 100) << "balls that are called boxes [%]";
      EXPECT_NEAR(matrix->at(2, 0), 100 / 3.0, 1e-6);
    }
    if (const auto* images = std::get_if<Images>(&section)) {
      ASSERT_FALSE(images->images.empty());
    }
  }
}

TEST_F(ObjectSplits, NoiseMisnamesWhatIsLearnedFromAlone) {
  run(few_ + "pseudo_labels = [\"top\", \"voted\"]\nlabel_noises = [0, 0.2, 0.9]\nseeds = [1, 2]\n" +
      things_ + study_ + "names = \"true\"\nlabels = \"words.csv\"\nprior = \"none\"\n");
  std::map<std::string, std::set<std::string>> labeled;
  double voted = 0, hopeless = 0;
  for (const Row& row : rows()) {
    if (row[0] == "data") continue;
    labeled[row[1]].insert(row[2]);
    if (row[4] == "0") {
      EXPECT_EQ(row[5], "1") << "true names, shapes unlike each other";
    }
    if (row[4] == "0.2" && row[3] == "knn voted") voted += std::stod(row[5]) / 5;
    if (row[4] == "0.9") hopeless += std::stod(row[5]) / 10;
  }
  for (const auto& [split, values] : labeled) EXPECT_EQ(values.size(), 1U) << "the labeler is not made worse";
  EXPECT_GT(voted, 0.95);
  EXPECT_LT(hopeless, 0.4);
}

TEST_F(ObjectSplits, ByViewsAndByTheDatasOwnParts) {
  const std::string names = "names = \"true\"\n", voted = "pseudo_labels = [\"voted\"]\n";
  run(few_ + voted + things_ + names + "split = \"views\"\n[[data]]\nname = \"own\"\nviews = \"things\"\n" +
      names + "split = \"official\"\n");
  const auto found = accuracies();
  ASSERT_EQ(found.size(), 4U);
  for (const char* split : {"things|views 1", "things|views 2", "things|views 3", "own|official"})
    EXPECT_EQ(found.at(std::string(split) + "|knn voted|0"), 1) << split;
  for (const Row& row : rows())
    if (row[0] != "data") {
      EXPECT_EQ(row[2], "") << "nobody was asked";
    }
}

TEST_F(ObjectSplits, GoOnWhereTheyStoppedAndDoNotDependOnThreads) {
  const std::string text = few_ + "pseudo_labels = [\"top\", \"confident\"]\nlabel_noises = [0, 0.2]\n" +
                           things_ + study_ + machine_;
  run(text, 1);
  EXPECT_EQ(progress_.computed, 20U);
  run(text, 3, "again");
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), readFile(scratch_ / "again/results.csv"));
  progress_.computed = 0;
  run(text);
  EXPECT_EQ(progress_.computed, 0U) << "all is known";
  writeLabels([](const ObjectSample& sample) { return sample.view.category; });
  run(text);
  EXPECT_EQ(progress_.computed, 20U) << "other words";
}

TEST_F(ObjectSplits, TheTestHasNoSay) {
  const std::string text = few_ + "pseudo_labels = [\"top\"]\n" + things_ + study_ +
                           "labels = \"words.csv\"\nsplit = \"official\"\n";
  run(text);
  const auto before = accuracies();
  // The labeler's answers for the test views are all wrong now; its prior must not know.
  writeLabels(
      [](const ObjectSample& sample) { return sample.view.split == "test" ? "rod" : sample.view.category; });
  run(text);
  EXPECT_EQ(rows()[1][2], fmt::format("{}", 6 / 18.0));
  EXPECT_GE(accuracies().begin()->second, before.begin()->second);
}

TEST_F(ObjectSplits, SayWhatIsWrongWithTheConfiguration) {
  EXPECT_THAT(problem(few_ + "[[data]]\nname = \"x\"\nviews = \"nowhere\"\nnames = \"true\"\n"),
              FailsWith(ErrorCode::fileNotFound, "nowhere"));
  EXPECT_THAT(problem("[[data]]\nname = \"x\"\nviews = \"things\"\n"),
              FailsWith(ErrorCode::malformedFile, "splits.toml:2"));
  EXPECT_THAT(problem(things_ + "labels = \"words.csv\"\nmodel = \"net\"\n"),
              FailsWith(ErrorCode::malformedFile, "splits.toml:2", "`model`", "`labels`"));
  EXPECT_THAT(problem("pseudo_labels = [\"best\"]\n" + things_),
              FailsWith(ErrorCode::malformedFile, "splits.toml:2", "`pseudo_labels`"));
  EXPECT_THAT(problem("label_noises = [1.5]\n" + things_),
              FailsWith(ErrorCode::malformedFile, "splits.toml:2", "`label_noises`"));
  EXPECT_THAT(
      problem(things_ + "split = \"halves\"\n"),
      FailsWith(ErrorCode::malformedFile, "splits.toml:6", "\"halves\"", "instances, views, official"));
  EXPECT_THAT(problem(things_ + "model = \"no-such-model\"\n"),
              FailsWith(ErrorCode::unknownName, "no-such-model"));
  EXPECT_FALSE(problem(few_ + things_ +
                       "names = \"true\"\noptional = true\n[[data]]\nname = \"x\"\nviews = "
                       "\"nowhere\"\nnames = \"true\"\noptional = true\n")
                   .code);
  EXPECT_THAT(problem("[[data]]\nname = \"x\"\nviews = \"nowhere\"\nnames = \"true\"\noptional = true\n"),
              FailsWith(ErrorCode::insufficientData, "[[data]]"));
}

TEST_F(ObjectSplits, SayWhatIsWrongWithTheData) {
  const std::string truth = "names = \"true\"\n";
  const auto study = [&](const std::string& text) { writeFile(scratch_ / "study.toml", text); };
  study("[classes.ball]\n[classes.rob]\ncategories = [\"rod\"]\n");
  EXPECT_THAT(problem(few_ + things_ + study_ + machine_), FailsWith(ErrorCode::unknownName, "rob", "rod"))
      << "an unknown word, and how it may be spelled";
  study("[classes.ball]\n");
  EXPECT_THAT(problem(few_ + things_ + study_ + truth), FailsWith(ErrorCode::insufficientData, "ball"));
  study("[classes.ball]\ncategories = [\"cat\"]\n[classes.box]\ncategories = [\"dog\"]\n");
  EXPECT_THAT(problem(few_ + things_ + study_ + truth), FailsWith(ErrorCode::insufficientData, "study.toml"));
  study("[classes.ball]\n[classes.box]\n[classes.rod]\n");

  writeFile(scratch_ / "words.csv", "image,ball,box,rod\nsomewhere_else,1,0,0\n");
  EXPECT_THAT(problem(few_ + things_ + study_ + machine_),
              FailsWith(ErrorCode::labelerFailure, "things: ", "\"somewhere_else\""))
      << "labels of other views";
  std::string silent = "image,ball,box,rod,cat\n";
  for (const ObjectSample& sample : samples_) silent += sample.view.name + ",0,0,0,1\n";
  writeFile(scratch_ / "words.csv", silent);
  EXPECT_THAT(problem(few_ + things_ + study_ + machine_),
              FailsWith(ErrorCode::insufficientData, "things: "));

  auto single = samples_;
  std::erase_if(single, [](const ObjectSample& sample) { return !sample.view.instance.ends_with("0"); });
  writeObjectSamples(single, scratch_ / "things");
  EXPECT_THAT(problem(few_ + things_ + study_ + truth), FailsWith(ErrorCode::insufficientData));
  auto torn = samples_;
  torn[0].view.split = "test";
  writeObjectSamples(torn, scratch_ / "things");
  EXPECT_THAT(problem(few_ + things_ + study_ + truth + "split = \"official\"\n"),
              FailsWith(ErrorCode::mismatch, "ball 0"));
  for (ObjectSample& sample : torn) sample.view.split = "train";
  writeObjectSamples(torn, scratch_ / "things");
  EXPECT_THAT(problem(few_ + things_ + study_ + truth + "split = \"official\"\n"),
              FailsWith(ErrorCode::insufficientData, "54", "0"));
  for (ObjectSample& sample : torn) sample.view.split = sample.view.category == "ball" ? "train" : "test";
  writeObjectSamples(torn, scratch_ / "things");
  EXPECT_THAT(problem(few_ + things_ + study_ + truth + "split = \"official\"\n"),
              FailsWith(ErrorCode::insufficientData, "ball"));
}

}  // namespace
}  // namespace estancia::experiments
