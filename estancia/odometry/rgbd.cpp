// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/rgbd.hpp"

#include <fmt/format.h>

#include <cmath>
#include <future>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/odometry/frame_view.hpp"
#include "estancia/odometry/tracker.hpp"

namespace estancia {
namespace {

/// What does not depend on the frames before, or why a frame cannot be read.
RgbdTracker::View prepared(const Sequence& sequence, std::size_t i, const RgbdTracker& tracker) {
  const std::string& name = sequence.frame(i).name;
  try {
    const cv::Mat depth = sequence.depth(i), image = sequence.image(i);
    return tracker.prepare(image, depth, name);
  } catch (...) {
    odometry::FrameView unread;
    unread.problem = frameFailure(name).what();
    return std::make_shared<const odometry::FrameView>(std::move(unread));
  }
}

void requireRgbd(const Sequence& sequence) {
  if (sequence.size() == 0)
    fail(ErrorCode::insufficientData, "{}: the sequence has no frames", sequence.name());
  if (!sequence.hasDepth())
    fail(ErrorCode::invalidInput,
         "{}: odometry needs depth images; `estancia check` says where they are expected, and "
         "--poses takes a trajectory from elsewhere",
         sequence.name());
  if (!sequence.intrinsics())
    fail(ErrorCode::invalidInput,
         "{}: the camera's intrinsics are missing; give them by --intrinsics (`estancia check` "
         "shows what fits)",
         sequence.name());
}

}  // namespace

OptionGroup declare(RgbdOptions& o) {
  OptionGroup group("odometry", "RGB-D odometry.");
  group.add("term", &o.term, "What alignment minimizes")
      .choices({{"auto", "depth and color, as if these were registered to each other within pixels only"},
                {"depth", "point-to-plane distances; nothing holds along a bare wall"},
                {"color", "differences of gray values; needs texture"},
                {"hybrid", "depth and color; needs both exactly registered"}});
  group.add("max-width", &o.maxWidth, "Images are halved until they are at most this wide")
      .range(48, 4096)
      .unit("pixels")
      .why("Larger images take longer, and gain little with the noise of depth cameras.");
  group.add("max-depth", &o.maxDepth, "Depth beyond is not used").above(0, 1000).unit("m");
  group
      .add("odom-shift", &o.odomShift,
           "Uncertainty of the prior's motion: standard deviation of a step's length, of that length")
      .above(0, 1000)
      .unit("%");
  group.add("odom-turn", &o.odomTurn, "Uncertainty of the prior's turn: standard deviation of a step")
      .above(0, 180)
      .unit("degrees");
  group.add("min-loop-features", &o.minLoopFeatures, "Features that must agree for a loop closure")
      .range(6)
      .why("Raise it where rooms look alike.");
  group.add("threads", &o.threads, "Threads; 0: one a free core. The result does not depend on it")
      .range(0, 1024);
  return group;
}

void validate(const RgbdOptions& options) {
  RgbdOptions copy = options;
  declare(copy).validate();
  const auto require = [](bool fits, const char* name, const auto& value) {
    if (!fits) fail(ErrorCode::invalidOption, "the odometry's {} is {}, which is out of range", name, value);
  };
  require(options.keyframeOverlap >= 0.35 && options.keyframeOverlap <= 1, "keyframe-overlap",
          options.keyframeOverlap);
  require(options.minCorrection >= 0 && std::isfinite(options.minCorrection), "min-correction",
          options.minCorrection);
  require(options.loopCandidates >= 0, "loop-candidates", options.loopCandidates);
}

RgbdTrajectory trackRgbd(const Sequence& sequence, const RgbdOptions& options, const FrameWords& words,
                         Progress& progress, const MotionPrior& prior) {
  validate(options);
  requireRgbd(sequence);
  if (!prior.empty() && prior.size() != sequence.size())
    fail(ErrorCode::mismatch, "{}: the prior has {} poses and the sequence {} frames; give one for each",
         sequence.name(), prior.size(), sequence.size());
  RgbdTracker tracker(*sequence.intrinsics(), options, words.parts);
  const auto read = [&](std::size_t i) { return prepared(sequence, i, tracker); };
  std::future<RgbdTracker::View> next = std::async(std::launch::async, read, 0);
  bool any = false;
  progress.begin("tracking", sequence.size());
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    if (interrupted())
      throw Interrupted(fmt::format(
          "stopped after {} of {} frames; nothing was written, odometry starts anew", i, sequence.size()));
    const RgbdTracker::View view = next.get();
    if (i + 1 < sequence.size()) next = std::async(std::launch::async, read, i + 1);
    const Frame& known = sequence.frame(i);
    FrameFacts facts{known.name, known.timestamp, prior.empty() ? std::nullopt : prior[i], {}};
    if (words.describe) facts.words = [&words, i] { return words.describe(i); };
    any = tracker.add(view, facts).why.empty() || any;
    progress.advance();
  }
  progress.end();
  if (!any)
    fail(ErrorCode::insufficientData, "{}: no frame can be tracked; the first: {}", sequence.name(),
         tracker.at(0).why);
  tracker.settle();
  return tracker.trajectory();
}

}  // namespace estancia
