// What people and scripts type: options, numbers and names, and the completion of them.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/json_of.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::ElementsAre;
using testing::IsSupersetOf;
using testing::Not;

class Options : public testing::Test {
 protected:
  void SetUp() override {
    std::string words = "image,kettle,bed,desk\n";
    for (int i = 0; i < 12; ++i)
      words += "frame" + std::to_string(i) + (i < 6 ? ",0.9,0.05,0.0" : ",0.05,0.9,0.0") +
               std::to_string(i % 6) + "\n";
    writeFile(words_, words);
  }

  CommandResult zones(const std::vector<std::string>& more) const {
    return run({"zones", "find", words_, "-o", scratch_ / "home.zones", "--overwrite", "--json"}, more);
  }
  json found(std::vector<std::string> more) const { return jsonOf(zones(std::move(more))); }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const std::string words_ = scratch_ / "words.csv", config_ = scratch_ / "run.toml";
};

TEST_F(Options, AFlagBeatsSetBeatsConfigBeatsPreset) {
  writeFile(config_, "[zones]\nlinkage = \"complete\"\ncut = 0.6\n[mapper]\ntau_join = 1\n");
  const json preset = found({"--preset", "thesis"});
  EXPECT_EQ(preset["distance"], "ks");
  EXPECT_EQ(preset["linkage"], "average");
  EXPECT_EQ(preset["cut"], 0.5);
  const json config = found({"--config", config_, "--preset", "thesis"});
  EXPECT_EQ(config["distance"], "ks");
  EXPECT_EQ(config["linkage"], "complete");
  EXPECT_EQ(config["cut"], 0.6);
  const json set = found({"--set", "zones.cut=0.7", "--config", config_, "--preset", "thesis"});
  EXPECT_EQ(set["linkage"], "complete");
  EXPECT_EQ(set["cut"], 0.7);
  const json flag =
      found({"--cut", "0.8", "--set", "zones.cut=0.7", "--config", config_, "--distance", "l1"});
  EXPECT_EQ(flag["cut"], 0.8);
  EXPECT_EQ(flag["distance"], "l1");
  EXPECT_EQ(found({"--preset", "thesis", "--set", "zones.cut=auto", "--count", "3"})["zones"].size(), 3U);
}

TEST_F(Options, ReachEveryStructOfTheCommand) {
  const std::string map = scratch_ / "home.estancia";
  const auto mapped = run({"map", words_, "-o", map, "--set", "mapper.tau-join=0.5", "--set",
                           "mapper.thresholds.revisit_ratio=0.2", "--json"});
  ASSERT_EQ(mapped.exitCode, 0) << mapped.err;
  EXPECT_EQ(json::parse(mapped.out)["tau_join"], 0.5);
  EXPECT_EQ(json::parse(mapped.out)["tau_revisit"], 0.1);
  EXPECT_EQ(json::parse(run({"map", words_, "-o", scratch_ / "late.estancia", "--set", "label-stream.first=4",
                             "--json"})
                            .out)["frames"],
            8);
  EXPECT_EQ(run({"localize", map, words_, "--set", "localizer.filter.near-angle=40"}).exitCode, 0);
}

TEST_F(Options, OfAMapAreToldWhereAPresetHasOthers) {
  const std::string map = scratch_ / "home.estancia";
  ASSERT_EQ(run({"map", words_, "-o", map}).exitCode, 0);
  const auto preset = run({"map", words_, "-o", map, "--continue", "--preset", "thesis"});
  EXPECT_THAT(preset, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(preset.err, testing::ContainsRegex("tau-join is automatic in the map, and 0.015 is given"));
  EXPECT_EQ(run({"map", words_, "-o", map, "--continue"}).exitCode, 0);
}

TEST_F(Options, ThatAreWrongAreRefused) {
  const std::string broken = scratch_ / "broken.toml", unknown = scratch_ / "unknown.toml",
                    group = scratch_ / "group.toml";
  writeFile(broken, "[zones]\ncut = \"soon\"\n");
  writeFile(unknown, "[recognition]\nacept = 0.5\n");  // option of another command, and no parameter of it
  writeFile(group, "[zone]\ncut = 1\n");
  const std::vector<std::pair<std::vector<std::string>, ErrorCode>> refused{
      {{"--set", "zone.cut=1"}, ErrorCode::unknownName},
      {{"--set", "mapper.tau-join=1"}, ErrorCode::unknownName},
      {{"--set", "zones.cut"}, ErrorCode::invalidOption},
      {{"--set", "zones.cut=-1"}, ErrorCode::invalidOption},
      {{"--threads", "-1"}, ErrorCode::invalidOption},
      {{"--preset", "mine"}, ErrorCode::unknownName},
      {{"--config", config_}, ErrorCode::fileNotFound},
      {{"--config", ""}, ErrorCode::invalidOption},
      {{"--config", scratch_.path()}, ErrorCode::unsupportedFile},
      {{"--config", broken}, ErrorCode::malformedFile},
      {{"--config", unknown}, ErrorCode::malformedFile},
      {{"--config", group}, ErrorCode::malformedFile}};
  for (const auto& [more, code] : refused)
    EXPECT_THAT(zones(more), FailsWith(code)) << testing::PrintToString(more);
  writeFile(config_, "[mapper]\ntau-join = 1\n[zones]\ncut = 0.6\n");
  EXPECT_EQ(found({"--config", config_})["cut"], 0.6);
}

TEST_F(Options, WithoutEffectAreRefused) {
  const std::string map = scratch_ / "home.estancia";
  ASSERT_EQ(run({"map", words_, "-o", map}).exitCode, 0);
  EXPECT_THAT(run({"export", map, "--format", "json", "--frame", "map"}),
              FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(run({"report", map, "-o", scratch_ / "home.html", "--extent", "0", "0", "1", "1"}),
              FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(run({"map", "", "-o", map}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(run({"ask", map, ""}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(run({"check", map}), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(run({"map", map, "-o", scratch_ / "other.estancia"}), FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(Options, AreListedWithTheirCommands) {
  const json groups = json::parse(run({"options", "--json"}).out);
  EXPECT_THAT(groups["mapper"]["commands"], ElementsAre("map", "live"));
  EXPECT_THAT(groups["localizer"]["commands"], ElementsAre("live", "localize", "evaluate"));
  EXPECT_THAT(groups["odometry"]["commands"], ElementsAre("odometry estimate"));
  EXPECT_EQ(groups["zones"]["options"]["linkage"]["default"], "ward");
  EXPECT_EQ(groups["mapper"]["options"]["thresholds"]["revisit-ratio"]["default"], "0.4");
  for (const auto& [name, group] : groups.items()) EXPECT_FALSE(group["commands"].empty()) << name;
  EXPECT_EQ(json::parse(run({"options", "zones", "--json"}).out).size(), 1U);
  EXPECT_THAT(run({"options", "zone"}), FailsWith(ErrorCode::unknownName));
  EXPECT_EQ(groups["zones"]["options"]["linkage"]["flags"], json({"--linkage"}));
  const auto one = run({"options", "mapper.tau-join"});
  EXPECT_THAT(one.out, testing::StartsWith("mapper.tau-join = "));
  EXPECT_EQ(std::ranges::count(one.out, '\n'), 2);
  EXPECT_THAT(run({"options", "mapper.tau"}), FailsWith(ErrorCode::unknownName));
}

class HostileWords : public testing::Test {
 protected:
  void SetUp() override {
    std::string lines = "image,mug,desk,tree\n";
    for (int i = 0; i < 40; ++i)
      lines +=
          fmt::format("i{}.png,{},{},0.05\n", i, i / 10 % 2 == 0 ? 0.9 : 0.05, i / 10 % 2 == 0 ? 0.05 : 0.9);
    writeFile(labels_, lines);
  }
  CommandResult map(const std::string& output) const { return run({"map", labels_, "-o", output}); }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder folder_;
  const fs::path labels_ = folder_ / "labels.csv";
};

TEST_F(HostileWords, NumbersAreWholeAndInTheirRange) {
  const fs::path file = folder_ / "a.estancia";
  ASSERT_EQ(map(file).exitCode, 0);
  EXPECT_THAT(run({"ask", file, "mug", "b", "c"}), FailsWith(ErrorCode::invalidOption)) << "surplus words";
  for (const std::string number : {"-1", "0", "abc", "1.5", "99999999999999999999", "nan", ""})
    EXPECT_THAT(run({"ask", file, "mug", "-n", number}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(run({"localize", file, labels_, "--lookahead", "-1"}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(run({"drives", file, "--undo", "kitchen"}), FailsWith(ErrorCode::invalidOption));
}

TEST_F(HostileWords, OutputsThatCannotBeAreToldBeforeTheWork) {
  const std::string tooLong(300, 'a');
  fs::create_symlink("circle", folder_ / "circle");
  for (const std::string command : {"map", "label"}) {
    EXPECT_THAT(run({command, labels_, "-o", folder_ / (tooLong + ".labels")}),
                FailsWith(ErrorCode::fileUnwritable));
    EXPECT_THAT(run({command, labels_, "-o", ""}), FailsWith(ErrorCode::invalidOption));
  }
  EXPECT_THAT(map(folder_ / "circle"), FailsWith(ErrorCode::fileUnwritable));
  fs::create_symlink("there.estancia", folder_ / "link.estancia");
  EXPECT_EQ(map(folder_ / "link.estancia").exitCode, 0) << "the file is made where the link leads";
  EXPECT_TRUE(fs::is_regular_file(folder_ / "there.estancia"));
}

/// What bash offers after `line`, whose last word is being typed.
std::vector<std::string> offered(const std::string& line) {
  const std::string script = "source <(" ESTANCIA_COMMAND " generate bash); COMP_WORDS=(" + line +
                             "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _estancia; "
                             "printf '%s\\n' \"${COMPREPLY[@]}\"";
  const auto result = runProgram("bash", {"-c", script});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  std::vector<std::string> words;
  std::istringstream lines(result.out);
  for (std::string word; std::getline(lines, word);)
    if (!word.empty()) words.push_back(word);
  return words;
}

TEST(Generate, BashOffersCommandsOptionsAndValues) {
  EXPECT_THAT(offered("estancia ro"), ElementsAre("route"));
  EXPECT_THAT(offered("estancia zones ''"), IsSupersetOf({"find"}));
  EXPECT_THAT(offered("estancia zones find --li"), ElementsAre("--linkage"));
  EXPECT_THAT(offered("estancia zones find --linkage c"), ElementsAre("complete"));
  EXPECT_THAT(offered("estancia export home.estancia --format ''"),
              ElementsAre("graphml", "json", "nav2", "rooms", "spark-dsg"));
  EXPECT_THAT(offered("estancia export home.estancia --max-words ''"), Not(Contains("graphml")));
}

TEST(Generate, ManPagesNameWhatTheCommandHas) {
  const ScratchFolder scratch;
  const std::string folder = scratch / "man";
  ASSERT_EQ(run({"generate", "man", "-o", folder}).exitCode, 0);
  const std::string page = readFile(folder + "/estancia-zones-find.1");
  EXPECT_THAT(page, testing::StartsWith(".TH estancia\\-zones\\-find 1"));
  EXPECT_THAT(page, testing::ContainsRegex("\\.B \\\\-\\\\-linkage NAME"));
  EXPECT_THAT(run({"generate", "man", "-o", folder}), FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(run({"generate", "man", "-o", folder, "--overwrite"}).exitCode, 0);
}

}  // namespace
}  // namespace estancia::test
