// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/pose_filter.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "estancia/localization/localizer_map.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

constexpr double pi = std::numbers::pi;

double sumOf(std::span<const float> values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double dot(std::span<const float> a, std::span<const float> b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

std::vector<float> randomState(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform;
  std::vector<float> state(n);
  for (float& p : state) p = uniform(random);
  return state;
}

/// Along the x axis, a pose each 0.25 m, looking ahead.
std::vector<PlanarPose> corridor(int poses = 13) {
  std::vector<PlanarPose> way;
  for (int i = 0; i < poses; ++i) way.push_back({0.25 * i, 0, 0});
  return way;
}

std::size_t stateAt(const PoseGrid& grid, const PlanarPose& pose) {
  std::size_t best = 0;
  double nearest = 1e9;
  for (std::size_t s = 0; s < grid.states(); ++s) {
    const PlanarPose at = grid.poseOf(s);
    const double off =
        std::hypot(at.x - pose.x, at.y - pose.y) + std::abs(wrapped(at.heading - pose.heading));
    if (off < nearest) nearest = off, best = s;
  }
  return best;
}

PoseFilter makeFilter(const std::vector<PlanarPose>& poses) {
  return PoseFilter({poses.begin(), poses.end()}, NearEvidence({0.1F, 0.2F, 0.3F}, {0.8F, 1.0F, 1.2F}), {});
}

TEST(MotionBetween, IsWhatALevelCameraDrove) {
  const PlanarMotion motion =
      motionBetween(Pose::planar(1, 2, 0.5), Pose::planar(1 + std::cos(0.5), 2 + std::sin(0.5), 0.8));
  EXPECT_NEAR(motion.forward, 1, 1e-9);
  EXPECT_NEAR(motion.left, 0, 1e-9);
  EXPECT_NEAR(motion.turn, 0.3, 1e-9);
  EXPECT_NEAR(motionBetween(Pose::planar(0, 0, pi / 2), Pose::planar(-1, 0, pi / 2)).left, 1, 1e-9);
}

TEST(MotionBetween, IsTheSameForATiltedCamera) {
  const cv::Affine3d tilt(cv::Vec3d(0.4, 0, 0), cv::Vec3d(0, 0, 0));
  const Pose from = poseOf(rigidOf(Pose::planar(0, 0, 0)) * tilt),
             to = poseOf(rigidOf(Pose::planar(2, 0, -0.3)) * tilt);
  const PlanarMotion motion = motionBetween(from, to);
  EXPECT_NEAR(motion.forward, 2, 1e-6);
  EXPECT_NEAR(motion.left, 0, 1e-6);
  EXPECT_NEAR(motion.turn, -0.3, 1e-6);
  EXPECT_NEAR(motionBetween(Pose(), poseOf(tilt)).turn, 0, 1e-9) << "a nod is no turn";
}

TEST(PlanarMotion, OfTwoStepsIsThatOfBoth) {
  const Pose a = Pose::planar(0, 0, 0.2), b = Pose::planar(0.5, 1, 1.3), c = Pose::planar(-1, 0.3, 2.9);
  const PlanarMotion both = motionBetween(a, b).then(motionBetween(b, c)), direct = motionBetween(a, c);
  EXPECT_NEAR(both.forward, direct.forward, 1e-9);
  EXPECT_NEAR(both.left, direct.left, 1e-9);
  EXPECT_NEAR(both.turn, direct.turn, 1e-9);
}

TEST(PoseGrid, MovesAStateWhereTheMotionLeads) {
  const PoseGrid grid(corridor(), 0.2, 1.4);
  for (const PlanarPose& from : {PlanarPose{0.5, 0, 0}, {1.5, 0.3, pi / 2}, {2, -0.4, 3}}) {
    std::vector<float> in(grid.states(), 0.0F), out(grid.states(), 0.0F);
    const std::size_t state = stateAt(grid, from);
    in[state] = 1;
    PlanarMotion motion;
    motion.forward = 0.47, motion.left = -0.11, motion.turn = 0.4;
    grid.move(in, motion, out);
    EXPECT_NEAR(sumOf(out), 1, 1e-5);
    const PlanarPose at = grid.poseOf(state);
    double x = 0, y = 0, turn = 0;
    for (std::size_t s = 0; s < grid.states(); ++s) {
      x += out[s] * grid.poseOf(s).x;
      y += out[s] * grid.poseOf(s).y;
      turn += out[s] * wrapped(grid.poseOf(s).heading - at.heading);
    }
    EXPECT_NEAR(x, at.x + std::cos(at.heading) * 0.47 + std::sin(at.heading) * 0.11, 1e-4);
    EXPECT_NEAR(y, at.y + std::sin(at.heading) * 0.47 - std::cos(at.heading) * 0.11, 1e-4);
    EXPECT_NEAR(turn, 0.4, 1e-4);
  }
}

TEST(NearEvidence, FallsWithTheDistanceAndIsTheRatioOfGaussians) {
  std::mt19937 random(5);
  std::normal_distribution<float> near(0.4F, 0.2F), far(1, 0.15F);
  std::vector<float> a(20000), b(20000);
  for (float& d : a) d = near(random);
  for (float& d : b) d = far(random);
  const NearEvidence evidence(a, b);
  for (const double d : {0.4, 0.6, 0.8}) {
    const double expected =
        std::exp(-0.5 * std::pow((d - 0.4) / 0.2, 2) + 0.5 * std::pow((d - 1) / 0.15, 2)) * 0.15 / 0.2;
    EXPECT_NEAR(evidence.ratio(d) / expected, 1, 0.2) << d;
  }
  for (double d = -1; d < 3; d += 0.01) EXPECT_GE(evidence.ratio(d), evidence.ratio(d + 0.01)) << d;
  const NearEvidence equal({0, 0, 0}, {0, 0, 0});
  EXPECT_TRUE(std::isfinite(equal.ratio(0)) && std::isfinite(equal.ratio(5)));
}

TEST(PoseFilter, PredictionKeepsAllProbabilityAndBackwardIsItsTranspose) {
  const PoseFilter filter = makeFilter(corridor(6));
  PlanarMotion known, loose;
  known.forward = 0.5, known.turn = 0.3;
  loose.looseDistance = 0.4, loose.looseTurn = 0.3;
  for (const PlanarMotion& motion : {known, loose}) {
    const auto a = randomState(filter.states(), 6), b = randomState(filter.states(), 7);
    std::vector<float> next(filter.states()), before(filter.states());
    filter.predict(a, motion, next);
    EXPECT_NEAR(sumOf(next), sumOf(a), 1e-3 * sumOf(a));
    EXPECT_GT(std::ranges::min(next), 0);
    filter.backward(b, motion, before);
    EXPECT_NEAR(dot(next, b), dot(a, before), 1e-3 * dot(next, b));
  }
}

/// A tour of a square hall that looks ahead; each frame shows what lies around its pose.
struct Hall {
  explicit Hall(double variation = 1.0) : world(20, 80, variation, 11) {
    for (std::size_t i = 0; i < 80; ++i) {
      const double s = 0.2 * static_cast<double>(i % 20);
      const double side = static_cast<double>(i / 20);
      const double heading = side * pi / 2;
      const double x0[] = {0, 4, 4, 0}, y0[] = {0, 0, 4, 4};
      const auto k = static_cast<std::size_t>(side);
      poses.push_back(Pose::planar(x0[k] + s * std::cos(heading), y0[k] + s * std::sin(heading), heading));
    }
  }

  /// Frames of the mapped tour, twice round, so that near frames are known from two rounds.
  std::shared_ptr<const LocalizerMap> source() {
    std::vector<std::string> labels;
    for (int l = 0; l < 80; ++l) labels.push_back("label " + std::to_string(l));
    NodeBank bank(getDistance("hellinger"), 80);
    TopologicalMap map{.vocabulary = Vocabulary(labels), .distance = "hellinger"};
    DescriptorMatrix images(80);
    for (std::size_t i = 0; i < 160; ++i) {
      const std::vector<float> image = view(i % 80);
      images.append(image);
      MappedFrame frame;
      frame.name = std::to_string(i);
      frame.pose = poses[i % 80];
      frame.node = static_cast<int>(i % 80 / 10);
      map.frames.push_back(frame);
      std::vector<float> embedded(80);
      embed(Embedding::squareRoot, image, embedded);
      if (i < 80 && i % 10 == 0) {
        Node node;
        node.id = frame.node;
        map.nodes.push_back(node);
        bank.add(bank.makeNode(frame.node));
      }
      bank.update(static_cast<std::size_t>(frame.node), [&](NodeMemory& node) {
        ++node.frames;
        node.probabilities.add(image);
        node.embedded->add(embedded);
      });
    }
    return std::make_shared<const LocalizerMap>(LocalizerMap{map, bank, images, 1});
  }

  /// Changes every 0.8 m.
  std::vector<float> view(std::size_t i) { return world.image(i / 4); }

  test::SyntheticPlaces world;
  std::vector<Pose> poses;
};

TEST(PosedLocalizer, MotionTellsWhatLooksDoNot) {
  Hall hall(2.5);
  const auto source = hall.source();
  std::vector<std::vector<float>> again;
  for (std::size_t i = 0; i < 80; ++i) again.push_back(hall.view(i));
  const auto rightOf = [&](bool odometry) {
    Localizer localizer(source, {});
    std::size_t alone = 0, believed = 0;
    for (std::size_t i = 0; i < 80; ++i) {
      const auto answer =
          localizer.add(again[i], odometry ? std::optional(hall.poses[i]) : std::nullopt).front();
      const auto isNear = [&](std::size_t frame) {
        return distanceBetween(*source->map.frames[frame].pose, hall.poses[i]) < 0.7;
      };
      alone += isNear(answer.nearestImage);
      believed += isNear(answer.beliefImage);
    }
    return std::pair(alone, believed);
  };
  const auto [alone, wandering] = rightOf(false);
  const std::size_t driven = rightOf(true).second;
  EXPECT_LT(alone, 48U) << "the test must be hard";
  EXPECT_GT(wandering, alone);
  EXPECT_GT(driven, 64U);
}

TEST(PosedLocalizer, FollowsTheMotionWhereNothingWasMapped) {
  Hall hall;
  Localizer localizer(hall.source(), {});
  Localization answer;
  for (std::size_t i = 0; i < 20; ++i) answer = localizer.add(hall.view(i), hall.poses[i]).front();
  EXPECT_LT(answer.unmapped.value(), 0.5);
  test::SyntheticPlaces elsewhere(80, 80, 1, 99);
  for (int i = 1; i <= 8; ++i)  // turns round where it stands and sees what is not in the map
    answer =
        localizer.add(elsewhere.image(static_cast<std::size_t>(i)), Pose::planar(3.8, 0, i * pi / 8)).front();
  EXPECT_GT(answer.unmapped.value(), 0.8);
  EXPECT_EQ(answer.beliefNode, 1);  // frames 10 … 19
}

TEST(PosedLocalizer, RecoversWhenTheRobotIsCarriedElsewhere) {
  Hall hall;
  Localizer localizer(hall.source(), {});
  Localization answer;
  for (std::size_t i = 0; i < 40; ++i) {
    const std::size_t seen = i < 20 ? i : i + 20;  // from the end of the first side to the third one's begin
    answer = localizer.add(hall.view(seen), Pose::planar(0.2 * static_cast<double>(i), 0, 0)).front();
  }
  EXPECT_EQ(answer.beliefNode, 5);  // frames 50 … 59
}

TEST(PosedLocalizer, AFrameTakenAgainTellsNothingNew) {
  Hall hall;
  const auto source = hall.source();
  Localizer localizer(source, {});
  const auto image = hall.view(30);
  const double first = localizer.add(image, hall.poses[30]).front().confidence;
  double last = 0;
  for (int i = 0; i < 50; ++i) last = localizer.add(image, hall.poses[30]).front().confidence;
  EXPECT_NEAR(last, first, 1e-6);
}

TEST(PosedLocalizer, LooksAheadWithFramesThatAreNoStep) {
  Hall hall(2);
  LocalizerOptions options;
  options.lookahead = 6;
  Localizer localizer(hall.source(), options);
  std::vector<Localization> answers;
  const auto give = [&](const std::vector<Localization>& some) {
    answers.insert(answers.end(), some.begin(), some.end());
  };
  for (std::size_t i = 0; i < 40; ++i)
    for (unsigned twice = 0; twice < 2; ++twice) give(localizer.add(hall.view(i), hall.poses[i]));
  give(localizer.finish());
  ASSERT_EQ(answers.size(), 80U);
  std::size_t right = 0;
  for (std::size_t i = 0; i < 80; ++i) right += answers[i].beliefNode == static_cast<int>(i / 20);
  EXPECT_GE(right, 68U);
}

}  // namespace
}  // namespace estancia
