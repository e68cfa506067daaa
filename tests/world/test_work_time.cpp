// What is put off when the next frame is near, and what is not.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/layers/work_time.hpp"

#include <gtest/gtest.h>

#include "estancia/map_file/sqlite.hpp"
#include "estancia/world/world_mapper.hpp"
#include "support/counting_labeler.hpp"
#include "support/flat_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// Frames, views and labeled images of a drive whose deadline is `deadline` from now.
struct Taken {
  std::size_t frames = 0, views = 0, labels = 0;
};
Taken takenBy(const std::function<Deadline()>& deadline) {
  const test::ScratchFolder folder;
  const test::FlatDrive drive;
  const DescriptorSequence labeled = drive.labeled();
  test::CountingLabeler labeler(labeled.vocabulary.labels(), {0.7F, 0.1F, 0.1F, 0.1F});
  MappingSession session =
      MappingSession::create(folder / "flat.estancia", labeled.vocabulary, labeled.model, {});
  WorldMapper world(session, &labeler);
  const auto hear = [](int, const std::optional<Pose>&) {};
  for (std::size_t i = 0; i < drive.size(); ++i)
    world.add(
        drive.frame(i), labeled.descriptors.row(i), drive.image(i), drive.depth(i), *drive.intrinsics(),
        [] { return std::vector<unsigned char>(); }, hear, deadline());
  session.finish();
  world.finish();
  sqlite::Database database(folder / "flat.estancia", sqlite::Database::Mode::read);
  return {session.frames(), static_cast<std::size_t>(database.number("SELECT count(*) FROM observations")),
          labeler.asked};
}

TEST(WorkTime, LeavesEveryFrameInTheMapWithFewerViews) {
  const Taken all = takenBy([] { return Deadline(); });
  EXPECT_EQ(all.frames, 64U);
  EXPECT_EQ(all.views, 64U);
  const Taken late = takenBy([] { return Clock::now() - 1s; });
  EXPECT_EQ(late.frames, all.frames);
  EXPECT_GE(late.views, 1U);
  EXPECT_LE(late.views, all.views) << "one in a fifth of a second";
  EXPECT_LE(late.labels, all.labels);
}

}  // namespace
}  // namespace estancia
