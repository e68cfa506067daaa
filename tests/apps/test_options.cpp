// Parameters of the library from the command line: --preset, --config, --set, flags, and `estancia options`.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;

class Options : public testing::Test {
 protected:
  void SetUp() override {
    std::string words = "image,kettle,bed,desk\n";
    for (int i = 0; i < 12; ++i)
      words += "frame" + std::to_string(i) + (i < 6 ? ",0.9,0.05,0.0" : ",0.05,0.9,0.0") +
               std::to_string(i % 6) + "\n";
    writeFile(words_, words);
  }

  CommandResult zones(std::vector<std::string> more) const {
    more.insert(more.begin(),
                {"zones", "find", words_, "-o", scratch_ / "home.zones", "--overwrite", "--json"});
    return run(more);
  }
  json found(std::vector<std::string> more) const {
    const auto result = zones(std::move(more));
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }

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

}  // namespace
}  // namespace estancia::test
