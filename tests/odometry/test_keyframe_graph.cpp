// The graph of keyframes: what is near, what moves, what holds together.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/keyframe_graph.hpp"

#include <gmock/gmock.h>

#include "support/room.hpp"

namespace estancia::test {
namespace {

using odometry::KeyframeGraph;
using odometry::Keyframes;
using Kind = KeyframeGraph::Kind;
using testing::ElementsAre;
using testing::IsEmpty;

const cv::Affine3d kAhead(cv::Vec3d(0, 0, 0.02), cv::Vec3d(0.1, 0, 0));

/// A chain of keyframes, each a step ahead of the one before.
class Chain {
 public:
  explicit Chain(std::size_t length) {
    const Drive drive({Pose::planar(0, 0, 0)});
    view_ = odometry::viewOf(drive.image(0), drive.depth(0), *drive.intrinsics(), {}, "");
    for (std::size_t k = 0; k < length; ++k) append();
  }
  void append() {
    const std::size_t k = keyframes.size();
    const cv::Affine3d pose = k == 0 ? cv::Affine3d::Identity() : keyframes.pose(k - 1) * kAhead;
    keyframes.add(k, view_, pose, {});
    if (k > 0) graph.add({k, k - 1, kAhead, 1e-4 * cv::Matx66d::eye()}, Kind::tracked);
  }
  /// A loop of the latest keyframe that says it is so far [m] from where it is believed.
  void close(std::size_t target, double off, Kind kind = Kind::loop) {
    const std::size_t k = keyframes.size() - 1;
    const cv::Affine3d shift(cv::Vec3d(), cv::Vec3d(off, 0, 0));
    graph.add(
        {k, target, keyframes.pose(target).inv() * keyframes.pose(k) * shift, 1e-4 * cv::Matx66d::eye()},
        kind);
  }
  std::vector<std::size_t> moved(const std::vector<cv::Affine3d>& before) const {
    std::vector<std::size_t> moved;
    for (std::size_t k = 0; k < before.size(); ++k)
      if (cv::norm(before[k].matrix - keyframes.pose(k).matrix) > 1e-6) moved.push_back(k);
    return moved;
  }
  std::vector<cv::Affine3d> poses() const {
    std::vector<cv::Affine3d> poses;
    for (std::size_t k = 0; k < keyframes.size(); ++k) poses.push_back(keyframes.pose(k));
    return poses;
  }

  Keyframes keyframes{{}};
  KeyframeGraph graph;

 private:
  odometry::FrameView view_;
};

TEST(KeyframeGraph, AShortLoopMovesWhatIsNearAndALongOneAll) {
  Chain chain(400);
  auto before = chain.poses();
  chain.close(380, 0.05);
  chain.graph.optimize(chain.keyframes);
  const auto near = chain.moved(before);
  ASSERT_FALSE(near.empty());
  EXPECT_GT(near.front(), 250U);
  EXPECT_EQ(near.back(), 399U);
  before = chain.poses();
  chain.append();
  chain.close(5, 0.05);
  chain.graph.optimize(chain.keyframes);
  EXPECT_GT(chain.moved(before).size(), 350U);
  before = chain.poses();
  chain.append();  // the way over the loop is short now
  chain.close(6, 0.05);
  chain.graph.optimize(chain.keyframes);
  EXPECT_LT(chain.moved(before).size(), 150U);
}

TEST(KeyframeGraph, KnowsWhatIsNearOverLoops) {
  Chain chain(20);
  EXPECT_THAT(chain.graph.around(19, 10), ElementsAre(18, 17));
  EXPECT_THAT(chain.graph.around(10, 10), ElementsAre(11, 9, 12, 8));
  EXPECT_THAT(chain.graph.around(10, 3), ElementsAre(11, 9, 12));
  EXPECT_THAT(chain.graph.around(10, 10, 1), ElementsAre(11, 9));
  EXPECT_THAT(chain.graph.around(10, 10, 5, 11), ElementsAre(9, 8, 7, 6, 5));
  chain.close(2, 0);
  chain.graph.optimize(chain.keyframes);
  EXPECT_THAT(chain.graph.around(19, 10), ElementsAre(2, 18, 3, 1, 17));
  chain.close(9, 3);  // contradicts all
  chain.graph.optimize(chain.keyframes);
  EXPECT_THAT(chain.graph.around(19, 10), ElementsAre(2, 18, 3, 1, 17));
  EXPECT_TRUE(chain.graph.connects(19, 2));
  EXPECT_FALSE(chain.graph.connects(19, 3));
  EXPECT_THAT(Chain(1).graph.around(0, 10), IsEmpty());
}

TEST(KeyframeGraph, FallsIntoPartsWhereNothingWasAligned) {
  Chain chain(4);
  chain.graph.removeEdgesOf(3);
  chain.close(2, 0, Kind::assumed);
  EXPECT_TRUE(chain.graph.isAlone(3));
  EXPECT_FALSE(chain.graph.isOverdetermined(3));
  EXPECT_EQ(chain.graph.referenceOf(3), 2U);
  EXPECT_THAT(chain.graph.parts(4), ElementsAre(0, 0, 0, 3));
  chain.append();
  chain.close(1, 0);
  chain.graph.optimize(chain.keyframes);
  EXPECT_THAT(chain.graph.parts(5), ElementsAre(0, 0, 0, 0, 0));
  EXPECT_FALSE(chain.graph.isAlone(3));
}

}  // namespace
}  // namespace estancia::test
