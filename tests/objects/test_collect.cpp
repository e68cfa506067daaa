// Instances collected from a drive, and followed from frame to frame.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/core/affine.hpp>
#include <set>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/take_interrupt.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/collect.hpp"
#include "estancia/objects/tracks.hpp"
#include "estancia/readers/object_samples.hpp"
#include "support/errors.hpp"
#include "support/table_scene.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TableSequence twoThings(const std::vector<double>& degrees = {0, 20, 40, 60, 80}) {
  return {{ballAt(0.1, 0.12, 0.06, red), boxAt(-0.05, -0.12, {0.05, 0.04, 0.07}, blue)}, degrees};
}

class Collect : public testing::Test {
 protected:
  Collected collect(const Sequence& sequence, const CollectOptions& options = {}) {
    problems_.clear();
    return collectObjects(sequence, folder_, options, Progress::none(), &problems_);
  }
  std::vector<ObjectSample> samples() const { return readObjectSamples(folder_); }

  ScratchFolder scratch_;
  const fs::path folder_ = scratch_ / "things";
  std::vector<std::string> problems_;
};

/// The color that the middle of a sample's box has.
cv::Vec3b middleOf(const ObjectImage& image) {
  return image.image.at<cv::Vec3b>(image.box.y + image.box.height / 2, image.box.x + image.box.width / 2);
}

TEST_F(Collect, ViewsOfAThingStayOneInstanceAllAround) {
  const Collected c = collect(twoThings());
  EXPECT_EQ(c.frames, 5U);
  EXPECT_EQ(c.samples, 10U);
  EXPECT_EQ(c.instances, 2U);
  EXPECT_THAT(problems_, IsEmpty());
  const auto views = openObjectViews(folder_);
  ASSERT_EQ(views->size(), 10U);
  std::map<std::string, std::set<std::string>> framesOf;
  for (std::size_t i = 0; i < views->size(); ++i) {
    const ObjectView& view = views->view(i);
    framesOf[view.instance].insert(view.frame);
    const ObjectImage image = views->image(i);
    EXPECT_EQ(image.image.size(), image.mask.size());
    const PointCloud cloud = views->cloud(i);
    const cv::Vec3b color = middleOf(image);
    ASSERT_THAT(cloud.colors, SizeIs(cloud.points.size()));
    EXPECT_EQ(cloud.colors[cloud.colors.size() / 2], color);
    EXPECT_TRUE(color == red || color == blue) << view.name;
  }
  EXPECT_THAT(framesOf, SizeIs(2));
  for (const auto& [instance, frames] : framesOf) EXPECT_THAT(frames, SizeIs(5)) << instance;
}

TEST_F(Collect, LabelersSeeOfASampleWhatTheySeeOfItsFrame) {
  const TableSequence sequence = twoThings({0});
  collect(sequence);
  const ClusteredFrame frame =
      clusteredFrame(sequence.image(0), sequence.depth(0), *sequence.intrinsics(), ClusterOptions());
  const auto views = openObjectViews(folder_);
  ASSERT_EQ(views->size(), 2U);
  using Background = CropOptions::Background;
  for (const Background background : {Background::kept, Background::gray, Background::mean})
    for (const double margin : {0., 0.5}) {
      CropOptions options;
      options.background = background;
      options.margin = margin;
      const auto patches = cropsOf(*views, options);
      for (std::size_t i = 0; i < 2; ++i) {
        const cv::Mat expected = cropObject(frame, i, options), seen = patches->image(i);
        ASSERT_EQ(seen.size(), expected.size());
        EXPECT_EQ(cv::norm(seen, expected, cv::NORM_INF), 0) << "margin " << margin << ", thing " << i;
      }
    }
}

TEST_F(Collect, OnlySoManyFramesAndViews) {
  const Collected c = collect(twoThings(), {.every = 2, .maxViews = 2});
  EXPECT_EQ(c.frames, 3U);
  EXPECT_EQ(c.samples, 4U);
  EXPECT_EQ(c.full, 2U);
}

TEST_F(Collect, AFrameWithoutDepthIsToldAndLeftOut) {
  TableSequence sequence = twoThings();
  sequence.loseDepth(1);
  const Collected c = collect(sequence);
  EXPECT_EQ(c.unread, 1U);
  EXPECT_EQ(c.samples, 8U);
  ASSERT_EQ(problems_.size(), 1U);
  EXPECT_EQ(problems_[0].substr(0, 8), "0001.png");
  for (std::size_t i = 0; i < sequence.size(); ++i) sequence.loseDepth(i);
  fs::remove_all(folder_);
  EXPECT_THAT([&] { collect(sequence); }, FailsWith(ErrorCode::fileUnreadable));
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(Collect, NothingOnTheTableOrNoTableIsNoError) {
  const Collected c = collect(TableSequence({}, {0, 10}));
  EXPECT_EQ(c.withoutCluster, 2U);
  EXPECT_EQ(c.samples, 0U);
  EXPECT_FALSE(fs::exists(folder_));
  const Collected floating = collect(TableSequence({ballAt(0, 0, 0.06, red)}, {0, 10}, false));
  EXPECT_EQ(floating.withoutPlane, 2U);
  EXPECT_EQ(floating.samples, 2U);
}

TEST_F(Collect, WhatTheBorderCutsIsMarked) {
  const Collected c =
      collect(TableSequence({boxAt(-0.1, 0.55, {0.1, 0.1, 0.1}, red), ballAt(0, 0, 0.06, blue)}, {0}));
  ASSERT_EQ(c.samples, 2U);
  EXPECT_EQ(c.atBorder, 1U);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto views = openObjectViews(folder_);
    EXPECT_EQ(views->view(i).atBorder, middleOf(views->image(i)) == red);
  }
}

TEST_F(Collect, WhatIsThereIsReplacedOnPurposeAndLast) {
  CollectOptions replacing;
  replacing.replace = true;
  writeFile(folder_ / "notes.txt", "mine");
  EXPECT_THAT([&] { collect(twoThings()); }, FailsWith(ErrorCode::fileExists));
  EXPECT_THAT([&] { collect(twoThings(), replacing); }, FailsWith(ErrorCode::fileExists));
  fs::remove_all(folder_);
  collect(twoThings({0}));
  writeFile(folder_ / "kitchen.objects", "mine");
  EXPECT_THAT([&] { collect(twoThings(), replacing); }, FailsWith(ErrorCode::fileExists));
  EXPECT_THAT(samples(), SizeIs(2)) << "nothing is deleted then";
  fs::remove(folder_ / "kitchen.objects");
  writeFile(labelFileOf(folder_), "words");

  CollectOptions wrong = replacing;
  wrong.first = 17;
  EXPECT_THAT([&] { collect(twoThings(), wrong); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_EQ(collect(TableSequence({}, {0}), replacing).samples, 0U);
  EXPECT_TRUE(fs::exists(labelFileOf(folder_))) << "nothing new, so what was there stays";
  EXPECT_EQ(collect(twoThings({0, 10}), replacing).samples, 4U);
  EXPECT_THAT(samples(), SizeIs(4));
  EXPECT_FALSE(fs::exists(labelFileOf(folder_))) << "they were of other samples";
  EXPECT_FALSE(fs::exists(folder_.string() + ".part"));
}

TEST_F(Collect, AKilledRunIsNotInTheWay) {
  const fs::path part = folder_.string() + ".part";
  fs::create_directories(part);
  writeObjectSamples({}, part);
  writeFile(part / "images/thing-0000-0000.png", "half of it");
  EXPECT_EQ(collect(twoThings({0})).samples, 2U);
  EXPECT_FALSE(fs::exists(part));
  fs::remove_all(folder_);
  writeFile(part / "notes.txt", "mine");
  EXPECT_THAT([&] { collect(twoThings({0})); }, FailsWith(ErrorCode::fileExists));
  EXPECT_TRUE(fs::exists(part / "notes.txt"));
}

/// The second image is none that can be segmented.
class Colorless : public TableSequence {
 public:
  using TableSequence::TableSequence;
  cv::Mat image(std::size_t i) const override {
    const cv::Mat image = TableSequence::image(i);
    return i == 1 ? cv::Mat(image.size(), CV_8U, cv::Scalar(0)) : image;
  }
};

TEST_F(Collect, AFrameThatCannotBeSegmentedCostsItselfOnly) {
  const Colorless sequence({ballAt(0, 0, 0.06, red)}, {0, 5, 10});
  EXPECT_EQ(collect(sequence).samples, 2U);
  EXPECT_THAT(problems_, ElementsAre(testing::StartsWith("0001.png")));
}

/// Asks to stop while the third frame is read.
class Stopped : public TableSequence {
 public:
  using TableSequence::TableSequence;
  cv::Mat depth(std::size_t i) const override {
    if (i == 2) requestInterrupt();
    return TableSequence::depth(i);
  }
};

TEST_F(Collect, AnInterruptedRunKeepsWhatItHas) {
  const Stopped sequence({ballAt(0, 0, 0.06, red)}, {0, 5, 10, 15, 20});
  EXPECT_THAT([&] { collect(sequence); }, FailsWith(ErrorCode::interrupted));
  EXPECT_TRUE(takeInterrupt());
  EXPECT_THAT(samples(), SizeIs(3));
}

TEST_F(Collect, WhatCannotBeCollectedIsRefused) {
  TableSequence sequence = twoThings({0});
  EXPECT_THAT([&] { collect(sequence, {.every = 0}); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { collectObjects(sequence, "", {}); }, FailsWith(ErrorCode::invalidOption));
  sequence.loseCamera();
  EXPECT_THAT([&] { collect(sequence); }, FailsWith(ErrorCode::invalidInput));
  sequence.loseAllDepth();
  EXPECT_THAT([&] { collect(sequence); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_FALSE(fs::exists(folder_));
}

TEST(ClusteredFrame, ImageAndDepthMayDifferInSize) {
  const TableSequence sequence = twoThings({0});
  cv::Mat twice(480, 640, CV_8UC3);
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) twice.at<cv::Vec3b>(v, u) = sequence.image(0).at<cv::Vec3b>(v / 2, u / 2);
  const auto small = clusteredFrame(sequence.image(0), sequence.depth(0), *sequence.intrinsics());
  const auto large = clusteredFrame(twice, sequence.depth(0), *sequence.intrinsics());
  ASSERT_EQ(small.clusters.clusters.size(), 2U);
  ASSERT_EQ(large.clusters.clusters.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(boxOf(large, i).width, 2 * boxOf(small, i).width);
    EXPECT_EQ(boxOf(large, i).y, 2 * boxOf(small, i).y);
    EXPECT_EQ(cloudOf(large, i).colors, cloudOf(small, i).colors);
  }
}

const CameraIntrinsics camera{640, 480, 525, 525, 319.5, 239.5};

/// A ball's cluster as a camera at `pose` sees it.
Cluster ball(const cv::Vec3d& inMap, double radius, const Pose& pose = {}) {
  const cv::Vec3d c = rigidOf(pose).inv() * inMap;
  const double u = camera.fx * c[0] / c[2] + camera.cx, v = camera.fy * c[1] / c[2] + camera.cy;
  const double r = camera.fx * radius / c[2];
  Cluster cluster;
  cluster.center = cv::Point3f(cv::Vec3f(c));
  cluster.box = cv::Rect(cvRound(u - r), cvRound(v - r), cvRound(2 * r), cvRound(2 * r));
  return cluster;
}

Clusters of(std::vector<Cluster> clusters) {
  return {{}, std::move(clusters)};
}

TEST(Tracks, KeepTheNumbersWhateverTheOrder) {
  Tracks tracks;
  const Cluster left = ball({-0.3, 0, 1}, 0.05), right = ball({0.3, 0, 1}, 0.05);
  EXPECT_THAT(tracks.follow(of({left, right}), camera, {}), ElementsAre(0, 1));
  EXPECT_THAT(tracks.follow(of({ball({0.31, 0.01, 1}, 0.05), ball({-0.29, 0, 1.01}, 0.05)}), camera, {}),
              ElementsAre(1, 0));
  EXPECT_THAT(tracks.follow(of({}), camera, {}), IsEmpty());
}

TEST(Tracks, NoTwoClustersAreOneThing) {
  Tracks tracks;
  tracks.follow(of({ball({0, 0, 1}, 0.1)}), camera, {});
  const auto things = tracks.follow(of({ball({0.02, 0, 1}, 0.1), ball({0.004, 0, 1}, 0.1)}), camera, {});
  EXPECT_THAT(things, ElementsAre(1, 0)) << "the one that overlaps more keeps the number";
}

TEST(Tracks, TellWhichThingsMayBeFoundAgain) {
  Tracks tracks;
  const Cluster left = ball({-0.3, 0, 1}, 0.05), right = ball({0.3, 0, 1}, 0.05);
  tracks.follow(of({left, right}), camera, {});
  for (int frame = 0; frame < 5; ++frame) tracks.follow(of({right}), camera, {});
  EXPECT_THAT(tracks.tracked(), ElementsAre(0, 1));
  tracks.follow(of({right}), camera, {});
  EXPECT_THAT(tracks.tracked(), ElementsAre(1));
  tracks.follow(of({left, right}), camera, {});
  EXPECT_THAT(tracks.tracked(), ElementsAre(1, 2)) << "it is new to whoever has forgotten it";
}

TEST(Tracks, WhatCoversTheSamePixelsFarBehindIsAnotherThing) {
  Tracks tracks;
  tracks.follow(of({ball({0, 0, 1}, 0.05)}), camera, {});
  EXPECT_THAT(tracks.follow(of({ball({0, 0, 2}, 0.1)}), camera, {}), ElementsAre(1));
}

TEST(Tracks, PosesLetTheCameraMoveFar) {
  const cv::Vec3d mug(0, 0, 1.2), can(0.15, 0, 1.2);
  const Pose start;
  const Pose later = poseOf(cv::Affine3d(cv::Vec3d(0, -0.2, 0), cv::Vec3d(0.5, 0, 0.1)));
  for (const bool posed : {true, false}) {
    Tracks tracks;
    const auto known = [&](const Pose& pose) { return posed ? std::optional(pose) : std::nullopt; };
    EXPECT_THAT(tracks.follow(of({ball(mug, 0.05, start), ball(can, 0.05, start)}), camera, known(start)),
                ElementsAre(0, 1));
    const auto things =
        tracks.follow(of({ball(can, 0.05, later), ball(mug, 0.05, later)}), camera, known(later));
    if (posed)
      EXPECT_THAT(things, ElementsAre(1, 0));
    else
      EXPECT_THAT(things, ElementsAre(2, 3)) << "nothing lies where it was";
  }
}

TEST(Tracks, AFrameWithoutAPoseGoesByThePixels) {
  Tracks tracks;
  const Cluster mug = ball({0, 0, 1}, 0.05);
  EXPECT_THAT(tracks.follow(of({mug}), camera, Pose{}), ElementsAre(0));
  EXPECT_THAT(tracks.follow(of({mug}), camera, {}), ElementsAre(0));
  Pose broken;
  broken.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(tracks.follow(of({mug}), camera, broken), ElementsAre(0));
  EXPECT_THAT(tracks.follow(of({mug}), camera, Pose{}), ElementsAre(0));
}

TEST(Tracks, RefuseWhatTheyCannotWorkWith) {
  EXPECT_THAT([] { Tracks().follow({}, {}, {}); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia::test
