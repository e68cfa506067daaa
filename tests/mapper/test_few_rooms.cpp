// Few rooms: places that hold from two rooms on, when the run itself carries little information about other
// places.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <variant>
#include <vector>

#include "estancia/mapper/mapper.hpp"
#include "estancia/stats/clustering_agreement.hpp"

namespace estancia {
namespace {

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

struct Outcome {
  double vMeasure = 0;
  std::size_t nodes = 0;
};

/// Turns once all around in each room, `visits` times.
Outcome turnAround(std::size_t rooms, std::size_t visits) {
  MadeUpRooms home(rooms);
  Mapper mapper(roomLabels);
  std::vector<int> nodes, truth;
  const auto take = [&] {
    const MapChanges changes = mapper.takeChanges();
    if (changes.restarted) nodes.clear();
    for (const auto& event : changes.events)
      if (const auto* decision = std::get_if<Decision>(&event))
        nodes.push_back(decision->node);
      else
        std::ranges::replace(nodes, std::get<Merge>(event).absorbed, std::get<Merge>(event).kept);
  };
  for (std::size_t visit = 0; visit < visits; ++visit)
    for (std::size_t room = 0; room < rooms; ++room)
      for (int step = 0; step < 24; ++step) {
        mapper.add(home.image(room, step * 0.2618 + static_cast<double>(visit)));
        truth.push_back(static_cast<int>(room));
        take();
      }
  mapper.finish();
  take();
  return {measureAgreement(truth, nodes).vMeasure, mapper.nodes()};
}

class FewRooms : public testing::TestWithParam<std::pair<std::size_t, std::size_t>> {};

TEST_P(FewRooms, AreFewPlaces) {
  const auto [rooms, visits] = GetParam();
  const Outcome outcome = turnAround(rooms, visits);
  EXPECT_GE(outcome.vMeasure, 0.9);
  EXPECT_LE(outcome.nodes, rooms + 2);
}

INSTANTIATE_TEST_SUITE_P(Mapper, FewRooms, testing::Values(std::pair(2, 1), std::pair(3, 6), std::pair(8, 2)),
                         [](const auto& tested) {
                           return std::to_string(tested.param.first) + "Rooms" +
                                  std::to_string(tested.param.second) + "Visits";
                         });

}  // namespace
}  // namespace estancia
