// Maps over thresholds, on a drive past four colors whose maps are known by hand.
// SPDX-License-Identifier: Apache-2.0
#include "places/maps.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "color_drive.hpp"
#include "counting.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/csv.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
namespace fs = std::filesystem;

class Maps : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch, "sharp", "0.02");
    test::writeColorDrive(scratch / "drive", 0);
    test::writeColorDrive(scratch / "moved", 1);
    std::string poses;  // the last color now stands where the first one does
    for (int i = 0; i < 40; ++i)
      poses += std::to_string(i) + " " + std::to_string(3 * (i / 10 % 3)) + " 0 0 0 0 0 1\n";
    writeFile(scratch / "moved/poses.txt", poses);
  }

  Findings run(const std::string& text) {
    writeFile(scratch / "maps.toml", "type = \"maps\"\n" + text);
    return runExperiment({scratch / "maps.toml"}, {scratch / "out", {scratch / "sharp"}, {"", 2}, nullptr},
                         progress);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  /// The rows of results.csv, by column.
  std::vector<std::map<std::string, std::string>> results() {
    const auto rows = io::readCsv(scratch / "out/results.csv");
    std::vector<std::map<std::string, std::string>> all;
    for (std::size_t r = 1; r < rows.size(); ++r) {
      auto& row = all.emplace_back();
      for (std::size_t c = 0; c < rows[0].cells.size(); ++c) row[rows[0].cells[c]] = rows[r].cells[c];
    }
    return all;
  }

  const std::string drive = "[[sequence]]\nname = \"drive\"\npath = \"drive\"\n";
  const std::string moved = "[[sequence]]\nname = \"moved\"\npath = \"moved\"\n";
  const std::string own = "[[parameters]]\npreset = \"default\"\n";
  test::ScratchFolder scratch;
  test::Counting progress{{"sharp"}};
};

template <class Section>
std::vector<const Section*> sectionsOf(const Findings& findings) {
  std::vector<const Section*> found;
  for (const auto& section : findings.sections)
    if (const auto* one = std::get_if<Section>(&section)) found.push_back(one);
  return found;
}

void expectValues(const std::map<std::string, std::string>& row,
                  const std::map<std::string, double>& expected) {
  for (const auto& [column, value] : expected) EXPECT_NEAR(std::stod(row.at(column)), value, 1e-6) << column;
}

TEST_F(Maps, MeasuresAreThoseCountedByHand) {
  run(own + "[[parameters]]\npreset = \"thesis\"\ntau_join = [1000]\n" + drive);
  const auto rows = results();
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].at("tau_join"), "auto");
  // Nodes at 0, 3, 6 and 9 m in a row; X is 9 m.
  expectValues(rows[0], {{"nodes", 4},
                         {"links", 3},
                         {"v_measure", 1},
                         {"ari", 1},
                         {"purity", 1},
                         {"edge_precision", 1},
                         {"edge_recall", 1},
                         {"score_a", 1},
                         {"score_b", 6.0 / 8},
                         {"score_c", 1 - 3.0 / 9},
                         {"score_d", 1},
                         {"score_e", 2 * std::sqrt(11.25) / 9}});
  EXPECT_EQ(rows[2].at("tau_join"), "1000");
  // A single node: its images 4.5 m in the mean from its first, its last one 9 m.
  expectValues(rows[2], {{"nodes", 1},
                         {"links", 0},
                         {"v_measure", 0},
                         {"purity", 0.25},
                         {"score_a", 0},
                         {"score_b", 0},
                         {"score_c", 1},
                         {"score_d", 0},
                         {"score_e", 0},
                         {"score", 20}});
  EXPECT_EQ(rows[2].at("found"), "") << "there is no reference";
}

TEST_F(Maps, TheScoreTakesTheExtentThatItIsGiven) {
  run("score_extent = 18\n" + own + drive);
  expectValues(results().at(0), {{"score_c", 1 - 3.0 / 18}});
}

TEST_F(Maps, ImagesAreFoundWhereWordsAndMetersAgree) {
  const Findings findings = run("reference = \"drive\"\n" + own + drive + moved);
  const auto rows = results();
  ASSERT_EQ(rows.size(), 2U);
  expectValues(rows[0], {{"found", 1}});
  expectValues(rows[1], {{"found", 0.75}});
  const auto tables = sectionsOf<ResultTable>(findings);
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_EQ(tables[1]->columns.size(), 2U);
  EXPECT_EQ(tables[1]->rows[1].values[1], 75);
}

TEST_F(Maps, SweepsAreSeenAsTablesCurvesAndMaps) {
  const Findings findings =
      run("[[parameters]]\npreset = \"thesis\"\ntau_join = [0.1, 0.2]\ntau_revisit = [0.01, 0.02, 0.1]\n" +
          drive);
  EXPECT_EQ(results().size(), 7U);
  const auto images = sectionsOf<Images>(findings);
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0]->images.size(), 1U);
  EXPECT_EQ(images[1]->images.size(), 7U);
  const auto charts = sectionsOf<LineChart>(findings);
  ASSERT_EQ(charts.size(), 3U) << "nodes, V-measure, score";
  EXPECT_THAT(charts[0]->x, testing::ElementsAre(0.01, 0.02, 0.1));
  ASSERT_EQ(charts[0]->lines.size(), 2U);
  EXPECT_EQ(charts[0]->lines[1].name, "τ_join 0.2");
  const auto tables = sectionsOf<ResultTable>(findings);
  EXPECT_EQ(tables.back()->rows.size(), 7U);
  EXPECT_EQ(charts[0]->lines[0].y[2], tables.back()->rows[3].values[0]);
}

TEST_F(Maps, NodesHaveTheColorOfTheirRoom) {
  const Findings findings = run(own + drive);
  const auto images = sectionsOf<Images>(findings);
  ASSERT_EQ(images.size(), 1U);
  const cv::Mat image = cv::imdecode(images[0]->images.at(0).file, cv::IMREAD_COLOR);
  ASSERT_FALSE(image.empty());
  // Four discs in a row, evenly spaced, each of one color.
  std::set<std::string> colors;
  for (int k = 0; k < 4; ++k) {
    const auto at = image.at<cv::Vec3b>(image.rows / 2, 26 + k * (image.cols - 52) / 3);
    EXPECT_NE(at, cv::Vec3b(255, 255, 255)) << k;
    colors.insert(cv::format("%d %d %d", at[0], at[1], at[2]));
  }
  EXPECT_EQ(colors.size(), 4U);
}

TEST_F(Maps, TheAuthorsFiguresStandBesideSequencesOfTheirNames) {
  const Findings findings =
      run("thesis_tables = true\nreference = \"Cloudy 1\"\n[[parameters]]\npreset = \"thesis\"\n"
          "tau_join = [0.01, 0.02]\ntau_revisit = [0.001, 0.002]\n"
          "[[sequence]]\nname = \"Cloudy 1\"\npath = \"drive\"\n[[sequence]]\nname = \"mine\"\npath = "
          "\"moved\"\n");
  std::map<std::string, const ResultTable*> tables;
  for (const auto* table : sectionsOf<ResultTable>(findings)) tables[table->title] = table;
  const ResultTable& found = *tables.at("Images found in the map of Cloudy 1");
  EXPECT_NEAR(*found.rows[0].values.back(), 38.14, 1e-9);
  EXPECT_FALSE(found.rows[1].values.back()) << "he has none of that name";
  const ResultTable& sweep = *tables.at("Cloudy 1, preset thesis");
  ASSERT_EQ(sweep.rows.size(), 5U);
  EXPECT_EQ(sweep.rows[1].name, "0.01, 0.001");
  const std::size_t columns = sweep.columns.size();
  EXPECT_EQ(sweep.columns[columns - 3].name, "author: nodes");
  EXPECT_EQ(sweep.rows[1].values[columns - 3], 86);
  EXPECT_EQ(sweep.rows[1].values[columns - 2], 86);
  EXPECT_EQ(sweep.rows[1].values[columns - 1], 84.859);
  EXPECT_EQ(tables.at("mine, preset thesis")->columns.back().name, "score");
  const auto* nodes = sectionsOf<LineChart>(findings).at(0);
  ASSERT_EQ(nodes->lines.size(), 4U);
  EXPECT_EQ(nodes->lines[1].name, "author, τ_join 0.01");
  EXPECT_THAT(nodes->lines[1].y, testing::ElementsAre(86, 79));
}

TEST_F(Maps, ComputesOnlyWhatHasChanged) {
  const std::string two = own + "tau_join = [1, 2]\n" + drive;
  run("reference = \"drive\"\n" + two);
  EXPECT_EQ(std::exchange(progress.computed, 0), 3U);
  run("reference = \"drive\"\n" + two);
  EXPECT_EQ(std::exchange(progress.computed, 0), 0U);
  run("reference = \"drive\"\n" + own + "tau_join = [1, 2, 3]\n" + drive);
  EXPECT_EQ(std::exchange(progress.computed, 0), 1U);
  run(two);
  EXPECT_EQ(std::exchange(progress.computed, 0), 3U) << "nothing is to be found in it";
}

TEST_F(Maps, WhatIsNotThereIsLeftOutWithANote) {
  const std::string gone = "[[sequence]]\nname = \"gone\"\npath = \"gone\"\noptional = true\n";
  const Findings findings = run("reference = \"gone\"\n" + own + drive + gone);
  EXPECT_EQ(findings.notes.size(), 2U) << "the sequence, and what would be found in its map";
  EXPECT_EQ(results().size(), 1U);
  EXPECT_THAT(problem(own + gone), FailsWith(ErrorCode::insufficientData));
}

TEST_F(Maps, WithoutPosesThereAreNodesAndNoImage) {
  fs::remove(scratch / "drive/poses.txt");
  const Findings findings = run("reference = \"drive\"\n" + own + drive);
  expectValues(results().at(0), {{"nodes", 4}, {"v_measure", 1}});
  EXPECT_EQ(results().at(0).at("found"), "");
  EXPECT_TRUE(sectionsOf<Images>(findings).empty());
}

TEST_F(Maps, WrongKeysAreNamedWithFileAndLine) {
  const auto isRefused = [&](const std::string& text, const std::string& key, int line) {
    EXPECT_THAT(problem(text), FailsWith(ErrorCode::malformedFile, "maps.toml:" + std::to_string(line), key));
  };
  EXPECT_THAT(problem(drive), FailsWith(ErrorCode::malformedFile, "`parameters`"));
  EXPECT_THAT(problem(own), FailsWith(ErrorCode::malformedFile, "`sequence`"));
  isRefused("[[parameters]]\npreset = \"theses\"\n" + drive, "`preset`", 3);
  EXPECT_THAT(problem("[[parameters]]\ntau_join = [1]\n" + drive),
              FailsWith(ErrorCode::malformedFile, "`preset`"));
  isRefused(own + "tau_join = [0]\n" + drive, "`tau_join`", 4);
  isRefused(own + "tau_join = []\n" + drive, "`tau_join`", 4);
  isRefused(own + "tau_revisit = [1, 1]\n" + drive, "`tau_revisit`", 4);
  isRefused(own + "tau_revisit = \"auto\"\n" + drive, "`tau_revisit`", 4);
  isRefused("reference = \"nowhere\"\n" + own + drive, "nowhere", 2);
  isRefused("score_extent = 0\n" + own + drive, "`score_extent`", 2);
  isRefused(own + drive + "extent = [0, 0, 1, 1]\n", "`extent`", 7);
  isRefused(own + drive + "floor_plan = \"plan.png\"\nextent = [0, 0, 1]\n", "`extent`", 8);
  EXPECT_THAT(problem(own + drive + drive), FailsWith(ErrorCode::invalidInput, "drive"));
  EXPECT_THAT(problem(own + drive + "floor_plan = \"plan.png\"\nextent = [0, 0, 1, 1]\n"),
              FailsWith(ErrorCode::fileUnreadable, "plan.png"));
}

}  // namespace
}  // namespace estancia::experiments
