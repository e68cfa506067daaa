// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/node_bank.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/session/session.hpp"
#include "estancia/session/session_impl.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

/// Drives through six places by day, in the evening, and in the evening again.
class Evenings : public testing::Test {
 protected:
  static constexpr std::size_t labels = 80;
  static Vocabulary words() {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < labels; ++i) names.push_back("word " + std::to_string(i));
    return Vocabulary(names);
  }
  std::vector<float> image(std::size_t place, bool isEvening) {
    std::vector<float> p = places_.image(place);
    if (!isEvening) return p;
    const std::vector<float> light = lights_.image(place);
    float sum = 0;
    for (std::size_t i = 0; i < labels; ++i) sum += p[i] = std::pow(p[i], 0.57F) * std::pow(light[i], 0.43F);
    for (float& value : p) value /= sum;
    return p;
  }
  void drive(MappingSession& session, bool isEvening) {
    if (session.frames() > 0) session.beginDrive();
    for (std::size_t i = 0; i < 72; ++i) {
      Frame frame;
      frame.name = std::to_string(session.frames());
      frame.pose = Pose::planar(2.0 * static_cast<double>(i / 6 % 6), 0, 0);
      session.add(frame, image(i / 6 % 6, isEvening));
    }
  }

  test::ScratchFolder folder_;
  test::SyntheticPlaces places_{6, labels, 0.4}, lights_{6, labels, 0.1, 11};
};

TEST_F(Evenings, AreModesOfTheirPlaces) {
  {
    MappingSession session = MappingSession::create(folder_ / "map", words(), "test", {});
    for (const bool isEvening : {false, true, true}) drive(session, isEvening);
    session.finish();
    EXPECT_EQ(session.mapper().nodes(), 6U);
  }
  const MapStore store = MapStore::open(folder_ / "map", MapStore::Access::read);
  Mapper mapper = restoreMapper(store);
  mapper.impl().endModes();
  const NodeBank& bank = mapper.impl().bank;
  EXPECT_EQ(bank.rows(), bank.size() * 3) << "day and evening, and the mean";
  const Distance distance = getDistance("standardized-clr");
  for (std::size_t place = 0; place < 6; ++place) {
    std::vector<float> embedded(labels);
    embed(distance.embedding, image(place, true), embedded, distance.parts);
    const std::vector<float> seen = bank.compared(embedded);
    const auto found = bank.nearest(seen, bank.size());
    EXPECT_EQ(bank[found->slot].id, static_cast<int>(place));
    EXPECT_LT(found->distance, 1 - dot(bank.mean(found->slot), seen)) << "nearer than the mean";
  }
}

}  // namespace
}  // namespace estancia
