// Missing labels: what is kept of descriptors, orders of places, and the experiment on made-up images.
// SPDX-License-Identifier: Apache-2.0
#include "places/missing_labels.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "color_drive.hpp"
#include "places/place_orders.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;
using testing::FloatEq;

TEST(MissingLabels, TheBestAreKeptAndTheOthersStandForWhatIsAsked) {
  DescriptorMatrix all(5);
  all.append(std::vector<float>{0.1F, 0.5F, 0.05F, 0.3F, 0.05F});
  const auto row = [&](std::size_t best, Missing missing) {
    const DescriptorMatrix kept = withBest(all, best, missing);
    return std::vector<float>(kept.row(0).begin(), kept.row(0).end());
  };
  EXPECT_THAT(row(2, Missing::half), ElementsAre(0, 0.5F, 0, 0.3F, 0));
  EXPECT_THAT(row(2, Missing::share),
              ElementsAre(FloatEq(0.2F / 3), 0.5F, FloatEq(0.2F / 3), 0.3F, FloatEq(0.2F / 3)));
  EXPECT_THAT(row(1, Missing::share)[0], FloatEq(0.125F));
  EXPECT_THAT(row(2, Missing::floor), ElementsAre(1e-12F, 0.5F, 1e-12F, 0.3F, 1e-12F));
  EXPECT_EQ(row(0, Missing::floor), row(5, Missing::half));
}

TEST(PlaceOrders, KeepTheFramesOfAStayTogether) {
  std::vector<Frame> frames(7);
  const char* rooms[] = {"a", "a", "b", "b", "c", "a", "a"};
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].room = rooms[i];
  const auto orders = ordersOfStays(frames, 5);
  ASSERT_EQ(orders.size(), 5U);
  for (const auto& order : orders) {
    EXPECT_TRUE(std::is_permutation(order.begin(), order.end(), orders[0].begin()));
    for (const std::size_t first : {0U, 2U}) {
      const auto at = std::ranges::find(order, first);
      EXPECT_EQ(at[1], first + 1);
    }
  }
  EXPECT_NE(orders[0], orders[1]);
  EXPECT_EQ(orders, ordersOfStays(frames, 5));
}

TEST(MissingLabelsExperiment, MapsAndClassifiesColors) {
  const test::ScratchFolder scratch;
  test::writeColorModel(scratch, "sharp", "0.02");
  for (const char* drive : {"drive", "again"}) test::writeColorDrive(scratch / drive, drive[0]);
  const std::string head =
      "type = \"missing-labels\"\nbest = [2, 0]\norders = 2\n[[drive]]\npath = \"drive\"\n";
  writeFile(scratch / "all.toml", head +
                                      "name = \"places\"\n[drive.again]\npath = \"again\"\n[[drive]]\npath = "
                                      "\"drive\"\nname = \"rooms\"\n[drive.test]\npath = \"again\"\n");
  const auto run = [&] {
    Progress progress;
    return runExperiment({scratch / "all.toml"}, {scratch / "out", {scratch / "sharp"}, {"", 1}, nullptr},
                         progress);
  };
  const Findings found = run();
  ASSERT_EQ(found.sections.size(), 2U);
  for (const auto& section : found.sections) {
    const auto& table = std::get<ResultTable>(section);
    ASSERT_EQ(table.rows.size(), 2U) << table.title;
    EXPECT_EQ(table.rows[1].name, "all");
    for (const auto& row : table.rows) EXPECT_GT(row.values[0].value(), 0.9) << table.title << row.name;
  }
  writeFile(scratch / "all.toml", head + "name = \"neither\"\n");
  EXPECT_THAT([&] { run(); }, FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia::experiments
