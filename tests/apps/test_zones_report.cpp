// Pages of zones through the command, from words that were made elsewhere.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
          {"zones", map_, "-o", zones_, "--preset", "thesis"},
          {"zones", scratch_ / "others.csv", "-o", scratch_ / "others.zones"}}) {
      const auto result = run(command);
      ASSERT_EQ(result.exitCode, 0) << result.err;
    }
  }

  std::string report(const std::string& file, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"report", file, "-o", page_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return readFile(page_);
  }

  std::string refusal(const std::string& file, std::vector<std::string> more) {
    std::vector<std::string> arguments{"report", file, "-o", scratch_ / "refused.html"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run(arguments);
    EXPECT_EQ(result.exitCode, 2);
    EXPECT_FALSE(std::filesystem::exists(scratch_ / "refused.html"));
    return result.err;
  }

  ScratchFolder scratch_;
  const std::string map_ = scratch_ / "run.estancia", zones_ = scratch_ / "run.zones";
  const std::string page_ = scratch_ / "page.html";
};

TEST_F(ZonesReport, ShowsZonesByThemselves) {
  const std::string html = report(zones_, {"--title", "Three rooms"});
  EXPECT_THAT(html, HasSubstr("<h1>Three rooms</h1>"));
  EXPECT_THAT(html, HasSubstr("<dt>zones</dt><dd>3</dd>"));
  EXPECT_THAT(html, HasSubstr("kettle"));
  EXPECT_THAT(report(zones_, {"--map", map_}), HasSubstr("kettle")) << "a map without images";
}

TEST_F(ZonesReport, ShowsZonesOverAMap) {
  EXPECT_THAT(report(map_, {"--zones", zones_}), HasSubstr("In zone 0, "));
  EXPECT_THAT(report(map_), testing::Not(HasSubstr("In zone")));
}

TEST_F(ZonesReport, RefusesWhatDoesNotGoTogether) {
  EXPECT_THAT(refusal(map_, {"--zones", scratch_ / "others.zones"}), HasSubstr("another run"));
  EXPECT_THAT(refusal(map_, {"--zones", map_}), HasSubstr("zone"));
  EXPECT_THAT(refusal(map_, {"--map", map_}), HasSubstr("is a map"));
  EXPECT_THAT(refusal(zones_, {"--label", "bed"}), HasSubstr("--label goes with a map"));
  EXPECT_THAT(refusal(zones_, {"--zones", zones_}), HasSubstr("--zones goes with a map"));
  EXPECT_THAT(refusal(zones_, {"--map", zones_}), HasSubstr("error: "));
  writeFile(scratch_ / "cut.zones", readFile(zones_).substr(0, 900));
  EXPECT_THAT(refusal(scratch_ / "cut.zones", {}), HasSubstr("damaged or cut short"));
}

}  // namespace
}  // namespace estancia::test
