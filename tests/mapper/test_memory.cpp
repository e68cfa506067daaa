// What a mapper remembers: nodes by any distance, and views of places.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/node_bank.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/mapper/view_memory.hpp"
#include "support/errors.hpp"
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

constexpr std::size_t words = 8;

/// An image at an angle [degrees] in the plane of two words, a unit vector: two images differ by 1 − cos.
std::vector<float> lookingAt(double degrees) {
  std::vector<float> vector(words);
  vector[0] = static_cast<float>(std::cos(degrees * std::numbers::pi / 180));
  vector[1] = static_cast<float>(std::sin(degrees * std::numbers::pi / 180));
  return vector;
}

class Views : public testing::Test {
 protected:
  static MapperOptions with(std::size_t views) {
    MapperOptions options;
    options.views = views;
    return options;
  }
  PlaceView at(double degrees, int node, const std::optional<Pose>& pose = {}) {
    const std::size_t frame = next_++;
    return {frame, node, frame, pose, lookingAt(degrees), lookingAt(degrees)};
  }
  void see(double degrees, int node, const std::optional<Pose>& pose = {}) {
    memory_.keep(at(degrees, node, pose), thresholds_);
  }
  std::optional<Recognition> look(double degrees, int current, const std::optional<Pose>& pose = {}) {
    return memory_.recognize(at(degrees, -1, pose), current, thresholds_);
  }

  std::size_t next_ = 0;
  /// .5, .15 and .25 are 60, 32 and 41 degrees.
  Thresholds thresholds_{0.5, 0.2, 0.15, 0.15, 0.25};
  ViewMemory memory_{getDistance("cosine"), words, with(40)};
};

TEST_F(Views, ShowTheirPlaceAgain) {
  see(0, 0);
  see(180, 1);
  const auto found = look(10, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->node, 0);
  EXPECT_NEAR(found->distance, 1 - std::cos(10 * std::numbers::pi / 180), 1e-6);
  EXPECT_EQ(found->threshold, 0.15);
  EXPECT_FALSE(found->byPose);
  EXPECT_FALSE(look(50, 1)) << "not so near";
}

TEST_F(Views, TwoFromTwoSidesAreASequence) {
  see(0, 0);
  see(60, 0);
  see(200, 1);
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(look(-38 - 0.1 * i, 1)) << "one alone may be of something else";
  const auto found = look(98, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->node, 0);
  EXPECT_EQ(found->threshold, 0.25);
}

TEST_F(Views, TakenNearShowTheirPlaceUnlessWordsContradict) {
  see(0, 0, Pose::planar(0, 0, 0));
  see(0, 1, Pose::planar(5, 0, 0));
  const auto found = look(50, 1, Pose::planar(0.5, 0, 0.3));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->node, 0);
  EXPECT_TRUE(found->byPose);
  EXPECT_EQ(found->threshold, 0.5);
  EXPECT_FALSE(look(70, 1, Pose::planar(0.5, 0, 0.3)));
  EXPECT_FALSE(look(50, 1, Pose::planar(0.5, 0, 1.0))) << "it looks elsewhere";
  EXPECT_FALSE(look(50, 1, Pose::planar(0.8, 0, 0))) << "not so near";
}

TEST_F(Views, TakenElsewhereOnlyLookAlike) {
  see(0, 0, Pose::planar(0, 0, 0));
  see(180, 1, Pose::planar(2, 0, 0));
  EXPECT_FALSE(look(0, 1, Pose::planar(4, 0, 0)));
  EXPECT_TRUE(look(0, 1)) << "where that is not known";
  EXPECT_TRUE(memory_.isElsewhere(0, Pose::planar(4, 0, 0)));
  EXPECT_FALSE(memory_.isElsewhere(0, Pose::planar(1, 0, 3)));
  EXPECT_FALSE(memory_.isElsewhere(0, std::nullopt));
  EXPECT_FALSE(memory_.isElsewhere(7, Pose::planar(4, 0, 0))) << "nothing is known of it";
  EXPECT_TRUE(memory_.areApart(0, 1));
  see(180, 1);
  EXPECT_FALSE(memory_.areApart(0, 1));
}

/// Nodes of a drive through places, some of which look like earlier ones.
std::size_t nodesOf(const std::vector<std::optional<Pose>>& poses) {
  test::SyntheticPlaces places(8, 200, 0.7);
  Mapper mapper(200);
  std::size_t next = 0;
  for (const auto& image : places.drive({0, 1, 2, 3, 4, 5, 6, 7, 2, 5, 0}, 12))
    mapper.add(image, poses[next++]);
  mapper.finish();
  return mapper.nodes();
}

TEST(MapperWithPoses, TellsPlacesThatLookAlikeApart) {
  std::vector<std::optional<Pose>> none(132), onward, back, still(132, Pose{}), some;
  for (std::size_t i = 0; i < 132; ++i) onward.push_back(Pose::planar(0.25 * static_cast<double>(i), 0, 0));
  for (const double place : {0, 1, 2, 3, 4, 5, 6, 7, 2, 5, 0})
    for (int i = 0; i < 12; ++i) back.push_back(Pose::planar(3 * place + 0.05 * i, 0, 0));
  some = back;
  for (std::size_t i = 0; i < some.size(); i += 3) some[i].reset();
  EXPECT_EQ(nodesOf(none), 8U);
  EXPECT_EQ(nodesOf(onward), 11U) << "it never came back";
  EXPECT_EQ(nodesOf(back), 8U);
  EXPECT_EQ(nodesOf(some), 8U);
  EXPECT_EQ(nodesOf(still), 8U) << "poses that never move say nothing";
  EXPECT_EQ(nodesOf(std::vector<std::optional<Pose>>(132, Pose{std::nan(""), 0, 0, 0, 0, 0, 1})), 8U);
}

TEST(MapperState, IsRefusedWhereItIsCutOffOrDamaged) {
  test::SyntheticPlaces places(4, 16, 0.5);
  std::vector<std::vector<float>> images = places.drive({0, 1, 2, 3, 0}, 6);
  MapperOptions options;
  options.warmupFrames = 10;
  options.transitionImages = 2;
  Mapper mapper(16, options);
  for (const auto& image : images)
    mapper.add(image, Pose::planar(0.1 * static_cast<double>(mapper.frames()), 0, 0));
  mapper.beginDrive();
  for (const auto& image : places.drive({2, 3}, 6)) mapper.add(images.emplace_back(image));
  const Mapper::Impl& impl = mapper.impl();
  const auto image = [&](std::size_t i) {
    return i < images.size() ? images[i] : throw Error(ErrorCode::corruptFile, "there is no such frame");
  };
  Mapper::Impl::Saved saved{
      impl.prior, impl.state(), {}, impl.views.state(), {}, image, [](std::size_t) { return std::nullopt; }};
  for (std::size_t slot = 0; slot < impl.bank.size(); ++slot)
    saved.nodes.emplace_back(impl.bank[slot].id, impl.nodeState(slot));
  std::ranges::sort(saved.nodes);
  const auto refusal = [&] { return test::caught([&] { Mapper::Impl::restore(16, options, saved); }).code; };
  EXPECT_FALSE(refusal());
  for (std::string* text : {&saved.state, &saved.nodes.front().second, &saved.views}) {
    const std::string whole = *text;
    std::size_t olderPrograms = 0;
    for (std::size_t at = 0; at < whole.size(); at += at < 512 || at + 512 > whole.size() ? 1 : 8) {
      *text = whole.substr(0, at);
      olderPrograms += refusal() ? 0 : 1;
      *text = whole;
      text->replace(at, std::min<std::size_t>(8, whole.size() - at), 8, '\xff');
      const ErrorCode code = refusal().value_or(ErrorCode::corruptFile);
      EXPECT_TRUE(code == ErrorCode::corruptFile || code == ErrorCode::truncatedFile) << nameOf(code) << at;
    }
    EXPECT_LE(olderPrograms, 3U) << "their states end earlier";
    *text = whole + "x";
    EXPECT_TRUE(refusal());
    *text = whole;
  }
}

}  // namespace
}  // namespace estancia
