// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/map_run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/sequences/sequence.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

/// Frames "0", "1", … without images.
class Names : public Sequence {
 public:
  explicit Names(int size) {
    for (int i = 0; i < size; ++i) frames_.emplace_back().name = std::to_string(i);
  }
  std::string name() const override { return "names"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }
  cv::Mat image(std::size_t /*i*/) const override { return {}; }
  std::string fingerprint(std::size_t i) const override { return frames_[i].name; }

 private:
  std::vector<Frame> frames_;
};

class Runs : public testing::Test {
 protected:
  using Existing = MapRun::Existing;

  /// Maps all frames of `sequence` that are not in the map yet.
  std::size_t mapAll(const Names& sequence, Existing existing, double tauJoin = 0.5) const {
    MapRun run(path_, existing);
    const std::size_t first = run.begin(sequence, words_, "test", [&](MapperOptions& options) {
      options.distance = "l2";
      options.tauJoin = tauJoin;
    });
    for (std::size_t i = first; i < sequence.size(); ++i)
      run.add(sequence.frame(i), std::vector<float>{i % 2 == 0 ? 0.9F : 0.1F, 0.1F});
    run.finish();
    return first;
  }

  test::ScratchFolder scratch_;
  const std::filesystem::path path_ = scratch_ / "run.estancia";
  const Vocabulary words_{{"cup", "bed"}};
};

TEST_F(Runs, RefuseAMapThatIsThere) {
  EXPECT_EQ(mapAll(Names(3), Existing::refuse), 0);
  EXPECT_THAT([&] { MapRun(path_, Existing::refuse); }, FailsWith(ErrorCode::fileExists));
}

TEST_F(Runs, ReplaceAMapAtTheFirstFrameOnly) {
  mapAll(Names(3), Existing::refuse);
  {
    MapRun run(path_, Existing::replace);
    EXPECT_EQ(run.vocabulary(), std::nullopt);
    EXPECT_EQ(run.begin(Names(2), words_, "other", [](MapperOptions&) {}), 0);
    run.finish();
    EXPECT_FALSE(run.session());
  }
  EXPECT_EQ(readMap(path_).model, "test") << "no frame came";
  mapAll(Names(2), Existing::replace);
  EXPECT_EQ(readMap(path_).frames.size(), 2);
}

TEST_F(Runs, ResumeAfterTheLastMappedFrameWithTheSameOptions) {
  EXPECT_EQ(mapAll(Names(3), Existing::resume), 0) << "there is no map yet";
  EXPECT_EQ(MapRun(path_, Existing::resume).vocabulary(), words_);
  EXPECT_THAT([&] { mapAll(Names(5), Existing::resume, 0.25); }, FailsWith(ErrorCode::mismatch));
  EXPECT_EQ(readMap(path_).frames.size(), 3);
  EXPECT_EQ(mapAll(Names(5), Existing::resume), 3);
  EXPECT_EQ(readMap(path_).frames.size(), 5);
}

}  // namespace
}  // namespace estancia
