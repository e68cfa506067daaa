// Eq. 5.2 and its tables: by hand, by definition, and with the thesis' own numbers.
// SPDX-License-Identifier: Apache-2.0
#include "zones/category_spread.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "support/errors.hpp"
#include "support/support.hpp"
#include "zones/recordings.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::recordingOf;
using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr double tight = 1e-12;

TEST(Categories, AreMeasuredByHowTheirClassesSpreadOverTheZones) {
  // Corridor 1 lies half in zone 0, half in zone 1; corridor 2 all in zone 1; corridor 3 all in zone 0.
  const std::vector<int> zones{0, 1, 1, 1, 0, 5};
  const std::vector<ImageClass> classes{{"corridor", "c1"}, {"corridor", "c1"}, {"corridor", "c2"},
                                        {"corridor", "c2"}, {"corridor", "c3"}, {"hall", "h"}};
  const CategorySpread spread = measureCategories(zones, classes);
  ASSERT_EQ(spread.pairs.size(), 3U) << "the only class of its category has nothing to be compared with";
  EXPECT_EQ(spread.pairs[0].first, "c1");
  EXPECT_EQ(spread.pairs[0].second, "c2");
  EXPECT_EQ(spread.pairs[0].category, "corridor");
  EXPECT_NEAR(spread.pairs[0].distance, 0.5, tight);  // √(½² + ½²) / √2
  EXPECT_NEAR(spread.pairs[1].distance, 0.5, tight);
  EXPECT_NEAR(spread.pairs[2].distance, 1.0, tight) << "nothing in common";
  EXPECT_NEAR(spread.m.value(), 2.0 / 3, tight);
}

TEST(Categories, OfTheSameZonesAreAtZero) {
  const CategorySpread spread = measureCategories(
      std::vector<int>{3, 4, 3, 4, 3, 4},
      std::vector<ImageClass>{{"k", "a"}, {"k", "a"}, {"k", "b"}, {"k", "b"}, {"k", ""}, {"k", ""}});
  EXPECT_EQ(spread.pairs.size(), 1U) << "images without a class are left out";
  EXPECT_NEAR(spread.m.value(), 0, tight);
}

TEST(Categories, WithoutAPairHaveNoMeasure) {
  EXPECT_FALSE(measureCategories(std::vector<int>{0}, std::vector<ImageClass>{{"a", "b"}}).m);
  EXPECT_FALSE(measureCategories({}, {}).m);
}

/// Eq. 5.2 word for word.
double slowM(const std::vector<int>& zones, const std::vector<ImageClass>& classes, int zoneCount) {
  std::set<std::string> categories, names;
  for (const ImageClass& c : classes) {
    categories.insert(c.category);
    names.insert(c.name);
  }
  double numerator = 0, denominator = 0;
  for (const std::string& category : categories) {
    std::vector<std::vector<double>> distributions;
    for (const std::string& name : names) {
      std::vector<double> shares(static_cast<std::size_t>(zoneCount));
      double images = 0;
      for (std::size_t i = 0; i < zones.size(); ++i)
        if (classes[i].category == category && classes[i].name == name) {
          ++shares[static_cast<std::size_t>(zones[i])];
          ++images;
        }
      for (double& share : shares) share /= images;
      if (images > 0) distributions.push_back(shares);
    }
    for (std::size_t i = 0; i < distributions.size(); ++i)
      for (std::size_t j = i + 1; j < distributions.size(); ++j) {
        double sum = 0;
        for (std::size_t z = 0; z < distributions[i].size(); ++z)
          sum += std::pow(distributions[i][z] - distributions[j][z], 2);
        numerator += std::sqrt(sum) / std::numbers::sqrt2;
        ++denominator;
      }
  }
  return numerator / denominator;
}

TEST(Categories, AgreeWithTheDefinition) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<int> zones;
    std::vector<ImageClass> classes;
    for (int i = 0; i < 200; ++i) {
      zones.push_back(static_cast<int>(random() % 7));
      const auto name = random() % 12;
      classes.push_back({std::string(1, static_cast<char>('a' + name % 3)), std::to_string(name)});
    }
    const CategorySpread spread = measureCategories(zones, classes);
    EXPECT_NEAR(spread.m.value(), slowM(zones, classes, 7), tight);
    for (const ClassPair& pair : spread.pairs) {
      EXPECT_GE(pair.distance, 0);
      EXPECT_LE(pair.distance, 1);
    }
  }
}

TEST(Categories, AreAveragedAsUnderTheThesisTable) {
  // Table 5.3, one column a model: CR-1.CR-2 … CR-5.CR-6, EA-1.EA-2, PO-1.PO-2, and the M printed below it.
  const std::vector<std::vector<double>> columns{
      {.56, .13, .15, .15, .10, .64, .49, .54, .61, .22, .16, .12, .25, .19, .09, .42, .38},
      {.32, .16, .37, .17, .17, .22, .30, .38, .35, .33, .19, .15, .39, .33, .15, .77, .43},
      {.06, .21, .41, .08, .20, .18, .38, .04, .16, .28, .16, .10, .42, .30, .16, .79, .32},
      {.11, .13, .40, .11, .14, .07, .37, .09, .10, .42, .05, .12, .44, .33, .13, .44, .45}};
  const std::vector<double> printed{.31, .31, .25, .23};
  const double rounding = 0.005 + 0.005;  // rounding of the rows, and of M
  for (std::size_t model = 0; model < columns.size(); ++model) {
    std::vector<ClassPair> pairs;
    for (const double distance : columns[model]) pairs.push_back({"", "", "", distance});
    EXPECT_NEAR(meanDistance(pairs).value(), printed[model], rounding) << "column " << model;
  }
}

TEST(Categories, RefuseWhatDoesNotBelongTogether) {
  const std::vector<int> zones{1, 2};
  const std::vector<ImageClass> one{{"a", "b"}}, twice{{"a", "x"}, {"b", "x"}};
  EXPECT_THAT([&] { measureCategories(zones, one); }, FailsWith(ErrorCode::mismatch, "2", "1"));
  EXPECT_THAT([&] { measureCategories(zones, twice); },
              FailsWith(ErrorCode::mismatch, "\"x\"", "\"a\"", "\"b\""));
}

TEST(ClassHistograms, HaveTheLargestZonesFirstAndTheSmallOnesTogether) {
  std::vector<int> zones{7, 5, 5, 5};
  std::vector<std::string> classes{"hall", "hall", "lab", ""};
  EXPECT_EQ(classHistograms(zones, classes, {}).rows,
            (std::vector<ResultTable::Row>{{"hall", {50, 50}}, {"lab", {100, 0}}}));
  for (int zone = 10; zone < 32; ++zone) zones.push_back(zone), classes.emplace_back("shop");
  const ResultTable many = classHistograms(zones, classes, {});
  EXPECT_EQ(many.columns.size(), 21U);
  EXPECT_EQ(many.columns.back().name, "others");
  EXPECT_DOUBLE_EQ(many.rows[2].values.back().value(), 100 * 4 / 22.0) << "24 zones, 20 shown, 18 of shops";
  classes.pop_back();
  EXPECT_THAT([&] { classHistograms(zones, classes, {}); }, FailsWith(ErrorCode::mismatch));
}

TEST(ClassDistances, AreMeansOverPairsOfImages) {
  const DescriptorSequence recording = recordingOf({{1, 0, 0}, {0.8F, 0.2F, 0}, {0, 0, 1}, {0.5F, 0.5F, 0}});
  ZoneOptions options = ZoneOptions::thesis();
  const ClassDistances distances =
      classDistances(recording, std::vector<std::string>{"b", "b", "a", ""}, options);
  EXPECT_THAT(distances.classes, ElementsAre("a", "b"));
  EXPECT_TRUE(std::isnan(distances.at(0, 0))) << "one image has no pair";
  EXPECT_NEAR(distances.at(1, 1), 0.2, 1e-6);
  EXPECT_NEAR(distances.at(0, 1), 1, 1e-6);  // both (1, 0, 0) and (.8, .2, 0) differ by 1 in the last word
  EXPECT_EQ(distances.at(0, 1), distances.at(1, 0));
  options.distance = "l1";
  EXPECT_NEAR(classDistances(recording, std::vector<std::string>{"b", "b", "a", ""}, options).at(1, 1), 0.4,
              1e-6);
}

TEST(ClassDistances, AreThoseOfTheClassesMeansInFigure54) {
  const DescriptorSequence recording = recordingOf({{1, 0, 0}, {0, 1, 0}, {0.5F, 0.5F, 0}, {0, 0, 1}});
  const std::vector<std::string> classes{"b", "b", "a", ""};
  const ClassDistances distances = classDistances(recording, classes, ZoneOptions::thesis());
  EXPECT_THAT(distances.ofMeans, Each(0)) << "both have the mean (.5, .5, 0)";
  EXPECT_NEAR(distances.at(0, 1), 0.5, 1e-6) << "though no image of the one is near one of the other";
  const std::vector<std::string> other{"b", "b", "", "a"};
  EXPECT_THAT(classDistances(recording, other, ZoneOptions::thesis()).ofMeans, ElementsAre(0, 1, 1, 0));
  EXPECT_THAT(classDistances(recording, classes, {}).ofMeans, IsEmpty()) << "scales of two classes are none";
}

TEST(ClassDistances, RefuseWhatDoesNotBelongTogether) {
  const DescriptorSequence recording = recordingOf({{1, 0}, {0, 1}});
  const auto refusal = [&](const std::vector<std::string>& classes) {
    return test::caught([&] { classDistances(recording, classes, ZoneOptions::thesis()); });
  };
  EXPECT_THAT(refusal({"a"}), FailsWith(ErrorCode::mismatch, "1", "2"));
  EXPECT_THAT(refusal({"", ""}), FailsWith(ErrorCode::insufficientData));
}

}  // namespace
}  // namespace estancia::experiments
