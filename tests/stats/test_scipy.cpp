// Comparison with SciPy: scipy_linkage.py wrote its answers, and the inputs are made anew here.
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "estancia/core/error.hpp"
#include "estancia/stats/label_scale.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/stats/rank_tests.hpp"
#include "stats/scipy_random.hpp"

namespace estancia {
namespace {

using Json = nlohmann::json;
using ScoreRow = std::vector<double>;
using ScoreTable = std::vector<ScoreRow>;

DescriptorMatrix descriptors(std::uint64_t seed, std::size_t items, std::size_t labels, std::size_t places) {
  test::Random random(seed);
  std::vector<std::vector<double>> centers(places, std::vector<double>(labels));
  for (auto& center : centers)
    for (double& value : center) value = random.uniform();
  DescriptorMatrix matrix(labels);
  for (std::size_t i = 0; i < items; ++i) {
    std::vector<double> row;
    double sum = 0;
    for (const double c : centers[i % places]) {
      row.push_back(c * c * c * (0.5 + random.uniform()));
      sum += row.back();
    }
    LexicalDescriptor descriptor;
    for (const double value : row) descriptor.push_back(static_cast<float>(value / sum));
    matrix.append(descriptor);
  }
  return matrix;
}

CondensedDistances dissimilarities(std::uint64_t seed, std::size_t items, int steps) {
  test::Random random(seed);
  CondensedDistances distances(items);
  for (double& value : distances.values()) value = std::floor(random.uniform() * steps) / steps;
  return distances;
}

template <class Numbers>
std::string digest(const Numbers& numbers) {
  std::uint64_t value = 0xCBF29CE484222325U;
  for (const auto number : numbers)
    for (int byte = 0; byte < 4; ++byte)
      value = (value ^ ((static_cast<std::uint64_t>(number) >> (8 * byte)) & 0xFF)) * 0x100000001B3U;
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

class SciPy : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    stored_ = Json::parse(std::ifstream(ESTANCIA_SOURCE_DIR "/tests/stats/scipy_linkage.json"));
  }
  static CondensedDistances distances(const DescriptorMatrix& rows, const std::string& name) {
    const Distance distance = getDistance(name);
    return pairwiseDistances(comparedVectors(rows, rows, distance), distance.comparison);
  }
  inline static Json stored_;
};

/// What our distances are called there.
const std::map<std::string, std::string> metrics{
    {"chebyshev", "ks"},  {"cityblock", "l1"},        {"euclidean", "l2"},
    {"cosine", "cosine"}, {"correlation", "pearson"}, {"jensenshannon", "jensen-shannon"}};

TEST_F(SciPy, HasTheSameDistances) {
  const DescriptorMatrix rows = descriptors(1, 12, 7, 3);
  ASSERT_EQ(stored_["distances"].size(), metrics.size());
  for (const auto& [metric, expected] : stored_["distances"].items()) {
    const CondensedDistances ours = distances(rows, metrics.at(metric));
    ASSERT_EQ(ours.values().size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_NEAR(ours.values()[i], expected[i].get<double>(), 3e-7) << metric << " " << i;
  }
}

TEST_F(SciPy, MakesTheSameDendrograms) {
  const DescriptorMatrix rows = descriptors(2, 30, 5, 4);
  for (const Choice& named : linkages()) {
    const Dendrogram dendrogram = link(distances(rows, "l2"), getLinkage(named.name));
    const Json& expected = stored_["small"][named.name];
    ASSERT_EQ(dendrogram.merges().size(), expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) {
      const Dendrogram::Merge& merge = dendrogram.merges()[k];
      EXPECT_EQ(merge.left, expected[k][0].get<std::size_t>()) << named.name << " " << k;
      EXPECT_EQ(merge.right, expected[k][1].get<std::size_t>()) << named.name << " " << k;
      EXPECT_NEAR(merge.height, expected[k][2].get<double>(), 1e-6) << named.name << " " << k;
      EXPECT_EQ(merge.size, expected[k][3].get<std::size_t>()) << named.name << " " << k;
    }
  }
}

TEST_F(SciPy, BreaksTiesInTheSameWay) {
  for (const Json& stored : stored_["ties"])
    for (const Choice& named : linkages()) {
      const Dendrogram dendrogram =
          link(dissimilarities(stored["seed"], stored["items"], stored["steps"]), getLinkage(named.name));
      std::vector<std::size_t> numbers;
      for (const Dendrogram::Merge& merge : dendrogram.merges())
        numbers.insert(numbers.end(), {merge.left, merge.right, merge.size});
      EXPECT_EQ(digest(numbers), stored["digests"][named.name].get<std::string>())
          << named.name << ", " << stored["items"] << " items";
    }
}

TEST_F(SciPy, CutsAThousandItemsInTheSameWay) {
  for (const Json& stored : stored_["large"]) {
    const DescriptorMatrix rows = descriptors(stored["seed"], 1000, 40, 23);
    for (const auto& [name, cuts] : stored["cuts"].items()) {
      const Dendrogram dendrogram = link(distances(rows, metrics.at(stored["metric"])), getLinkage(name));
      for (const Json& cut : cuts) {
        const std::vector<int> clusters = dendrogram.cutAt(cut["distance"]);
        EXPECT_EQ(digest(clusters), cut["digest"].get<std::string>())
            << name << " " << stored["metric"] << " " << cut;
        EXPECT_EQ(dendrogram.cutInto(cut["clusters"]), clusters)
            << name << " " << stored["metric"] << " " << cut;
      }
    }
  }
}

/// See scores() in scipy_rank_tests.py.
ScoreTable scores(const Json& stored, std::size_t methods) {
  test::Random random(stored["seed"]);
  const double steps = stored["steps"], lead = stored["lead"];
  ScoreTable table(stored["tests"], ScoreRow(methods));
  for (ScoreRow& test : table)
    for (std::size_t m = 0; m < methods; ++m)
      test[m] = std::trunc((random.uniform() + static_cast<double>(m) * lead) * steps) / steps;
  return table;
}

ScoreRow column(const ScoreTable& table, std::size_t c) {
  ScoreRow values;
  for (const ScoreRow& test : table) values.push_back(test[c]);
  return values;
}

class SciPyRankTests : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    stored_ = Json::parse(std::ifstream(ESTANCIA_SOURCE_DIR "/tests/stats/scipy_rank_tests.json"));
  }
  inline static Json stored_;
};

TEST_F(SciPyRankTests, HaveTheSameMeanRanksAndFriedmanStatistics) {
  ASSERT_EQ(stored_["friedman"].size(), 5U);
  for (const Json& stored : stored_["friedman"]) {
    const ScoreTable table = scores(stored, stored["methods"]);
    const ScoreRow rank = meanRanks(table, Better::larger);
    for (std::size_t m = 0; m < rank.size(); ++m)
      EXPECT_NEAR(rank[m], stored["mean_ranks"][m].get<double>(), 1e-12) << stored["seed"] << " " << m;
    const FriedmanTest found = friedmanTest(table);
    const double statistic = stored["statistic"], p = stored["p"];
    EXPECT_NEAR(found.chiSquared, statistic, 1e-10 * statistic) << stored["seed"];
    EXPECT_NEAR(found.p, p, 1e-9 * p) << stored["seed"];
    EXPECT_EQ(found.undefined, "");
  }
}

TEST_F(SciPyRankTests, HaveTheSameSignedRanks) {
  ASSERT_EQ(stored_["wilcoxon"].size(), 6U);
  for (const Json& stored : stored_["wilcoxon"]) {
    const ScoreTable table = scores(stored, 2);
    const WilcoxonTest found = wilcoxonTest(column(table, 0), column(table, 1));
    EXPECT_EQ(found.exact, stored["exact"].get<bool>()) << stored["seed"];
    EXPECT_DOUBLE_EQ(std::min(found.better, found.worse), stored["smaller_sum"].get<double>())
        << stored["seed"];
    const double p = stored["p"];
    EXPECT_NEAR(found.p, p, 1e-10 * p) << stored["seed"];
  }
}

TEST_F(SciPyRankTests, HaveTheSameStudentizedRangeAndNumbersOfHypotheses) {
  ASSERT_EQ(stored_["range"].size(), 56U);
  for (const Json& stored : stored_["range"]) {
    const double found = studentizedRangeTail(stored["q"], stored["groups"]);
    EXPECT_NEAR(found, stored["mpmath"].get<double>(), 1e-12 * stored["mpmath"].get<double>()) << stored;
    EXPECT_NEAR(found, stored["scipy"].get<double>(), 1e-9) << stored;
  }
  for (const auto& [methods, hypotheses] : stored_["shaffer"].items()) {
    const std::size_t pairs = hypotheses.size();
    // So small and so far apart that each adjusted value shows its factor.
    ScoreRow p;
    for (std::size_t i = 0; i < pairs; ++i) p.push_back(1e-300 * std::pow(10, 4 * static_cast<double>(i)));
    const ScoreRow found = shafferAdjusted(p, std::stoul(methods));
    for (std::size_t i = 0; i < pairs; ++i)
      EXPECT_NEAR(found[i] / p[i], hypotheses[i].get<double>(), 1e-9) << methods << " methods, step " << i;
  }
}

class RRankTests : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::ifstream file(ESTANCIA_SOURCE_DIR "/tests/stats/r_rank_tests.csv");
    for (std::string line; std::getline(file, line);) {
      std::istringstream cells(line);
      std::string name, cell;
      std::getline(cells, name, ',');
      while (std::getline(cells, cell, ',')) stored_[name].push_back(std::stod(cell));
    }
  }
  static void expectNear(const ScoreRow& found, const std::string& name, double error) {
    const ScoreRow& expected = stored_[name];
    ASSERT_EQ(found.size(), expected.size()) << name;
    for (std::size_t i = 0; i < found.size(); ++i)
      EXPECT_NEAR(found[i], expected[i], error) << name << " " << i;
  }
  inline static std::map<std::string, ScoreRow> stored_;
  /// Demšar 2006, ScoreTable 6, in thousandths, so that equal differences are ties.
  const ScoreTable auc_{{763, 768, 771, 798},     {599, 591, 590, 569}, {954, 971, 968, 967},
                        {628, 661, 654, 657},     {882, 888, 886, 898}, {936, 931, 916, 931},
                        {661, 668, 609, 685},     {583, 583, 563, 625}, {775, 838, 866, 875},
                        {1000, 1000, 1000, 1000}, {940, 962, 965, 962}, {619, 666, 614, 669},
                        {972, 981, 975, 975},     {957, 978, 946, 970}};
};

TEST_F(RRankTests, AgreeOnTheExampleOfDemsar) {
  const FriedmanTest friedman = friedmanTest(auc_);
  expectNear({friedman.chiSquared, friedman.p}, "friedman", 1e-12);
  expectNear({friedman.f, friedman.fP}, "iman_davenport", 1e-12);
  EXPECT_EQ(friedman.fDegrees, 3U);
  EXPECT_EQ(friedman.fOtherDegrees, 39U);
  const ScoreRow rank = meanRanks(auc_, Better::larger);
  expectNear(rank, "mean_ranks", 1e-13);
  ScoreRow p, holm, nemenyi;
  for (const PairTest& pair : postHocTests(PostHoc::holm, rank, auc_.size())) {
    p.push_back(pair.p);
    holm.push_back(pair.adjusted);
  }
  for (const PairTest& pair : postHocTests(PostHoc::nemenyi, rank, auc_.size()))
    if (pair.first == 0) nemenyi.push_back(pair.adjusted);
  expectNear(p, "p", 1e-13);
  expectNear(holm, "holm", 1e-13);
  expectNear(nemenyi, "nemenyi_p", 1e-9);
  const WilcoxonTest wilcoxon = wilcoxonTest(column(auc_, 0), column(auc_, 1));
  EXPECT_FALSE(wilcoxon.exact);
  expectNear({wilcoxon.better, wilcoxon.p}, "wilcoxon", 1e-12);
}

TEST_F(RRankTests, AgreeOnExactSignedRanksAndCriticalValues) {
  const ScoreRow differences{1, 2, 3, 4, 5, 6, 7, 8, -9};
  const WilcoxonTest found = wilcoxonTest(differences, ScoreRow(9, 0.0));
  EXPECT_TRUE(found.exact);
  expectNear({found.better, found.p}, "wilcoxon_exact", 1e-14);
  ScoreRow quantiles;
  for (std::size_t k = 2; k <= 20; ++k) quantiles.push_back(studentizedRangeQuantile(0.05, k) / std::sqrt(2));
  expectNear(quantiles, "nemenyi_quantiles", 1e-6);  // R stops searching within 1e-4 of what it searches
}

}  // namespace
}  // namespace estancia
