// `estancia experiment` as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/signaled_command.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
namespace fs = std::filesystem;

class ExperimentCommand : public testing::Test {
 protected:
  void SetUp() override {
    panoramas_ = findFetched("panoramas");
    ESTANCIA_NEEDS(panoramas_, "the panoramas are not here; script/bootstrap fetches them");
    writeSmallModel(scratch_ / "model");
    writeConfig(12, 3);
  }

  void writeConfig(int clusters, int repeats) {
    writeFile(config_, "type = \"model-choice\"\nclusters = " + std::to_string(clusters) +
                           "\nshown = [5, 12]\nrepeats = " + std::to_string(repeats) +
                           "\n[[sequence]]\nname = \"tour\"\npath = \"" + panoramas_->string() +
                           "\"\nviews = 4\nradius = 2\n[sequence.again]\nturn = 7\n");
  }

  std::vector<std::string> arguments(std::vector<std::string> more = {}) const {
    std::vector<std::string> all{"experiment",       "run",       config_, "-o", out_.string(), "--models",
                                 scratch_ / "model", "--no-cache"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  std::size_t cellsOnDisk() const {
    std::error_code none;
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(out_ / "cells", none), fs::directory_iterator()));
  }

  ScratchFolder scratch_;
  const std::string config_ = scratch_ / "choice.toml";
  const fs::path out_ = scratch_ / "out";
  std::optional<fs::path> panoramas_;
};

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(ExperimentCommand, PrintsTheTablesAndWritesThePage) {
  const auto result = run(arguments());
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_TRUE(holds(result.out, "\nmodel  k = 5 [%]  k = 12 [%]  mean rank")) << result.out;
  EXPECT_TRUE(holds(result.err, "report.html")) << result.err;
  EXPECT_TRUE(holds(readFile(out_ / "report.html"), "small"));
  EXPECT_TRUE(holds(readFile(out_ / "results.csv"), "\nsmall,tour,standardized-clr,12,"));
  EXPECT_TRUE(holds(readFile(out_ / "findings.md"), "\n| small | "));
  EXPECT_EQ(json::parse(readFile(out_ / "run.json"))["configurations"], json({config_}));
  EXPECT_EQ(cellsOnDisk(), 1U);
}

TEST_F(ExperimentCommand, CellsWithoutAValueAreDashes) {
  writeFile(config_,
            "type = \"zones\"\ndistances = [\"standardized-clr\"]\nlinkages = [\"ward\"]\n"
            "[[data]]\nname = \"tour\"\npath = \"" +
                panoramas_->string() + "\"\nviews = 4\n");
  const auto result = run(arguments());
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("     5.1: V  5.1: zones     5.1: M  5.1: auto V  5.1: best V\n"));
  EXPECT_THAT(result.out, HasSubstr("          –           –          –            –            –\n"));
}

TEST_F(ExperimentCommand, JsonIsForMachines) {
  const auto result = run(arguments({"--json"}));
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const json found = json::parse(result.out);
  const json& row = found["tables"][0]["rows"][0];
  EXPECT_EQ(row["model"], "small");
  EXPECT_EQ(row["mean rank"], 1);
  EXPECT_GT(row["k = 5 [%]"], row["k = 12 [%]"]);
}

TEST_F(ExperimentCommand, WhatIsWrongIsOneLineAndExitCodeTwo) {
  const auto refuses = [](const CommandResult& result, ErrorCode code, const std::string& fact) {
    EXPECT_THAT(result, FailsWith(code, fact));
    EXPECT_EQ(result.out, "");
  };
  refuses(run({"experiment", "run", scratch_ / "none.toml"}), ErrorCode::fileNotFound, "none.toml");
  refuses(run({"experiment", "run", config_, "--models", "./nowhere"}), ErrorCode::fileNotFound, "./nowhere");
  refuses(run(arguments({"--threads", "-1"})), ErrorCode::invalidOption, "threads");
  refuses(run(arguments({"--set", "labeler.engine=bogus"})), ErrorCode::unknownName, "bogus");
  refuses(run({"experiment"}), ErrorCode::invalidOption, "experiment");
  writeFile(config_, readFile(config_) + "exposre = 1\n");
  refuses(run(arguments()), ErrorCode::malformedFile, "choice.toml:12");
  EXPECT_FALSE(fs::exists(out_ / "report.html"));
}

TEST_F(ExperimentCommand, AnInterruptedRunGoesOn) {
  writeConfig(70, 1000);  // far longer than anybody waits
  const int status = signalCommand(
      arguments(), scratch_ / "cache", [&] { return fs::exists(out_ / "cells"); },
      std::chrono::milliseconds(300), SIGINT);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(cellsOnDisk(), 0U) << "no half cell";
  EXPECT_FALSE(fs::exists(out_ / "report.html"));
  writeConfig(12, 2);
  EXPECT_EQ(run(arguments()).exitCode, 0);
  EXPECT_EQ(cellsOnDisk(), 1U);
}

TEST_F(ExperimentCommand, SeveralOfOneTypeAreRunAsOne) {
  const std::string second = scratch_ / "second.toml";
  std::string text = readFile(config_);
  writeFile(second, text);
  const auto twice = run({"experiment", "run", config_, second, "-o", out_.string(), "--models",
                          scratch_ / "model", "--no-cache"});
  EXPECT_EQ(twice.exitCode, 2);
  EXPECT_TRUE(holds(twice.err, "second.toml")) << twice.err;
  text.replace(text.find("\"tour\""), 6, "\"walk\"");
  writeFile(second, text);
  const auto result = run({"experiment", "run", config_, second, "-o", out_.string(), "--models",
                           scratch_ / "model", "--no-cache"});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const std::string csv = readFile(out_ / "results.csv"), page = readFile(out_ / "report.html");
  for (const std::string name : {"tour", "walk"}) {
    EXPECT_TRUE(holds(csv, "\nsmall," + name + ",standardized-clr,12,"));
    EXPECT_TRUE(holds(page, name));
  }
  EXPECT_EQ(csv.rfind("model,"), 0U) << "one head for all";
}

TEST_F(ExperimentCommand, RunsSeveralTypesEachInAFolderOfItsOwn) {
  const std::string second = scratch_ / "second.toml";
  writeFile(second,
            "type = \"zones\"\ndistances = [\"standardized-clr\"]\nlinkages = [\"ward\"]\n"
            "[[data]]\nname = \"tour\"\npath = \"" +
                panoramas_->string() + "\"\nviews = 4\n");
  const auto both = [&] {
    return run({"experiment", "run", config_, second, "-o", out_.string(), "--models", scratch_ / "model",
                "--no-cache"});
  };
  const auto result = both();
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_EQ(readFile(out_ / "model-choice/results.csv").rfind("model,sequence,", 0), 0U);
  EXPECT_TRUE(holds(readFile(out_ / "zones/results.csv"), "ward"));
  EXPECT_FALSE(fs::exists(out_ / "results.csv")) << "there is no table of all";
  const std::string page = readFile(out_ / "report.html");
  for (const char* text : {"small", "standardized-clr", "ward"}) EXPECT_TRUE(holds(page, text));
  writeFile(second, "type = \"zones\"\nlinkage = 3\n");
  fs::remove_all(out_);
  EXPECT_THAT(both(), FailsWith(ErrorCode::malformedFile, "second.toml:2", "linkage"));
  EXPECT_FALSE(fs::exists(out_)) << "nothing is run before all are read";
}

TEST(Experiments, ReadmeNamesEveryOption) {
  const std::string readme = readFile(fs::path(ESTANCIA_LAB_DIR) / "README.md");
  const auto help = run({"experiment", "run", "--help"});
  ASSERT_EQ(help.exitCode, 0) << help.err;
  const std::regex option("\n  (?:-[a-z],)?(--[a-z-]+)");
  std::size_t options = 0;
  for (std::sregex_iterator it(help.out.begin(), help.out.end(), option), end; it != end; ++it, ++options)
    EXPECT_TRUE((*it)[1] == "--help" || holds(readme, "`" + (*it)[1].str())) << (*it)[1];
  EXPECT_GE(options, 10U);
}

TEST(Experiments, OfTheRepositoryAreReadable) {
  const ScratchFolder scratch;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(ESTANCIA_LAB_DIR) / "experiments")) {
    if (entry.path().extension() != ".toml" || entry.path().parent_path().filename() == "studies") continue;
    if (!holds(readFile(entry.path()), "\ntype = ")) continue;  // what several experiments share
    const auto result =
        run({"experiment", "run", entry.path(), "-o", scratch / "out", "--models", "./no-such-model"});
    // Some have features instead of images, and need no model.
    EXPECT_TRUE(holds(result.err, "no-such-model") || holds(result.err, "robotvision"))
        << entry.path() << " is read before that: " << result.err;
  }
}

/// The figures that the project promises, by the repository's own configurations with the grid made small.
TEST(ZonesExperiment, FindsTheRoomsAndPlacesByItself) {
  const auto rooms = findData("nyuv2_half"), panoramas = findFetched("panoramas"),
             inception = findFetched("models/inception-v3/inception-v3.onnx"),
             coco = findFetched("models/coco-ssd/coco-ssd.onnx");
  ESTANCIA_NEEDS(rooms && panoramas && inception && coco,
                 "the rooms, the panoramas or the networks are not here");
  const ScratchFolder scratch;
  std::vector<std::string> arguments{"experiment", "run"};
  for (const std::string name : {"nyu.toml", "tour.toml"}) {
    std::string text = readFile(fs::path(ESTANCIA_LAB_DIR) / "experiments/zones" / name);
    const auto first = text.find("\n[[data]]") + 1, second = text.find("\n[[data]]", first);
    text = text.substr(0, second);  // labeling once will do
    text.insert(first, "distances = [\"standardized-clr\", \"ks\"]\nlinkages = [\"ward\", \"average\"]\n");
    writeFile(scratch / name, text);
    arguments.push_back(scratch / name);
  }
  arguments.insert(arguments.end(), {"-o", scratch / "out", "--models", "inception-v3+coco-ssd"});
  const auto result = run(arguments);
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const std::string csv = readFile(scratch / "out/results.csv");
  EXPECT_THAT(csv, testing::StartsWith("data,model,distance,linkage,cut,zones,v_measure,ari,purity,m\n"));
  const auto vMeasure = [&csv](const std::string& row) {
    const auto begin = csv.find("\n" + row + ",");
    if (begin == std::string::npos) throw std::runtime_error("no row " + row);
    return std::stod(csv.substr(csv.find(',', begin + row.size() + 2) + 1));
  };
  for (const auto& [data, least] : {std::pair{"nyuv2_half", 0.45}, {"tour", 0.93}}) {
    const std::string ours = std::string(data) + ",inception-v3+coco-ssd,standardized-clr,ward,",
                      thesis = std::string(data) + ",inception-v3+coco-ssd,ks,average,";
    EXPECT_GE(vMeasure(ours + "auto"), least);
    EXPECT_LE(vMeasure(ours + "best") - vMeasure(ours + "auto"), 0.03);
    EXPECT_GT(vMeasure(ours + "auto"), vMeasure(thesis + "best") + 0.1) << "far better than Eq. 5.1";
  }
}

}  // namespace
}  // namespace estancia::test
