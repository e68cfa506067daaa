// The same answers as SciPy: scipy_linkage.py wrote them down, and the inputs are made anew here.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>

#include "estancia/core/error.hpp"
#include "estancia/stats/compared_vectors.hpp"
#include "estancia/stats/linkage.hpp"
#include "scipy_random.hpp"

namespace estancia {
namespace {

using Json = nlohmann::json;
using test::Random;

DescriptorMatrix descriptors(std::uint64_t seed, std::size_t items, std::size_t labels, std::size_t places) {
  Random random(seed);
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
  Random random(seed);
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

}  // namespace
}  // namespace estancia
