// Zones on made-up images whose rooms are known: four colors, four rooms.
// SPDX-License-Identifier: Apache-2.0
#include "zones/zone_tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <utility>

#include "color_drive.hpp"
#include "counting.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/zones/measure.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"
#include "support/golden_findings.hpp"
#include "zones/zone_tables_findings.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::ElementsAre;
namespace fs = std::filesystem;

class ZoneTables : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch_, "sharp", "0.02");
    test::writeColorModel(scratch_, "blind", "1e-9");
    test::writeColorDrive(scratch_ / "drive", 1);
    std::string table = "number,kind,class,half\n";
    for (int i = 0; i < 40; ++i)
      table += std::to_string(i) + (i < 20 ? ",warm,warm-" : ",cold,cold-") + std::to_string(i / 10) +
               (i % 10 < 5 ? ",a\n" : ",b\n");
    writeFile(scratch_ / "table.csv", table);
  }

  const std::string few_ = "distances = [\"standardized-clr\", \"ks\"]\nlinkages = [\"ward\", \"average\"]\n";
  const std::string data_ = "[[data]]\nname = \"four\"\npath = \"drive\"\nparts = 2\n";
  const std::string table_ =
      "[[data]]\nname = \"two\"\npath = \"drive\"\ntable = \"table.csv\"\nimage_column = \"number\"\n"
      "room_column = \"kind\"\n";

  Findings run(const std::string& text, int threads = 2) {
    writeFile(scratch_ / "zones.toml", "type = \"zones\"\n" + text);
    return runExperiment({scratch_ / "zones.toml"},
                         {scratch_ / "out", {scratch_ / "sharp", scratch_ / "blind"}, {"", threads}, nullptr},
                         progress_);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  /// results.csv by its first five cells.
  std::map<std::vector<std::string>, std::vector<std::string>> rows() const {
    std::map<std::vector<std::string>, std::vector<std::string>> found;
    for (const auto& row : io::readCsv(scratch_ / "out/results.csv"))
      found[{row.cells.begin(), row.cells.begin() + 5}] = {row.cells.begin() + 5, row.cells.end()};
    return found;
  }

  test::ScratchFolder scratch_;
  test::Counting progress_{{"finding zones"}};
};

const ResultTable& table(const Findings& findings, const std::string& title) {
  for (const auto& section : findings.sections)
    if (const auto* found = std::get_if<ResultTable>(&section); found != nullptr && found->title == title)
      return *found;
  throw Error(ErrorCode::noAnswer, "no table " + title);
}

TEST_F(ZoneTables, HaveARowACut) {
  run(few_ + data_ + table_);
  EXPECT_THAT(readFile(scratch_ / "out/results.csv"),
              testing::StartsWith("data,model,distance,linkage,cut,zones,v_measure,ari,purity,m\n"
                                  "four,sharp,standardized-clr,ward,0.2,"));
  const auto found = rows();
  EXPECT_EQ(found.size(), 1U + 2 * 2 * 3 * 7) << "ward does not go with ks";
  EXPECT_THAT(found.at({"four", "sharp", "standardized-clr", "ward", "best"}),
              ElementsAre("4", "1", "1", "1", "0"))
      << "both halves of a room lie in one zone";
  EXPECT_LT(std::stod(found.at({"four", "blind", "standardized-clr", "ward", "best"})[1]), 0.9);
  EXPECT_THAT(found.at({"two", "sharp", "ks", "average", "best"})[4], "")
      << "each room of the table is seen in one run, so that M has no pair";
}

TEST_F(ZoneTables, TellsWhatEstanciaZonesWouldFind) {
  run(few_ + data_);
  const auto found = rows();
  const auto sequence = openSequence(scratch_ / "drive");
  const auto labeler = loadModel(scratch_ / "sharp");
  const DescriptorSequence words = record(*sequence, *labeler);
  Progress silent;
  for (const auto& [distance, linkage] : {std::pair{"standardized-clr", "ward"}, {"ks", "average"}})
    for (const std::string cut : {"0.2", "0.8", "auto"}) {
      ZoneOptions options;
      options.distance = distance;
      options.linkage = linkage;
      if (cut != "auto") options.cut = std::stod(cut);
      const ZoneQuality quality = evaluate(findZones(words, options, silent));
      const auto& row = found.at({"four", "sharp", distance, linkage, cut});
      EXPECT_EQ(std::stoul(row[0]), quality.zones) << distance << " " << cut;
      EXPECT_DOUBLE_EQ(std::stod(row[1]), quality.rooms->vMeasure);
      EXPECT_DOUBLE_EQ(std::stod(row[2]), quality.rooms->adjustedRandIndex);
      EXPECT_DOUBLE_EQ(std::stod(row[3]), quality.rooms->purity);
    }
}

TEST_F(ZoneTables, ClassesComeFromRunsOrAColumn) {
  run(few_ + table_ +
      "run_column = \"half\"\n[[data]]\nname = \"named\"\npath = \"drive\"\ntable = \"table.csv\"\n"
      "image_column = \"number\"\nroom_column = \"kind\"\nclass_column = \"class\"\n");
  const auto found = rows();
  const double runs = std::stod(found.at({"two", "sharp", "standardized-clr", "average", "0.5"})[4]);
  EXPECT_NEAR(runs, 2.0 / 3, 1e-12) << "of four runs in two colors, two of six pairs are alike";
  EXPECT_NEAR(std::stod(found.at({"named", "sharp", "standardized-clr", "average", "0.5"})[4]), 1, 1e-12)
      << "two colors, two zones";
}

TEST_F(ZoneTables, OnlyTheNamedRoomsAreClustered) {
  run(few_ + data_ + "only = [\"room0\", \"room3\"]\n");
  EXPECT_THAT(rows().at({"four", "sharp", "standardized-clr", "ward", "best"}),
              ElementsAre("2", "1", "1", "1", "0"));
}

TEST_F(ZoneTables, AreTheSameForAnyNumberOfThreadsAndComputedOnce) {
  run(few_ + data_ + table_, 1);
  EXPECT_EQ(std::exchange(progress_.computed, 0), 12U);
  const std::string first = readFile(scratch_ / "out/results.csv");
  run(few_ + data_ + table_, 3);
  EXPECT_EQ(progress_.computed, 0U);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), first);
  run("cuts = [\"auto\"]\n" + few_ + data_ + table_, 3);
  EXPECT_EQ(std::exchange(progress_.computed, 0), 12U) << "other cuts";
  fs::remove_all(scratch_ / "out");
  run(few_ + data_ + table_, 5);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), first);
}

TEST_F(ZoneTables, HaveTheThesisBesideWhereItIsAskedFor) {
  const Findings findings = run("thesis_tables = true\n" + few_ + data_);
  const ResultTable& counts = table(findings, "four: zones by τ_d, Eq. 5.1 with average linkage (Table 5.2)");
  ASSERT_EQ(counts.rows.size(), 2U + 8U);
  EXPECT_EQ(counts.rows[2].values[0], 110) << "of the thesis";
  table(findings, "The thesis: distances within categories, Eq. 5.1, τ_d 0.5 (Table 5.3)");
}

TEST_F(ZoneTables, SayTheDefaultBesideEq51) {
  const Findings findings = run(few_ + data_);
  const ResultTable& overview = table(findings, "four: the default beside Eq. 5.1");
  ASSERT_EQ(overview.rows.size(), 2U);
  EXPECT_EQ(overview.rows[0].name, "sharp");
  EXPECT_EQ(overview.columns[6].name, "cost");
  const double v = overview.rows[0].values[0].value(), zones = overview.rows[0].values[1].value();
  EXPECT_EQ(overview.rows[0].values[6], 1 - v) << "the best cut is perfect";
  const ResultTable& counts = table(findings, "four: zones by τ_d, Eq. 5.1 with average linkage (Table 5.2)");
  EXPECT_EQ(counts.columns.size(), 5U);
  EXPECT_EQ(counts.rows.size(), 2U) << "the thesis' are of other data";
  const ResultTable& within =
      table(findings, "four: distances within categories, default, automatic cut (Table 5.3)");
  EXPECT_EQ(within.rows.size(), 4U + 1U) << "a pair of halves in each room, and M";
  EXPECT_EQ(within.rows[0].name, "room0 1 · room0 2");
  EXPECT_EQ(within.rows.back().name, "M");
  const ResultTable& pairs = table(findings, "four: V-measure of sharp, best cut");
  EXPECT_EQ(pairs.rows[1].name, "ks");
  EXPECT_FALSE(pairs.rows[1].values[0]) << "not with ward";
  EXPECT_EQ(test::notesNaming(findings, "ward with ks"), 1U);
  std::size_t charts = 0, matrices = 0;
  for (const auto& section : findings.sections) {
    if (const auto* chart = std::get_if<LineChart>(&section)) {
      ++charts;
      EXPECT_EQ(chart->x.size(), 40U) << "no more zones than images";
      EXPECT_EQ(chart->lines[0].mark, zones) << "the automatic cut";
    }
    if (const auto* matrix = std::get_if<HeatTable>(&section)) {
      ++matrices;
      ASSERT_EQ(matrix->names.size(), 8U) << "few classes are told one by one";
      EXPECT_EQ(matrix->names[0], "room0 1");
      EXPECT_LT(matrix->at(0, 1), matrix->at(0, 2)) << "halves of a room are nearer than rooms";
      EXPECT_EQ(matrix->at(0, 2), matrix->at(2, 0));
    }
  }
  EXPECT_EQ(charts, 2U);
  EXPECT_EQ(matrices, 3U) << "pairs by the default's and the thesis' distance, and Fig. 5.4";
}

TEST_F(ZoneTables, HaveEachCutOfEachOrderOfTheLabelsBeside) {
  const std::string by =
      "cuts = [0.5, \"best\"]\ndistances = [\"ks\", \"cumulative-ks\"]\nlinkages = [\"average\"]\n"
      "each_cut = true\n";
  const std::string shuffled =
      "[[data]]\nname = \"other\"\npath = \"drive\"\nparts = 2\nlabel_order = \"shuffled\"\n";
  const ResultTable v = table(run(by + data_ + shuffled), "V-measure by cut");
  ASSERT_EQ(v.rows.size(), 8U) << "two orders, two models, two distances";
  EXPECT_EQ(v.columns[0].name, "τ_d 0.5");
  EXPECT_EQ(v.rows[0].name, "four, sharp: ks, average");
  EXPECT_EQ(v.rows[4].name, "other, sharp: ks, average");
  EXPECT_EQ(v.rows[0].values, v.rows[4].values) << "the largest difference of a label knows no order";
  EXPECT_EQ(v.rows[0].values[0], std::stod(rows().at({"four", "sharp", "ks", "average", "0.5"})[1]));
  EXPECT_THAT(problem(by + data_ + "label_order = \"size\"\n"), FailsWith(ErrorCode::malformedFile));
}

TEST_F(ZoneTables, OptionalModelsAndDataAreLeftOutWithANote) {
  writeFile(scratch_ / "zones.toml", "type = \"zones\"\nmodels = [\"" + (scratch_ / "sharp").string() +
                                         "\"]\noptional_models = [\"no-such-model\"]\n" + few_ + data_ +
                                         "[[data]]\nname = \"x\"\npath = \"nowhere\"\noptional = true\n");
  const Findings findings =
      runExperiment({scratch_ / "zones.toml"}, {scratch_ / "out", {}, {"", 1}, nullptr}, progress_);
  EXPECT_EQ(test::notesNaming(findings, "no-such-model"), 1U);
  EXPECT_EQ(test::notesNaming(findings, "nowhere"), 1U);
  EXPECT_EQ(progress_.computed, 3U);
}

TEST_F(ZoneTables, WrongKeysAreNamedWithFileAndLine) {
  EXPECT_THAT(problem(""), FailsWith(ErrorCode::malformedFile, "`data`"));
  EXPECT_THAT(problem("distances = [\"kss\"]\n" + data_),
              FailsWith(ErrorCode::malformedFile, "zones.toml:2", "`distances`", "\"ks\""));
  EXPECT_THAT(problem("linkages = [\"centroid\"]\n" + data_),
              FailsWith(ErrorCode::malformedFile, "zones.toml:2", "\"average\""));
  EXPECT_THAT(problem("cuts = [\"automatic\"]\n" + data_),
              FailsWith(ErrorCode::malformedFile, "\"auto\"", "\"best\""));
  EXPECT_THAT(problem("cuts = [-1]\n" + data_),
              FailsWith(ErrorCode::malformedFile, "zones.toml:2", "`cuts`"));
  EXPECT_THAT(problem("cuts = [nan]\n" + data_), FailsWith(ErrorCode::malformedFile, "`cuts`"));
  EXPECT_THAT(problem("cuts = [0.5, 0.5]\n" + data_), FailsWith(ErrorCode::malformedFile, "`cuts`"));
  EXPECT_THAT(problem("cuts = []\n" + data_), FailsWith(ErrorCode::malformedFile, "`cuts`"));
  EXPECT_THAT(problem("max_zones = 0\n" + data_), FailsWith(ErrorCode::malformedFile, "`max_zones`"));
  EXPECT_THAT(problem(data_ + "part = 2\n"), FailsWith(ErrorCode::malformedFile, "`part`"));
  EXPECT_THAT(problem(data_ + "run_column = \"half\"\n"),
              FailsWith(ErrorCode::malformedFile, "zones.toml:6"));
  EXPECT_THAT(problem("[[data]]\npath = \"drive\"\n"), FailsWith(ErrorCode::malformedFile, "`name`"));
}

TEST_F(ZoneTables, WrongDataIsRefused) {
  EXPECT_THAT(problem(few_ + table_ + "class_column = \"klass\"\n"),
              FailsWith(ErrorCode::malformedFile, "table.csv:1", "\"klass\""));
  EXPECT_THAT(problem(few_ + table_ + "class_column = \"half\"\n"),
              FailsWith(ErrorCode::mismatch, "\"warm\"", "\"cold\""));
  EXPECT_THAT(problem(few_ + data_ + "only = [\"attic\"]\n"),
              FailsWith(ErrorCode::insufficientData, "`only`"));
  EXPECT_THAT(problem(few_ + data_ + data_), FailsWith(ErrorCode::invalidInput, "four"));
  fs::remove(scratch_ / "drive/rooms.csv");
  EXPECT_THAT(problem(few_ + data_), FailsWith(ErrorCode::insufficientData, "`table`"));
  EXPECT_THAT(problem("[[data]]\nname = \"x\"\npath = \"nowhere\"\n"),
              FailsWith(ErrorCode::fileNotFound, "nowhere"));
  EXPECT_THAT(problem("[[data]]\nname = \"x\"\npath = \"nowhere\"\noptional = true\n"),
              FailsWith(ErrorCode::insufficientData, "[[data]]"));
  EXPECT_FALSE(fs::exists(scratch_ / "out/results.csv"));
}

TEST(ZoneCell, ReadsBackWhatItTold) {
  ZoneCell cell;
  cell.readings = {{"0.5", 7, 0.25, -0.125, 0.5, 0.75, {{"hall 1 · hall 2", 0.5}, {"lab", 1}}},
                   {"auto", 1, 0, 0, 0.1, std::nullopt, {}}};
  cell.vMeasures = {0, 0.5, 0.25};
  const ZoneCell again = ZoneCell::fromResults(cell.toResults());
  ASSERT_EQ(again.readings.size(), 2U);
  const ZoneReading& half = *again.find("0.5");
  EXPECT_EQ(half.zones, 7U);
  EXPECT_EQ(half.vMeasure, 0.25);
  EXPECT_EQ(half.adjustedRandIndex, -0.125);
  EXPECT_EQ(half.purity, 0.5);
  EXPECT_EQ(half.m, 0.75);
  EXPECT_EQ(half.within, cell.readings[0].within);
  EXPECT_EQ(again.find("auto")->m, std::nullopt);
  EXPECT_EQ(again.find("best"), nullptr);
  EXPECT_EQ(again.vMeasures, cell.vMeasures);
  EXPECT_EQ(again.bestV(), 0.5);
}

}  // namespace
}  // namespace estancia::experiments
