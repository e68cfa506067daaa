// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/rgbd.hpp"

#include <fmt/format.h>

#include <cmath>
#include <future>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/odometry/keyframes.hpp"
#include "estancia/odometry/tracker.hpp"

namespace estancia {
namespace {

/// A frame as it was read.
struct ReadFrame {
  RgbdTracker::View view;
  std::string problem;  ///< why it could not be read
};

/// Reads the next frame while the current one is aligned.
class Prefetcher {
 public:
  Prefetcher(const Sequence& sequence, const RgbdTracker& tracker) : sequence_(sequence), tracker_(tracker) {
    start();
  }

  ReadFrame next() {
    ReadFrame frame = upcoming_.get();
    ++frame_;
    start();
    return frame;
  }

 private:
  void start() {
    if (frame_ < sequence_.size())
      upcoming_ = std::async(std::launch::async, [this, i = frame_] { return read(i); });
  }

  ReadFrame read(std::size_t i) const {
    const std::string& name = sequence_.frame(i).name;
    try {
      const cv::Mat depth = sequence_.depth(i), image = sequence_.image(i);
      return {tracker_.prepare(image, depth, name), ""};
    } catch (...) {
      return {nullptr, frameFailure(name).what()};
    }
  }

  const Sequence& sequence_;
  const RgbdTracker& tracker_;
  std::size_t frame_ = 0;
  std::future<ReadFrame> upcoming_;
};

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
  group.add("term", &o.term, "What alignment minimizes").choices(odometry::alignmentTerms());
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
  Prefetcher frames(sequence, tracker);
  bool any = false;
  progress.begin("tracking", sequence.size());
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    if (interrupted())
      throw Interrupted(fmt::format(
          "stopped after {} of {} frames; nothing was written, odometry starts anew", i, sequence.size()));
    const ReadFrame frame = frames.next();
    const Frame& known = sequence.frame(i);
    FrameFacts facts{known.name, known.timestamp, prior.empty() ? std::nullopt : prior[i], {}};
    if (words.describe) facts.words = [&words, i] { return words.describe(i); };
    const auto placement = frame.view ? tracker.add(frame.view, facts) : tracker.skip(frame.problem, facts);
    any = any || placement.why.empty();
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
