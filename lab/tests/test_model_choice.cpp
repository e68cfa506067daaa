// The whole experiment on made-up images: a model that sees colors must beat one that sees nothing.
// SPDX-License-Identifier: Apache-2.0
#include "places/model_choice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "color_drive.hpp"
#include "counting.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/csv.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"
#include "support/golden_findings.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
namespace fs = std::filesystem;

/// Two models, "sharp" and "blind", and two visits of a drive.
class ModelChoice : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch, "sharp", "0.02");
    test::writeColorModel(scratch, "blind", "1e-9");
    test::writeColorDrive(scratch / "drive", 0);
    test::writeColorDrive(scratch / "again", 1);
  }

  std::string config(const std::string& head = "", const std::string& sequence = "") {
    return "type = \"model-choice\"\nclusters = 8\nrepeats = 2\nshown = [4]\n" + head +
           "\n[[sequence]]\npath = \"drive\"\n" + sequence;
  }

  Findings run(const std::string& text, int threads = 2) {
    writeFile(scratch / "choice.toml", text);
    return runExperiment({scratch / "choice.toml"},
                         {scratch / "out", {scratch / "sharp", scratch / "blind"}, {"", threads}, nullptr},
                         progress);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  test::ScratchFolder scratch;
  test::Counting progress{{"clustering"}};
};

const ResultTable& table(const Findings& findings, std::size_t which) {
  std::vector<const ResultTable*> tables;
  for (const auto& section : findings.sections)
    if (const auto* found = std::get_if<ResultTable>(&section)) tables.push_back(found);
  return *tables.at(which);
}

TEST_F(ModelChoice, TheModelThatSeesBeatsTheBlindOne) {
  const Findings findings =
      run(config("distances = [\"standardized-clr\", \"l2\"]", "radius = 1\ngap = 0.01\n"));
  for (const std::size_t distance : {0U, 1U}) {
    const ResultTable& variances = table(findings, 2 * distance);
    ASSERT_EQ(variances.rows.size(), 2U);
    EXPECT_EQ(variances.columns[0].name, "k = 4 [%]");
    EXPECT_EQ(variances.columns[1].name, "mean rank");
    EXPECT_EQ(variances.rows[0].name, "sharp");
    EXPECT_NEAR(*variances.rows[0].values[0], 0, 1e-9) << "four colors, four clusters";
    EXPECT_DOUBLE_EQ(*variances.rows[0].values[1], (1.5 + 7) / 8) << "one cluster is the same for all";
    EXPECT_EQ(variances.rows[0].values[2], 7) << "wins";
    EXPECT_EQ(variances.rows[0].values[3], 1) << "ties";
    EXPECT_EQ(variances.rows[1].values[4], 7) << "losses";
    const ResultTable& places = table(findings, 2 * distance + 1);
    EXPECT_EQ(places.rows[0].name, "sharp");
    EXPECT_DOUBLE_EQ(*places.rows[0].values[0], 100);
    EXPECT_LT(*places.rows[1].values[0], 50);
    EXPECT_EQ(places.rows[2].name, "(by chance)");
  }
  EXPECT_EQ(
      findings.summary,
      "sharp tells the places apart best (mean rank 1.06 of 2 models), sharp recognizes them best (100 %).");
}

TEST_F(ModelChoice, EveryNumberIsInTheTableOfResults) {
  run(config("", "name = \"corridor\"\nradius = 1\n[sequence.again]\npath = \"again\"\n"));
  std::vector<std::vector<std::string>> rows;
  for (const auto& row : io::readCsv(scratch / "out" / "results.csv")) rows.push_back(row.cells);
  ASSERT_EQ(rows.size(), 1U + 2 * 9) << "eight k and the places, of two models";
  EXPECT_THAT(rows[0], testing::ElementsAre("model", "sequence", "distance", "k", "spatial_variance",
                                            "spatial_variance_by_image", "place_queries", "place_right",
                                            "place_chance"));
  EXPECT_THAT(rows[1], testing::ElementsAre("sharp", "corridor", "standardized-clr", "1", "11.25", "11.25",
                                            "", "", ""));
  EXPECT_EQ(rows[8][3], "8");
  EXPECT_THAT(rows[9],
              testing::ElementsAre("sharp", "corridor", "standardized-clr", "", "", "", "40", "1", "0.25"));
}

TEST_F(ModelChoice, FindsTheSameWithAnyNumberOfThreads) {
  run(config(), 1);
  const std::string first = readFile(scratch / "out" / "results.csv");
  fs::remove_all(scratch / "out");
  run(config(), 5);
  EXPECT_EQ(readFile(scratch / "out" / "results.csv"), first);
}

TEST_F(ModelChoice, ComputesOnlyWhatHasChanged) {
  const std::string two = "distances = [\"standardized-clr\", \"l2\"]";
  run(config(two));
  EXPECT_EQ(std::exchange(progress.computed, 0), 4U);
  run(config(two));
  EXPECT_EQ(std::exchange(progress.computed, 0), 0U);
  run(config(two + "\nseed = 2"));
  EXPECT_EQ(std::exchange(progress.computed, 0), 4U);
  run(config("distances = [\"l2\", \"hellinger\"]"));
  EXPECT_EQ(std::exchange(progress.computed, 0), 2U) << "l2 is known";
  test::writeColorModel(scratch, "blind", "1e-8");
  run(config(two));
  EXPECT_EQ(std::exchange(progress.computed, 0), 2U) << "the model has changed";
  fs::remove(scratch / "drive" / "0007.png");
  writeFile(scratch / "drive" / "poses.txt", readFile(scratch / "again" / "poses.txt").erase(0, 16));
  run(config(two));
  EXPECT_EQ(std::exchange(progress.computed, 0), 4U) << "the drive has changed";
}

TEST_F(ModelChoice, WrongKeysAreNamedWithFileAndLine) {
  EXPECT_THAT(problem("typ = \"model-choice\"\n"),
              FailsWith(ErrorCode::malformedFile, "choice.toml", "`type`"));
  EXPECT_THAT(problem("type = \"model-chioce\"\n"),
              FailsWith(ErrorCode::malformedFile, "choice.toml:1", "`type`", "\"model-choice\""));
  EXPECT_THAT(problem("type = \"model-choice\"\n"), FailsWith(ErrorCode::malformedFile, "`sequence`"));
  EXPECT_THAT(problem(config("cluster = 3")),
              FailsWith(ErrorCode::malformedFile, "choice.toml:5", "`cluster`"));
  EXPECT_THAT(problem(config("seed = -1")), FailsWith(ErrorCode::malformedFile, "choice.toml:5", "`seed`"));
  EXPECT_THAT(problem(config("models = []")),
              FailsWith(ErrorCode::malformedFile, "choice.toml:5", "`models`"));
  EXPECT_THAT(problem(config("distances = [\"l2\", \"l1\"]")),
              FailsWith(ErrorCode::malformedFile, "choice.toml:5", "\"l1\""));
  EXPECT_THAT(problem(config("distances = \"l2-sigma\"")), FailsWith(ErrorCode::malformedFile, "l2-sigma"));
  EXPECT_THAT(problem(config("", "pose = \"x\"")),
              FailsWith(ErrorCode::malformedFile, "choice.toml:8", "`pose`"));
  EXPECT_THAT(problem(config("", "[sequence.again]\nradius = 1")),
              FailsWith(ErrorCode::malformedFile, "choice.toml:9", "`radius`"));
  EXPECT_THAT(problem(config("", "radius = -1")),
              FailsWith(ErrorCode::malformedFile, "choice.toml:8", "`radius`"));
  EXPECT_THAT(problem("type = \n"), FailsWith(ErrorCode::malformedFile, "choice.toml:1"));
  EXPECT_THAT(problem("type = \"model-choice\"\nsequence = 3\n"),
              FailsWith(ErrorCode::malformedFile, "choice.toml:2", "`sequence`"));
  EXPECT_THAT(problem("type = \"model-choice\"\n[[sequence]]\nname = \"x\"\n"),
              FailsWith(ErrorCode::malformedFile, "`path`"));
}

TEST_F(ModelChoice, PathsKnowVariablesAndAreRelativeToTheFile) {
  setenv("ESTANCIA_TEST_FOLDER", scratch.path().c_str(), 1);
  const std::string head = "type = \"model-choice\"\nclusters = 2\nrepeats = 1\n[[sequence]]\n";
  EXPECT_EQ(problem(head + "path = \"${ESTANCIA_TEST_FOLDER}/drive\"\n").code, std::nullopt);
  EXPECT_EQ(problem(head + "path = \"./again/../drive\"\nposes = \"again/poses.txt\"\n").code, std::nullopt);
  EXPECT_THAT(problem(head + "path = \"${ESTANCIA_NO_SUCH}/drive\"\n"),
              FailsWith(ErrorCode::malformedFile, "choice.toml:5", "`path`"));
  EXPECT_THAT(problem(head + "path = \"${HOME\"\n"),
              FailsWith(ErrorCode::malformedFile, "choice.toml:5", "${"));
  EXPECT_THAT(problem(head + "path = \"\"\n"), FailsWith(ErrorCode::malformedFile, "`path`"));
}

TEST_F(ModelChoice, SequencesWithoutPosesOrSpreadAreRefused) {
  fs::remove(scratch / "drive" / "poses.txt");
  EXPECT_THAT(problem(config()), FailsWith(ErrorCode::insufficientData, "drive", "0 of 40"));
  std::string still;
  for (int i = 0; i < 40; ++i) still += std::to_string(i) + " 1 2 3 0 0 0 1\n";
  writeFile(scratch / "drive" / "poses.txt", still);
  EXPECT_THAT(problem(config()), FailsWith(ErrorCode::insufficientData, "drive"));
}

TEST_F(ModelChoice, MissingSequencesAreAnErrorUnlessOptional) {
  EXPECT_THAT(problem(config("", "\n[[sequence]]\npath = \"nowhere\"\n")),
              FailsWith(ErrorCode::fileNotFound, "nowhere"));
  const Findings findings = run(config("", "\n[[sequence]]\npath = \"nowhere\"\noptional = true\n"));
  EXPECT_EQ(test::notesNaming(findings, "nowhere"), 1U);
  EXPECT_THAT(problem("type = \"model-choice\"\n[[sequence]]\npath = \"nowhere\"\noptional = true\n"),
              FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(problem(config("", "\n[[sequence]]\npath = \"drive\"\n")),
              FailsWith(ErrorCode::invalidInput, "drive"));
}

TEST_F(ModelChoice, ModelsAreCheckedBeforeAnythingIsLabeled) {
  writeFile(scratch / "choice.toml", config());
  const auto with = [&](const std::vector<std::string>& models) {
    return test::caught([&] {
      runExperiment({scratch / "choice.toml"}, {scratch / "out", models, {}, nullptr}, progress);
    });
  };
  EXPECT_THAT(with({scratch / "sharp", "./nowhere"}), FailsWith(ErrorCode::fileNotFound, "./nowhere"));
  EXPECT_THAT(with({"no-such-model"}), FailsWith(ErrorCode::unknownName, "no-such-model"));
  EXPECT_THAT(with({(scratch / "sharp").string() + "+no-such-model"}),
              FailsWith(ErrorCode::unknownName, "no-such-model"));
  EXPECT_THAT(with({scratch / "sharp", scratch / "sharp"}), FailsWith(ErrorCode::invalidInput, "sharp"));
  EXPECT_EQ(progress.computed, 0U);
}

TEST_F(ModelChoice, SeveralModelsAtWorkTogetherAreOneCandidate) {
  writeFile(scratch / "choice.toml", config("", "radius = 1\ngap = 0.01"));
  const std::string both = (scratch / "sharp").string() + "+" + (scratch / "blind").string();
  const Findings findings = runExperiment(
      {scratch / "choice.toml"}, {scratch / "out", {both, scratch / "blind"}, {}, nullptr}, progress);
  EXPECT_EQ(table(findings, 0).rows[0].name, "sharp+blind");
  EXPECT_EQ(table(findings, 0).rows[0].values[2], 7) << "wins";
  EXPECT_DOUBLE_EQ(*table(findings, 1).rows[0].values[0], 100);
}

TEST_F(ModelChoice, UnreadableImagesAreLeftOutAndTold) {
  writeFile(scratch / "drive" / "0012.png", "no image");
  const Findings findings = run(config());
  EXPECT_EQ(test::notesNaming(findings, "1 unreadable"), 2U) << "once a model";
}

TEST_F(ModelChoice, FewerImagesThanClustersAreNoError) {
  const Findings findings =
      run("type = \"model-choice\"\nclusters = 100\nrepeats = 1\nshown = [7, 90]\n[[sequence]]\npath = "
          "\"drive\"\n");
  EXPECT_EQ(table(findings, 0).columns.front().name, "k = 7 [%]");
  EXPECT_EQ(table(findings, 0).columns[1].name, "mean rank") << "90 clusters of 40 images cannot be shown";
}

TEST_F(ModelChoice, AModelThatAlwaysSaysTheSameDoesNotWin) {
  writeFile(scratch / "blind/box.py",
            "import sys, json\n"
            "for line in sys.stdin:\n"
            "    print(json.dumps({'image': line.strip(), 'labels': {'a': 0.7, 'b': 0.3}}), flush=True)\n");
  writeFile(scratch / "blind/model.toml",
            "name = \"blind\"\ntype = \"process\"\ncommand = [\"python3\", \"box.py\"]\n");
  const Findings findings = run(config());
  const auto& rows = table(findings, 0).rows;
  EXPECT_EQ(rows.front().name, "sharp");
}

}  // namespace
}  // namespace estancia::experiments
