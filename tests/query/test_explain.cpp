// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/query/explain.hpp"
#include "map_file/sample_map.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

TEST(Explain, EveryKindOfDecision) {
  const TopologicalMap map = test::sampleMap();
  EXPECT_THAT(explain(map, 0), ElementsAre("Frame 0 (a.jpg) made node 0.",
                                           "It was the first image: there was nothing to compare it with."));
  EXPECT_THAT(explain(map, 1),
              ElementsAre("Frame 1 (b.jpg) stayed in node 0.",
                          "Its distance to the current node 0, 0.1, is below tau_join 0.3: it stayed there, "
                          "and no other node was compared.",
                          "With a tau_join of 0.1 or less it would have left node 0."));
  EXPECT_THAT(
      explain(map, 6),
      ElementsAre("Frame 6 (g.jpg) returned to node 1.",
                  "Its distance to the current node 3, 0.65, is not below tau_join 0.3: it left that node.",
                  "The nearest other node, 1, is 0.1 away, below tau_revisit 0.25 and nearer than the "
                  "current one: it moved there.",
                  "With a tau_join above 0.65 it would have stayed in node 3; with a tau_revisit of 0.1 or "
                  "less it would have made a new node."));
  EXPECT_EQ(explain(map, 4)[2],
            "The nearest other node, 1, is 0.6 away, not below tau_revisit 0.25: it made a new node, 3.");
  EXPECT_EQ(explain(map, 2).size(), 5U) << "compared with no other node, and merged later";
  EXPECT_EQ(explain(map, 3).back(),
            "After frame 5 node 2 turned out to be the same place as node 1 (distance 0.12, below 0.2): the "
            "frame belongs to node 1 since.");
  EXPECT_EQ(explain(map, 6).size(), 4U) << "the merge was before that frame";
}

TEST(Explain, AnImageOfAnotherSideOfAPlace) {
  TopologicalMap map = test::sampleMap();
  map.decisions[6].toCurrent = 0.2;
  EXPECT_EQ(explain(map, 6).size(), 2U) << "no threshold would have changed it";
  Decision& stayed = map.decisions[1];
  stayed.toCurrent = 0.4;
  stayed.other = stayed.current;
  stayed.toOther = 0.1;
  stayed.tauRevisit = 0.25;
  EXPECT_EQ(
      explain(map, 1)[1],
      "Its distance to the current node 0, 0.4, is not below tau_join 0.3, but an earlier image of that "
      "node is 0.1 away, below 0.25: it stayed there.");
  Decision& made = map.decisions[4];
  made.toOther = made.toCurrent = 0.2;
  made.tauJoin = 0.1;
  EXPECT_EQ(explain(map, 4)[2],
            "The nearest other node, 1, is 0.2 away, below tau_revisit 0.25 but not nearer than the current "
            "one: it made a new node, 3.");
}

TEST(Explain, FindsFramesByNameThenByNumber) {
  TopologicalMap map = test::sampleMap();
  EXPECT_EQ(getFrame(map, "d.jpg"), 3U);
  EXPECT_EQ(getFrame(map, "3"), 3U);
  map.frames[6].name = "3";
  EXPECT_EQ(getFrame(map, "3"), 6U);
  map.frames[6].name = "7";
  EXPECT_THAT([&] { explain(map, 7); }, FailsWith(ErrorCode::unknownName)) << "a number, not a name";
}

TEST(Explain, AsksForANumberWhereDrivesNameTheirImagesAlike) {
  TopologicalMap map = test::sampleMap();
  map.drives = {{0, "monday"}, {4, "tuesday"}};
  for (std::size_t i = 0; i < map.frames.size(); ++i) map.frames[i].number = 10 * i;
  map.frames[5].name = map.frames[1].name;
  EXPECT_THAT([&] { getFrame(map, "b.jpg"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_EQ(getFrame(map, "50"), 5U);
  EXPECT_THAT([&] { getFrame(map, "5"); }, FailsWith(ErrorCode::unknownName));
}

TEST(Explain, SaysWhichFramesThereAre) {
  TopologicalMap map = test::sampleMap();
  for (const char* wrong : {"7", "x.jpg", "-1", "3x", "", "99999999999999999999999"})
    EXPECT_THAT([&] { getFrame(map, wrong); }, FailsWith(ErrorCode::unknownName)) << wrong;
  map.decisions.clear();
  EXPECT_THAT([&] { explain(map, 2); }, FailsWith(ErrorCode::insufficientData));
  map.frames.clear();
  EXPECT_THAT([&] { explain(map, 0); }, FailsWith(ErrorCode::insufficientData));
}

}  // namespace
}  // namespace estancia
