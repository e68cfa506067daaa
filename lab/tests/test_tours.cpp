// Tours: their order, and made-up places that are mapped.
// SPDX-License-Identifier: Apache-2.0
#include "places/tours.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "color_drive.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::writeFile;

TEST(Tours, VisitEachPlaceAsOftenAndNoneTwiceInARow) {
  for (const auto& [visit, frames] :
       {std::pair{Visit::views, 12U}, {Visit::turning, 36U}, {Visit::standing, 90U}}) {
    const auto tour = tourOf({1, 4, 5}, 144, 10, visit, 3);
    ASSERT_EQ(tour.size(), 3 * 10 * frames);
    std::map<std::size_t, std::size_t> count;
    for (std::size_t i = 0; i < tour.size(); ++i) ++count[tour[i] / 144];
    EXPECT_EQ(count,
              (std::map<std::size_t, std::size_t>{{1, 10 * frames}, {4, 10 * frames}, {5, 10 * frames}}));
    for (std::size_t i = frames; i < tour.size(); i += frames)
      EXPECT_NE(tour[i] / 144, tour[i - 1] / 144) << "stay " << i / frames;
    EXPECT_EQ(tour, tourOf({1, 4, 5}, 144, 10, visit, 3));
    EXPECT_NE(tour, tourOf({1, 4, 5}, 144, 10, visit, 4));
  }
}

TEST(Tours, LookAllAround) {
  const auto tour = tourOf({0}, 36, 1, Visit::turning, 1);
  EXPECT_EQ(std::set<std::size_t>(tour.begin(), tour.end()).size(), 36U);
  const auto coarse = tourOf({2}, 12, 2, Visit::turning, 1);
  EXPECT_EQ(std::set<std::size_t>(coarse.begin(), coarse.end()).size(), 12U);
  EXPECT_GE(*std::min_element(coarse.begin(), coarse.end()), 24U);
}

std::string configOf(const std::string& drive) {
  return "type = \"tours\"\nvisits = [2]\ntours = 2\n[[drive]]\nname = \"rooms\"\npath = \"drive\"\n" + drive;
}

TEST(ToursExperiment, MapsToursOfColors) {
  const test::ScratchFolder scratch;
  test::writeColorModel(scratch, "sharp", "0.02");
  test::writeColorDrive(scratch / "drive", 1);
  writeFile(scratch / "tours.toml", configOf("places = [2]\n"));
  const auto runTours = [&] {
    Progress progress;
    return runExperiment({scratch / "tours.toml"}, {scratch / "out", {scratch / "sharp"}, {"", 1}, nullptr},
                         progress);
  };
  EXPECT_THAT(test::caught([&] { runTours(); }), FailsWith(ErrorCode::insufficientData, "10 images"));
  // Nine images each.
  std::string rooms = "image,room\n";
  for (int i = 0; i < 40; ++i) {
    const std::string name = (i < 10 ? "000" : "00") + std::to_string(i) + ".png";
    if (i % 10 == 9)
      std::filesystem::remove(scratch / "drive" / name);
    else
      rooms += name + ",room" + std::to_string(i / 10) + "\n";
  }
  writeFile(scratch / "drive" / "rooms.csv", rooms);
  std::filesystem::remove(scratch / "drive" / "poses.txt");
  const Findings found = runTours();
  ASSERT_EQ(found.sections.size(), 1U);
  const auto& table = std::get<ResultTable>(found.sections[0]);
  ASSERT_EQ(table.rows.size(), 1U);
  EXPECT_EQ(table.rows[0].name, "2 places, 2 visits");
  for (std::size_t visit = 0; visit < 3; ++visit) EXPECT_GT(table.rows[0].values[visit], 0.9) << visit;
  EXPECT_EQ(table.rows[0].values[3], 2.0);

  writeFile(scratch / "tours.toml", configOf("places = [3]\nhalf = \"second\"\n"));
  EXPECT_THAT(test::caught([&] { runTours(); }), FailsWith(ErrorCode::insufficientData, "2 places"));
}

}  // namespace
}  // namespace estancia::experiments
