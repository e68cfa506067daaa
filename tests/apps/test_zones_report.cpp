// Pages of zones through the command, from words that were made elsewhere.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

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

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const std::string map_ = scratch_ / "run.estancia", zones_ = scratch_ / "run.zones";
  const std::string page_ = scratch_ / "page.html";
};

TEST_F(ZonesReport, ShowsZonesByThemselvesAndOverAMap) {
  const std::string html = report(zones_, {"--title", "Three rooms", "--map", map_});
  for (const char* shown : {"<h1>Three rooms</h1>", "<dt>zones</dt><dd>3</dd>", "kettle"})
    EXPECT_NE(html.find(shown), std::string::npos) << shown;
  EXPECT_NE(report(map_, {"--zones", zones_}).find("In zone 0, "), std::string::npos);
}

TEST_F(ZonesReport, RefusesWhatDoesNotGoTogether) {
  EXPECT_THAT(refused(map_, {"--zones", scratch_ / "others.zones"}), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(refused(map_, {"--zones", map_}), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(refused(map_, {"--map", map_}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(refused(zones_, {"--label", "bed"}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(refused(zones_, {"--zones", zones_}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(refused(zones_, {"--map", zones_}), FailsWith(ErrorCode::unsupportedFile));
  writeFile(scratch_ / "cut.zones", readFile(zones_).substr(0, 900));
  EXPECT_THAT(refused(scratch_ / "cut.zones", {}), FailsWith(ErrorCode::corruptFile));
}

}  // namespace
}  // namespace estancia::test
