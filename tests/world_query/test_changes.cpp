// Changes between two drives through a room with boxes.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/changes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "estancia/core/pose.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/world_mapper.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::ScratchFolder;

/// Around a room of 6 × 6 m with boxes on its floor, looking inward.
class BoxesDrive : public test::FlatDrive {
 public:
  explicit BoxesDrive(test::Boxes boxes, double share = 1) : boxes_(std::move(boxes)) {
    intrinsics_ = CameraIntrinsics{160, 120, 130, 130, 79.5, 59.5};
    frames_.resize(static_cast<std::size_t>(24 * share));
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / 24;
      frames_[i].name = "frame " + std::to_string(i);
      frames_[i].room = "bedroom";
      frames_[i].pose =
          test::lookingAt(2.3 * std::cos(angle), 2.3 * std::sin(angle), 1.3, angle + std::numbers::pi, -0.45);
    }
  }
  cv::Mat image(std::size_t) const override { return {120, 160, CV_8UC3, cv::Scalar(10, 20, 30)}; }
  cv::Mat depth(std::size_t i) const override {
    return test::boxesDepth(*frames_[i].pose, *intrinsics_, boxes_);
  }

 private:
  test::Boxes boxes_;
};

const std::array<cv::Vec3d, 2> table{{{-0.4, -0.3, 0}, {0.4, 0.3, 0.5}}},
    box{{{0.9, 0.7, 0}, {1.2, 1.0, 0.35}}}, bin{{{-1.1, 0.8, 0}, {-0.8, 1.1, 0.4}}};

/// Goes on with the map, or begins it.
void drive(const BoxesDrive& drive, const std::filesystem::path& file) {
  const DescriptorSequence labeled = drive.labeled();
  MappingSession session = std::filesystem::exists(file)
                               ? MappingSession::resume(file, labeled.vocabulary, labeled.model)
                               : MappingSession::create(file, labeled.vocabulary, labeled.model, {});
  WorldMapper world(session);
  session.beginDrive({.name = "boxes", .posesAreInMap = true});
  world.beginDrive();
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Frame frame = drive.frame(i);
    world.observe(frame, labeled.descriptors.row(i), drive.image(i), drive.depth(i), *drive.intrinsics());
    session.add(frame, labeled.descriptors.row(i));
  }
  session.finish();
  world.finish();
}

Changes between(const BoxesDrive& before, const BoxesDrive& now) {
  const ScratchFolder folder;
  drive(before, folder / "room.estancia");
  drive(now, folder / "room.estancia");
  return findChanges(folder / "room.estancia");
}

TEST(Changes, NeedTwoDrivesAndAreNoneWhereNothingChanged) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "room.estancia";
  drive(BoxesDrive({table, box}), file);
  EXPECT_THAT([&] { findChanges(file); }, FailsWith(ErrorCode::insufficientData));
  drive(BoxesDrive({table, box}), file);
  const Changes changes = findChanges(file);
  EXPECT_EQ(changes.since, 1U);
  EXPECT_TRUE(changes.objects.empty());
  EXPECT_TRUE(changes.places.empty());
  EXPECT_THAT([&] { findChanges(file, 0); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { findChanges(file, 2); }, FailsWith(ErrorCode::unknownName));
}

TEST(Changes, AreWhatIsGoneAndWhatIsNew) {
  const Changes changes = between(BoxesDrive({table, box}), BoxesDrive({table, bin}));
  ASSERT_EQ(changes.objects.size(), 2U);
  const ObjectChange &gone = changes.objects[0], &now = changes.objects[1];
  EXPECT_EQ(gone.kind, ObjectChange::Kind::gone);
  EXPECT_TRUE(gone.isWhole);
  EXPECT_TRUE(gone.before);
  EXPECT_LT(cv::norm(gone.from - cv::Point3d(1.05, 0.85, 0.2)), 0.15);
  EXPECT_LT(gone.lastBefore, 24U);
  EXPECT_GT(gone.area, 0.1);
  EXPECT_EQ(now.kind, ObjectChange::Kind::appeared);
  EXPECT_LT(cv::norm(now.to - cv::Point3d(-0.95, 0.95, 0.2)), 0.15);
  EXPECT_GE(now.firstNow, 24U);
}

TEST(Changes, AreNotWhatNobodyLookedAtAgain) {
  // The second drive sees the table from one side alone, and neither of the other places.
  BoxesDrive now({table}, 0.1);
  for (std::size_t i = 0; i < now.size(); ++i)
    now.frames_[i].pose =
        test::lookingAt(0, -2.3 + 0.06 * static_cast<double>(i), 1.3, -std::numbers::pi / 2, -0.45);
  EXPECT_TRUE(between(BoxesDrive({table, box}), now).objects.empty());
}

}  // namespace
}  // namespace estancia
