// Pages of zones through the command, from words that were made elsewhere.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using testing::HasSubstr;

class ZonesReport : public testing::Test {
 protected:
  void SetUp() override {
    std::string words = "image,kettle,bed,desk\n";
    for (int i = 0; i < 30; ++i) {
      const std::string rest = std::to_string(0.01 + 0.001 * (i % 7));
      words += "frame" + std::to_string(i) +
               (i < 10   ? ",0.9," + rest + "," + rest
                : i < 20 ? "," + rest + ",0.9," + rest
                         : "," + rest + "," + rest + ",0.9") +
               "\n";
    }
    writeFile(scratch_ / "words.csv", words);
    writeFile(scratch_ / "others.csv", "image,kettle\nelsewhere,0.5\n");
    const std::string csv = scratch_ / "words.csv";
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"map", csv, "-o", map_},
          {"zones", "find", map_, "-o", zones_, "--preset", "thesis"},
          {"zones", "find", scratch_ / "others.csv", "-o", scratch_ / "others.zones"}}) {
      const auto result = run(command);
      ASSERT_EQ(result.exitCode, 0) << result.err;
    }
  }

  std::string report(const std::string& file, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"report", file, "-o", page_, "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return readFile(page_);
  }

  CommandResult refused(const std::string& file, std::vector<std::string> more) {
    std::vector<std::string> arguments{"report", file, "-o", scratch_ / "refused.html"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run(arguments);
    EXPECT_FALSE(std::filesystem::exists(scratch_ / "refused.html"));
    return result;
  }

  ScratchFolder scratch_;
  const std::string map_ = scratch_ / "run.estancia", zones_ = scratch_ / "run.zones";
  const std::string page_ = scratch_ / "page.html";
};

TEST_F(ZonesReport, ShowsZonesByThemselves) {
  const std::string html = report(zones_, {"--title", "Three rooms"});
  for (const char* shown : {"<h1>Three rooms</h1>", "<dt>zones</dt><dd>3</dd>", "kettle"})
    EXPECT_THAT(html, HasSubstr(shown));
  EXPECT_THAT(report(zones_, {"--map", map_}), HasSubstr("kettle")) << "a map without images";
}

TEST_F(ZonesReport, ShowsZonesOverAMap) {
  EXPECT_THAT(report(map_, {"--zones", zones_}), HasSubstr("In zone 0, "));
  EXPECT_THAT(report(map_), testing::Not(HasSubstr("In zone")));
}

TEST_F(ZonesReport, FamiliarWordsStandForSeveralLabelsUnlessTheyAreToBeRaw) {
  std::string words = "image,golden retriever,beagle,Labrador retriever,desk\n";
  for (int i = 0; i < 20; ++i)
    words += "frame" + std::to_string(i) + (i < 10 ? ",0.3,0.25,0.2,0.1\n" : ",0.01,0.01,0.01,0.9\n");
  writeFile(scratch_ / "dogs.csv", words);
  const std::string map = scratch_ / "dogs.estancia", zones = scratch_ / "dogs.zones";
  ASSERT_EQ(run({"map", scratch_ / "dogs.csv", "-o", map}).exitCode, 0);
  const std::vector<std::string> find{"zones",   "find", map,           "-o",    zones,
                                      "--count", "2",    "--overwrite", "--json"};
  const auto said = run(find);
  EXPECT_THAT(said.out, HasSubstr("\"word\":\"dog\"")) << said.err;
  for (const std::string& file : {map, zones}) {
    EXPECT_THAT(report(file), HasSubstr(">dog</span>"));
    EXPECT_THAT(report(file, {"--words", "raw"}), testing::Not(HasSubstr(">dog</span>")));
    EXPECT_THAT(report(file, {"--words", "raw"}), HasSubstr(">golden retriever</span>"));
  }
  EXPECT_THAT(report(map), HasSubstr("<h3>dog</h3>"));
  EXPECT_THAT(refused(map, {"--words", "some"}), FailsWith(ErrorCode::unknownName, "some"));
  std::vector<std::string> raw = find;
  raw.insert(raw.end(), {"--words", "raw"});
  EXPECT_THAT(run(raw).out, testing::Not(HasSubstr("\"dog\"")));
  const WithoutWordNet plain;
  EXPECT_THAT(report(map), testing::Not(HasSubstr(">dog</span>")));
}

TEST_F(ZonesReport, RefusesWhatDoesNotGoTogether) {
  EXPECT_THAT(refused(map_, {"--zones", scratch_ / "others.zones"}), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(refused(map_, {"--zones", map_}), FailsWith(ErrorCode::unsupportedFile, map_));
  EXPECT_THAT(refused(map_, {"--map", map_}), FailsWith(ErrorCode::invalidOption, "--map", map_));
  EXPECT_THAT(refused(zones_, {"--label", "bed"}), FailsWith(ErrorCode::invalidOption, "--label"));
  EXPECT_THAT(refused(zones_, {"--zones", zones_}), FailsWith(ErrorCode::invalidOption, "--zones"));
  EXPECT_THAT(refused(zones_, {"--map", zones_}), FailsWith(ErrorCode::unsupportedFile, zones_));
  writeFile(scratch_ / "cut.zones", readFile(zones_).substr(0, 900));
  EXPECT_THAT(refused(scratch_ / "cut.zones", {}), FailsWith(ErrorCode::corruptFile, "cut.zones"));
}

}  // namespace
}  // namespace estancia::test
