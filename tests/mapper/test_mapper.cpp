// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/mapper_impl.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/label_prior.hpp"
#include "support/errors.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

using Images = std::vector<std::vector<float>>;
using test::FailsWith;

MapperOptions fixed(const std::string& distance, double tauJoin, double tauRevisit) {
  MapperOptions options;
  options.distance = distance;
  options.tauJoin = tauJoin;
  options.tauRevisit = tauRevisit;
  options.thresholds.mergeRatio = 0;
  options.views = 0;  // Algorithm 4.1 as it is
  return options;
}

/// Follows the changes as a map file does: the node of each frame, with merges applied.
class Follower {
 public:
  void take(Mapper& mapper) {
    const MapChanges changes = mapper.takeChanges();
    if (changes.restarted) *this = {};
    for (const auto& event : changes.events) {
      if (const auto* decision = std::get_if<Decision>(&event)) {
        EXPECT_EQ(decision->frame, nodes.size());
        nodes.push_back(decision->node);
        decisions.push_back(*decision);
      } else {
        const auto& merge = std::get<Merge>(event);
        for (int& node : nodes)
          if (node == merge.absorbed) node = merge.kept;
        merges.push_back(merge);
      }
    }
  }
  std::vector<int> nodes;
  std::vector<Decision> decisions;
  std::vector<Merge> merges;
};

Follower mapped(Mapper& mapper, const Images& images, bool finish = true) {
  Follower follower;
  for (const auto& image : images) {
    mapper.add(image);
    follower.take(mapper);
  }
  if (finish) mapper.finish();
  follower.take(mapper);
  return follower;
}

Follower mapped(const MapperOptions& options, const Images& images) {
  Mapper mapper(images[0].size(), options);
  return mapped(mapper, images);
}

/// Algorithm 4.1, and the original program's condition that a node must be nearer than the current one, in
/// double precision, with Eq. 4.2–4.5 computed from scratch for every image. In that program the first
/// and last k images of a node of 2k or more weigh 0, 1/k, … (k − 1)/k from its ends.
std::vector<int> textbook(const Images& images, double tau1, double tau2, bool root, std::size_t k = 0) {
  std::vector<Images> nodes;
  std::vector<int> result;
  std::size_t current = 0;
  const auto distance = [&](const Images& node, const std::vector<float>& image) {
    double sum = 0, weights = 0, total = 0;
    std::vector<double> share(node.size(), 1);
    for (std::size_t i = 0; i < node.size() && node.size() >= 2 * k; ++i) {
      const std::size_t toEnd = std::min(i, node.size() - 1 - i);
      if (toEnd < k) share[i] = static_cast<double>(toEnd) / static_cast<double>(k);
    }
    for (const double each : share) total += each;
    for (std::size_t l = 0; l < image.size(); ++l) {
      double mean = 0, variance = 0;
      for (std::size_t i = 0; i < node.size(); ++i) mean += share[i] * node[i][l] / total;
      for (std::size_t i = 0; i < node.size(); ++i)
        variance += share[i] * std::pow(node[i][l] - mean, 2) / total;
      const double w = 1 - 2 * std::sqrt(variance);
      sum += w * std::pow(mean - image[l], 2);
      weights += w;
    }
    return root ? std::sqrt(sum / weights) : sum / weights;
  };
  for (const auto& image : images) {
    if (nodes.empty()) {
      nodes.push_back({image});
    } else if (const double toCurrent = distance(nodes[current], image); toCurrent < tau1) {
      nodes[current].push_back(image);
    } else {
      std::size_t similar = nodes.size();
      double least = INFINITY;
      for (std::size_t z = 0; z < nodes.size(); ++z)
        if (const double d = distance(nodes[z], image); z != current && d < least) {
          least = d;
          similar = z;
        }
      if (similar < nodes.size() && least < tau2 && least < toCurrent) {
        nodes[similar].push_back(image);
        current = similar;
      } else {
        nodes.push_back({image});
        current = nodes.size() - 1;
      }
    }
    result.push_back(static_cast<int>(current));
  }
  return result;
}

TEST(Mapper, IsAlgorithm41) {
  test::SyntheticPlaces places(6, 40, 0.6);
  const Images images = places.drive({0, 1, 0, 2, 3, 1, 4, 5, 0, 4, 2}, 9);
  for (const bool root : {false, true})
    for (const double scale : {0.6, 0.9, 1.3, 2.0}) {
      const double tau1 = root ? 0.02 * scale : 4e-4 * scale * scale;
      const double tau2 = root ? 0.018 * scale : 3.2e-4 * scale * scale;
      const MapperOptions options = fixed(root ? "weighted-root" : "weighted", tau1, tau2);
      EXPECT_EQ(mapped(options, images).nodes, textbook(images, tau1, tau2, root))
          << (root ? "root " : "square ") << "scale " << scale;
      MapperOptions withEnds = options;
      withEnds.transitionImages = 4;
      EXPECT_EQ(mapped(withEnds, images).nodes, textbook(images, tau1, tau2, root, 4))
          << (root ? "root " : "square ") << "scale " << scale;
    }
}

TEST(Mapper, MovesToTheNearestOfSeveralNearNodes) {
  // Algorithm 4.1 as printed never updates Min_dist and would take the last node.
  const Images images{{0.9F, 0.1F, 0.0F}, {0.1F, 0.9F, 0.0F}, {0.0F, 0.1F, 0.9F}, {0.8F, 0.2F, 0.0F}};
  const auto map = mapped(fixed("l2", 0.05, 2.0), images);
  EXPECT_EQ(map.nodes.back(), 0);
  EXPECT_EQ(map.decisions.back().kind, DecisionKind::revisit);
}

TEST(Mapper, RecordsEveryDecisionWithItsDistances) {
  const Images images{{0.9F, 0.1F}, {0.88F, 0.12F}, {0.1F, 0.9F}, {0.9F, 0.1F}};
  const auto map = mapped(fixed("l1", 0.2, 0.1), images);
  ASSERT_EQ(map.decisions.size(), 4U);
  EXPECT_EQ(map.decisions[0].kind, DecisionKind::start);
  EXPECT_TRUE(std::isnan(map.decisions[0].toCurrent));
  EXPECT_EQ(map.decisions[1].kind, DecisionKind::join);
  EXPECT_NEAR(map.decisions[1].toCurrent, 0.04, 1e-6);
  EXPECT_EQ(map.decisions[2].kind, DecisionKind::createNode);
  EXPECT_EQ(map.decisions[2].current, 0);
  EXPECT_EQ(map.decisions[2].other, -1);
  EXPECT_EQ(map.decisions[3].kind, DecisionKind::revisit);
  EXPECT_EQ(map.decisions[3].other, 0);
  EXPECT_NEAR(map.decisions[3].toOther, 0.02, 1e-6);
  EXPECT_DOUBLE_EQ(map.decisions[3].tauRevisit, 0.1);
}

TEST(Mapper, TheFirstAndLastImagesOfANodeWeighLess) {
  test::SyntheticPlaces places(2, 30, 0.05);
  const Images images = places.drive({0, 1, 0}, 5);
  MapperOptions options = fixed("hellinger", 0.5, 0.4);
  options.transitionImages = 3;
  Mapper mapper(30, options);
  const auto map = mapped(mapper, images);
  ASSERT_EQ(mapper.impl().bank.size(), 2U);
  // The robot came back to node 0, whose second stay has its last images; node 1 has too few for ends.
  const std::vector<double> weights{0, 1 / 3., 2 / 3., 1, 1, 1, 1, 2 / 3., 1 / 3., 0};
  for (std::size_t l = 0; l < 30; ++l) {
    double sum = 0, total = 0;
    for (std::size_t i = 0; i < 10; ++i) {
      sum += weights[i] * images[i < 5 ? i : i + 5][l];
      total += weights[i];
    }
    EXPECT_NEAR(mapper.impl().bank[0].probabilities.mean()[l], sum / total, 1e-6);
  }
  EXPECT_NEAR(mapper.impl().bank[0].probabilities.weight(), 6, 1e-9);
  EXPECT_DOUBLE_EQ(mapper.impl().bank[1].probabilities.weight(), 5);
}

TEST(Mapper, StatesWithOtherImagesAtTheEndsOfANodeAreRefused) {
  test::SyntheticPlaces places(1, 30, 0.05);
  const Images images = places.drive({0}, 6);
  MapperOptions options = fixed("hellinger", 0.5, 0.4);
  options.transitionImages = 2;
  Mapper mapper(30, options);
  mapped(mapper, images);
  const std::string node = mapper.impl().nodeState(0);
  constexpr std::size_t border = 3 * sizeof(std::uint64_t);  // their number, and two
  const auto restore = [&](const std::vector<std::uint64_t>& numbers) {
    const std::string state =
        node.substr(0, node.size() - border) +
        std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(std::uint64_t));
    Mapper::Impl::restore(30, options,
                          {mapper.impl().prior,
                           mapper.impl().state(),
                           {{0, state}},
                           mapper.impl().views.state(),
                           {},
                           [&](std::size_t i) { return images.at(i); },
                           [](std::size_t) { return std::nullopt; }});
  };
  EXPECT_NO_THROW(restore({2, 4, 5}));
  EXPECT_THAT([&] { restore({5, 1, 2, 3, 4, 5}); }, test::FailsWith(ErrorCode::corruptFile)) << "at most 2k";
  EXPECT_THAT([&] { restore({2, 4, 6}); }, test::FailsWith(ErrorCode::corruptFile)) << "there is no image 6";
}

TEST(Mapper, FindsItsThresholdsByItself) {
  for (const std::size_t stay : {6U, 12U, 40U}) {  // frame rates differ, the map must not
    test::SyntheticPlaces places(8, 200, 0.7);
    const auto map = mapped(MapperOptions{}, places.drive({0, 1, 2, 3, 4, 5, 6, 7, 2, 5, 0}, stay));
    ASSERT_EQ(map.nodes.size(), 11 * stay);
    EXPECT_EQ(std::set<int>(map.nodes.begin(), map.nodes.end()).size(), 8U) << "stay " << stay;
    EXPECT_EQ(map.nodes[8 * stay], map.nodes[2 * stay]) << "stay " << stay;
    EXPECT_EQ(map.nodes[10 * stay], map.nodes[0]) << "stay " << stay;
  }
}

TEST(Mapper, FindsThresholdsForEveryDistance) {
  for (const Distance& distance : baseDistances()) {
    test::SyntheticPlaces places(8, 200, 0.3);
    MapperOptions options;
    options.distance = distance.name;
    const auto map = mapped(options, places.drive({0, 1, 2, 3, 4, 5, 6, 7, 2, 5, 0}, 12));
    const std::set<int> nodes(map.nodes.begin(), map.nodes.end());
    EXPECT_GE(nodes.size(), 4U) << distance.name;
    EXPECT_LE(nodes.size(), 20U) << distance.name;
  }
}

TEST(Mapper, MergesTwinsAndRedirectsTheirTransitions) {
  test::SyntheticPlaces places(3, 200, 0.5);
  MapperOptions options =
      fixed("standardized-clr", 0.6, 1e-9);  // never revisits, so every return makes a twin
  options.thresholds.mergeRatio = 0.3;
  Mapper mapper(200, options);
  const auto map = mapped(mapper, places.drive({0, 1, 2, 0, 1, 2}, 12));
  EXPECT_GE(map.merges.size(), 2U);
  const std::set<int> alive(map.nodes.begin(), map.nodes.end());
  EXPECT_EQ(alive.size(), 3U);
  EXPECT_EQ(mapper.impl().bank.size(), 3U);
  std::uint64_t frames = 0;
  for (std::size_t slot = 0; slot < mapper.impl().bank.size(); ++slot) {
    frames += mapper.impl().bank[slot].frames;
    EXPECT_TRUE(alive.contains(mapper.impl().bank[slot].id));
  }
  EXPECT_EQ(frames, 72U);
  for (const auto& [ends, transition] : mapper.transitions()) {
    EXPECT_TRUE(alive.contains(ends.first) && alive.contains(ends.second));
    EXPECT_NE(ends.first, ends.second);
  }
  for (const Merge& merge : map.merges) {
    EXPECT_LT(merge.kept, merge.absorbed);
    EXPECT_LT(merge.distance, merge.threshold);
  }
}

TEST(Mapper, IdenticalImagesAreOnePlace) {
  test::SyntheticPlaces places(1, 20);
  const std::vector<float> uniform(20, 0.05F), silent(20, 0.0F);  // a service may give no labels at all
  for (const auto& image : {places.image(0), uniform, silent}) {
    const auto map = mapped(MapperOptions{}, Images(50, image));
    EXPECT_EQ(std::set<int>(map.nodes.begin(), map.nodes.end()).size(), 1U);
  }
}

TEST(Mapper, AStandingRobotStaysInOnePlace) {
  for (const double noise : {0.01, 0.2}) {
    test::SyntheticPlaces places(1, 200, noise);
    const auto map = mapped(MapperOptions{}, places.drive({0}, 400));
    EXPECT_EQ(std::set<int>(map.nodes.begin(), map.nodes.end()).size(), 1U) << noise;
  }
}

TEST(Mapper, ALongStandTeachesNothing) {
  // The scales of camera noise must not become the scales of the map.
  const std::vector<std::size_t> drive{0, 1, 2, 3, 4, 5, 6, 7, 2, 5, 0};
  for (const std::size_t stand : {30U, 600U}) {
    test::SyntheticPlaces still(1, 200, 0.05), places(8, 200, 0.7);
    Images images = still.drive({0}, stand);
    for (const auto& image : places.drive(drive, 12)) images.push_back(image);
    const auto map = mapped(MapperOptions{}, images);
    const std::set<int> nodes(map.nodes.begin() + static_cast<std::ptrdiff_t>(stand), map.nodes.end());
    EXPECT_EQ(nodes.size(), 8U) << stand;
  }
}

TEST(Mapper, RefusesWhatIsNoDescriptorAndOptionsOutOfRange) {
  Mapper mapper(3, {});
  const std::vector<float> shorter{0.5F, 0.5F}, nan{0.5F, NAN, 0.5F}, large{0.5F, 3.0F, 0.5F};
  EXPECT_THAT([&] { mapper.add(shorter); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { mapper.add(nan); }, FailsWith(ErrorCode::labelerFailure));
  EXPECT_THAT([&] { mapper.add(large); }, FailsWith(ErrorCode::labelerFailure));
  EXPECT_EQ(mapper.frames(), 0U);

  const std::pair<ErrorCode, void (*)(MapperOptions&)> changes[] = {
      {ErrorCode::unknownName, [](MapperOptions& o) { o.distance = "manhattan"; }},
      {ErrorCode::invalidOption, [](MapperOptions& o) { o.tauJoin = 0; }},
      {ErrorCode::invalidOption, [](MapperOptions& o) { o.tauJoin = NAN; }},
      {ErrorCode::invalidOption, [](MapperOptions& o) { o.tauRevisit = -1; }},
      {ErrorCode::invalidOption, [](MapperOptions& o) { o.tauRevisit = INFINITY; }},
      {ErrorCode::invalidOption, [](MapperOptions& o) { o.transitionImages = 1'000'000'000; }},
      {ErrorCode::invalidOption, [](MapperOptions& o) { o.thresholds.farQuantile = 1.5; }}};
  for (const auto& [code, change] : changes) {
    MapperOptions options;
    change(options);
    EXPECT_THAT([&] { Mapper(3, options); }, FailsWith(code));
  }
}

/// Transitions in the order of a map file.
std::vector<Transition> transitionsOf(const Mapper& mapper) {
  std::vector<Transition> transitions;
  for (const auto& entry : mapper.transitions()) transitions.push_back(entry.second);
  return transitions;
}

TEST(Mapper, RestoredAtAnyFrameMapsAsIfNothingHadHappened) {
  test::SyntheticPlaces places(9, 64, 0.7);
  const Images images = places.drive({0, 1, 2, 3, 4, 5, 6, 7, 8, 1, 3, 5, 0, 2}, 12);
  MapperOptions options;
  options.warmupFrames = 70;
  options.transitionImages = 2;
  const auto poseOf = [](std::size_t i) {  // it comes back; some poses are not known
    const double angle = 0.05 * static_cast<double>(i);
    return i % 7 == 0 ? std::nullopt : std::optional(Pose::planar(std::cos(angle), std::sin(angle), angle));
  };
  Mapper unbroken(64, options);
  Follower expected;
  for (std::size_t i = 0; i < images.size(); ++i) {
    unbroken.add(images[i], poseOf(i));
    expected.take(unbroken);
  }
  unbroken.finish();
  expected.take(unbroken);

  for (const std::size_t cut : {5U, 70U, 71U, 167U}) {
    Follower follower;
    Mapper first(64, options);
    for (std::size_t i = 0; i < cut; ++i) first.add(images[i], poseOf(i));
    follower.take(first);
    std::vector<std::pair<int, std::string>> nodes;
    for (std::size_t slot = 0; slot < first.impl().bank.size(); ++slot)
      nodes.emplace_back(first.impl().bank[slot].id, first.impl().nodeState(slot));
    std::sort(nodes.begin(), nodes.end());
    Mapper second =
        Mapper::Impl::restore(64, settingsFromJson(settingsToJson(options)),
                              {first.impl().prior, first.impl().state(), nodes, first.impl().views.state(),
                               transitionsOf(first), [&](std::size_t i) { return images[i]; }, poseOf});
    for (std::size_t i = cut; i < images.size(); ++i) {
      second.add(images[i], poseOf(i));
      follower.take(second);
    }
    second.finish();
    follower.take(second);
    EXPECT_EQ(follower.nodes, expected.nodes) << cut;
    EXPECT_EQ(second.thresholds().join, unbroken.thresholds().join) << cut;
    EXPECT_EQ(second.transitions().size(), unbroken.transitions().size()) << cut;
  }
}

constexpr std::size_t roomLabels = 300;

/// Rooms whose images have log-ratios of their own, and views that change them while the robot turns.
class MadeUpRooms {
 public:
  explicit MadeUpRooms(std::size_t count) : random_(7) {
    for (std::size_t r = 0; r < count; ++r) {
      Room& room = rooms_.emplace_back();
      room.mean = normal(1);
      for (auto* swing : {&room.east, &room.north}) *swing = normal(0.6);
    }
  }
  std::vector<float> image(std::size_t room, double heading) {
    const Room& r = rooms_[room];
    const std::vector<double> noise = normal(0.4);
    std::vector<float> p(roomLabels);
    double sum = 0;
    for (std::size_t i = 0; i < roomLabels; ++i) {
      const double ratio =
          r.mean[i] + r.east[i] * std::cos(heading) + r.north[i] * std::sin(heading) + noise[i];
      sum += p[i] = static_cast<float>(std::exp(ratio));
    }
    for (float& value : p) value /= static_cast<float>(sum);
    return p;
  }

 private:
  struct Room {
    std::vector<double> mean, east, north;
  };
  std::vector<double> normal(double sigma) {
    std::normal_distribution<double> distribution(0, sigma);
    std::vector<double> values(roomLabels);
    for (double& value : values) value = distribution(random_);
    return values;
  }
  std::mt19937 random_;
  std::vector<Room> rooms_;
};

class FewRooms : public testing::TestWithParam<std::pair<std::size_t, std::size_t>> {};

/// The robot turns once all around in each room, at each visit.
TEST_P(FewRooms, AreFewPlaces) {
  const auto [rooms, visits] = GetParam();
  MadeUpRooms home(rooms);
  Images images;
  std::vector<int> truth;
  for (std::size_t visit = 0; visit < visits; ++visit)
    for (std::size_t room = 0; room < rooms; ++room)
      for (int step = 0; step < 24; ++step) {
        images.push_back(home.image(room, step * 0.2618 + static_cast<double>(visit)));
        truth.push_back(static_cast<int>(room));
      }
  Mapper mapper(roomLabels);
  EXPECT_GE(measureAgreement(truth, mapped(mapper, images).nodes).vMeasure, 0.9);
  EXPECT_LE(mapper.nodes(), rooms + 2);
}

INSTANTIATE_TEST_SUITE_P(Mapper, FewRooms, testing::Values(std::pair(2, 1), std::pair(3, 6), std::pair(8, 2)),
                         [](const auto& tested) {
                           return std::to_string(tested.param.first) + "Rooms" +
                                  std::to_string(tested.param.second) + "Visits";
                         });

TEST(Mapper, ALabelerThatReturnsItsBestLabelsOnlyHasPlaces) {
  const Vocabulary vocabulary(parseLabelPrior(imagenetPrior, "imagenet").labels);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> share(0.8F, 1);
  Images images;
  std::vector<int> places;
  for (int frame = 0; frame < 96; ++frame) {
    places.push_back(frame / 12);
    std::vector<float>& image = images.emplace_back(vocabulary.size());
    for (std::size_t k = 0; k < 3; ++k)
      image[100 * static_cast<std::size_t>(frame / 12) + k] = share(random) * (k == 0 ? 0.5F : 0.2F);
  }
  Mapper mapper(vocabulary);
  EXPECT_GT(measureAgreement(places, mapped(mapper, images).nodes).vMeasure, 0.95);
}

}  // namespace
}  // namespace estancia
