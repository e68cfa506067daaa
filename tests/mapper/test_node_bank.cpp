// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/node_bank.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estancia/core/error.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

constexpr std::size_t labels = 130;  // no multiple of any vector width

std::vector<std::string> everyDistance() {
  std::vector<std::string> names;
  for (const Distance& distance : baseDistances()) {
    names.push_back(distance.name);
    if (!distance.sigmaWeighted) names.push_back(distance.name + "-sigma");
  }
  return names;
}

std::vector<float> embedded(const Distance& distance, const std::vector<float>& p) {
  std::vector<float> out(p.size());
  embed(distance.embedding, p, out);
  return out;
}

NodeMemory nodeOf(const NodeBank& bank, const Distance& distance, int id,
                  const std::vector<std::vector<float>>& images) {
  NodeMemory node = bank.makeNode(id);
  for (const auto& image : images) {
    ++node.frames;
    node.probabilities.add(image);
    if (node.embedded) node.embedded->add(embedded(distance, image));
  }
  return node;
}

class EveryDistance : public testing::TestWithParam<std::string> {
 protected:
  const Distance distance_ = getDistance(GetParam());
  test::SyntheticPlaces places_{60, labels};
  NodeBank bank_{distance_, labels};

  void SetUp() override {
    if (distance_.standardized) {
      Standardization s{std::vector<float>(labels), std::vector<float>(labels)};
      for (std::size_t i = 0; i < labels; ++i) {
        s.center[i] = 0.01F * static_cast<float>(i % 7);
        s.weight[i] = 0.5F + 0.1F * static_cast<float>(i % 11);
      }
      bank_.setStandardization(s);
    }
    for (std::size_t place = 0; place < 60; ++place)
      bank_.add(nodeOf(bank_, distance_, static_cast<int>(place), places_.drive({place}, 1 + place % 4)));
  }

  NodeBank::Nearest slowNearest(const std::vector<float>& query, std::size_t except,
                                std::uint64_t minFrames) const {
    NodeBank::Nearest best{bank_.size(), INFINITY};
    for (std::size_t slot = 0; slot < bank_.size(); ++slot)
      if (slot != except && bank_[slot].frames >= minFrames && bank_.distance(slot, query) < best.distance)
        best = {slot, bank_.distance(slot, query)};
    return best;
  }
};

TEST_P(EveryDistance, NearestIsThatOfAPlainScan) {
  std::size_t right = 0;
  for (std::size_t i = 0; i < 120; ++i) {
    const auto query = bank_.compared(embedded(distance_, places_.image(i % 60)));
    const std::size_t except = i % 3 == 0 ? i % 60 : bank_.size();
    const auto quick = bank_.nearest(query, except, 1 + i % 3);
    const auto slow = slowNearest(query, except, 1 + i % 3);
    ASSERT_TRUE(quick);
    EXPECT_EQ(quick->slot, slow.slot);
    EXPECT_DOUBLE_EQ(quick->distance, slow.distance);
    right += i < 60 && bank_.nearest(query, bank_.size())->slot == i;
  }
  EXPECT_GE(right,
            distance_.comparison == Comparison::chebyshev ? 40U : 57U);  // looks at one label only

  while (bank_.size() > 1) {
    const std::size_t gone = bank_.size() / 2;
    const int id = bank_[gone].id;
    bank_.remove(gone);
    EXPECT_THROW(bank_.slotOf(id), Error);
    const auto query = bank_.compared(embedded(distance_, places_.image(static_cast<std::size_t>(id))));
    EXPECT_EQ(bank_.nearest(query, bank_.size())->slot, slowNearest(query, bank_.size(), 1).slot);
  }
  EXPECT_FALSE(bank_.nearest(bank_.compared(embedded(distance_, places_.image(0))), 0));
}

INSTANTIATE_TEST_SUITE_P(NodeBank, EveryDistance, testing::ValuesIn(everyDistance()), [](const auto& name) {
  std::string text = name.param;
  for (char& c : text)
    if (c == '-') c = '_';
  return text;
});

/// Σ w d_part / Σ w, each part embedded and compared by itself.
double fused(const std::vector<LabelPart>& parts, const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0, weights = 0;
  for (std::size_t first = 0; const LabelPart& part : parts) {
    std::vector<float> x(part.size), y(part.size);
    embed(Embedding::centeredLogRatio, std::span(a).subspan(first, part.size), x);
    embed(Embedding::centeredLogRatio, std::span(b).subspan(first, part.size), y);
    sum += part.weight * compare(Comparison::cosine, x, y);
    weights += part.weight;
    first += part.size;
  }
  return sum / weights;
}

TEST(NodeBankOfParts, DistanceIsTheWeightedMeanOfThePartsOwn) {
  const std::vector<LabelPart> parts{{30, 1}, {5, 2}, {12, 0.5F}};
  const Distance distance = getDistance("clr-cosine", parts);
  test::SyntheticPlaces places(6, 47);
  NodeBank bank(distance, 47);
  std::vector<std::vector<float>> images;
  for (std::size_t p = 0; p < 6; ++p) {
    images.push_back(places.image(p));
    NodeMemory node = bank.makeNode(static_cast<int>(p));
    std::vector<float> embedded(47);
    embed(distance.embedding, images.back(), embedded, distance.parts);
    node.frames = 1;
    node.probabilities.add(images.back());
    node.embedded->add(embedded);
    bank.add(std::move(node));
  }
  const std::vector<float> image = places.image(3);
  std::vector<float> embedded(47);
  embed(distance.embedding, image, embedded, distance.parts);
  const auto query = bank.compared(embedded);
  std::size_t best = 0;
  for (std::size_t p = 0; p < 6; ++p) {
    EXPECT_NEAR(bank.distance(p, query), fused(parts, images[p], image), 1e-5);
    if (fused(parts, images[p], image) < fused(parts, images[best], image)) best = p;
  }
  EXPECT_EQ(bank.nearest(query, bank.size())->slot, best);
}

}  // namespace
}  // namespace estancia
