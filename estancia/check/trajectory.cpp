// Checks time stamps and poses without the images.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/check/checklist.hpp"

namespace estancia::check {
namespace {

/// Gaps spoil a map only if the robot moved meanwhile. Returns in which gaps it waited, "" for none.
std::string checkGaps(const Sequence& sequence, double median, Checklist& list) {
  constexpr double harmless = 2;  // [m]
  const double longest = std::max(1.0, 10 * median);
  std::size_t gaps = 0, waits = 0;
  double largest = 0, longestWait = 0;
  std::string first, waitedBefore;
  for (std::size_t i = 1; i < sequence.size(); ++i) {
    const Frame &from = sequence.frame(i - 1), &to = sequence.frame(i);
    if (!from.timestamp || !to.timestamp || !(*to.timestamp - *from.timestamp > longest)) continue;
    const double lasted = *to.timestamp - *from.timestamp;
    if (from.pose && to.pose && distanceBetween(*from.pose, *to.pose) < harmless) {
      ++waits;
      if (lasted > longestWait) waitedBefore = to.name;
      longestWait = std::max(longestWait, lasted);
      continue;
    }
    if (gaps++ == 0) first = to.name;
    largest = std::max(largest, lasted);
  }
  if (gaps > 0)
    list.add(Severity::warning, "time-gap", "There are gaps in time",
             fmt::format("{} between {} frames, the first before {}, the largest {:.1f} s; usually {:.3f} s",
                         gaps, sequence.size(), first, largest, median),
             "record without pauses, or treat the parts as sequences of their own");
  if (waits == 0) return "";
  return fmt::format("gaps: {}, the longest {:.1f} s before {}; the poses move less than {} m there", waits,
                     longestWait, waitedBefore, harmless);
}

void checkOrder(const Sequence& sequence, Checklist& list) {
  std::size_t stamped = 0, earlier = 0, doubled = 0;
  std::string firstEarlier, firstDoubled;
  const Frame* previous = nullptr;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const Frame& frame = sequence.frame(i);
    if (!frame.timestamp) continue;
    ++stamped;
    if (previous != nullptr) {
      const double interval = *frame.timestamp - *previous->timestamp;
      if (interval < 0 && earlier++ == 0) firstEarlier = frame.name;
      if (interval == 0 && doubled++ == 0) firstDoubled = frame.name;
    }
    previous = &frame;
  }
  if (stamped == 0) return;
  const std::size_t before = list.faults();
  if (earlier > 0)
    list.add(severityOfMissing(earlier, stamped), "time-order", "Time stamps run backwards",
             fmt::format("{}, first {}", share(earlier, stamped, "frames are earlier than the one before"),
                         firstEarlier),
             "sort the frames by time, and use one clock for all");
  if (doubled > 0)
    list.add(severityOfMissing(doubled, stamped), "time-doubled", "Time stamps are doubled",
             fmt::format("{}, first {}", share(doubled, stamped, "frames"), firstDoubled),
             "write stamps with all their digits, and every frame once");
  if (stamped < sequence.size())
    list.add(severityOfMissing(sequence.size() - stamped, sequence.size()), "time-missing",
             "Time stamps are missing", share(sequence.size() - stamped, sequence.size(), "frames"),
             "stamp every frame, or none");
  const auto median = frameInterval(sequence);
  if (!median) return;
  const std::string waits = checkGaps(sequence, *median, list);
  if (list.faults() != before) return;
  const std::string evidence = fmt::format("{} frames, every {:.3f} s", stamped, *median);
  if (waits.empty())
    list.fine("times", "Time stamps are in order and without gaps", evidence);
  else
    list.fine("times", "Time stamps are in order; in their gaps the camera hardly moved",
              evidence + "; " + waits);
}

void checkDepthTimes(const Sequence& sequence, Checklist& list) {
  std::vector<double> delays, distances;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const auto time = sequence.frame(i).timestamp, depthTime = sequence.depthTimestamp(i);
    if (!time || !depthTime) continue;
    delays.push_back(*depthTime - *time);
    distances.push_back(std::abs(delays.back()));
  }
  if (distances.empty()) return;
  const double median = medianOf(distances), delay = medianOf(delays);
  const auto far =
      static_cast<std::size_t>(std::ranges::count_if(distances, [](double d) { return d > synchronous; }));
  const std::string evidence =
      fmt::format("median |Δt| {:.1f} ms (depth − color {:+.1f} ms); {} have none within {:.0f} ms",
                  1e3 * median, 1e3 * delay, share(far, distances.size(), "frames"), 1e3 * synchronous);
  if (20 * far >= distances.size())
    list.add(
        severityOfMissing(far, distances.size()), "depth-time", "Color and depth are not synchronous",
        evidence,
        "stamp both by one clock and trigger them together; a constant delay can be subtracted in depth.txt");
  else
    list.fine("depth-times", "Color and depth are synchronous", evidence);
}

bool sameRotation(const Pose& a, const Pose& b) {
  return std::abs(a.qx * b.qx + a.qy * b.qy + a.qz * b.qz + a.qw * b.qw) > 1 - 1e-12;
}

/// Frames that have a pose, and the poses.
struct Posed {
  std::vector<std::size_t> index;
  std::vector<Pose> pose;
};

/// How to repair the clock of a trajectory that fits no frame.
std::string clockFix(std::pair<double, double> trajectory, std::pair<double, double> frames) {
  const double longer = (trajectory.second - trajectory.first) / (frames.second - frames.first);
  for (const auto& [factor, unit] :
       {std::pair{1e3, "milliseconds"}, std::pair{1e6, "microseconds"}, std::pair{1e9, "nanoseconds"}})
    if (std::abs(longer / factor - 1) < 0.1)
      return fmt::format("its stamps look like {}: divide them by {:.0f}", unit, factor);
  return "stamp it by the clock of the images, in seconds, or allow a larger --max-pose-gap";
}

void checkClock(const Sequence& sequence, Checklist& list) {
  const auto& source = sequence.poseSource();
  if (!source || !source->otherClock) return;
  const Frame &first = sequence.frame(0), &last = sequence.frame(sequence.size() - 1);
  if (!first.timestamp || !last.timestamp) return;
  const auto [begin, end] = *source->otherClock;
  list.add(Severity::warning, "pose-clock",
           "The trajectory is of another clock: none of its stamps fits an image, poses went by order",
           fmt::format("it lasts from {:.3f} to {:.3f}, {} images from {:.3f} to {:.3f} s", begin, end,
                       sequence.size(), *first.timestamp, *last.timestamp),
           clockFix({begin, end}, {*first.timestamp, *last.timestamp}));
}

void checkCoverage(const Sequence& sequence, const Posed& posed, Checklist& list) {
  const std::size_t all = sequence.size(), missing = all - posed.pose.size();
  if (missing == 0) return;
  const std::size_t leading = posed.index.front(), trailing = all - 1 - posed.index.back();
  if (leading + trailing > missing / 2 && leading + trailing > 1)
    list.add(severityOfMissing(missing, all), "pose-short", "The trajectory is shorter than the sequence",
             fmt::format("{} have a pose: the first {} and the last {} have none",
                         share(posed.pose.size(), all, "frames"), leading, trailing),
             "give the whole trajectory, or cut the frames that it does not cover");
  else
    list.add(severityOfMissing(missing, all), "pose-missing", "Poses are missing, NaN or no rotation",
             fmt::format("{} have none, here and there", share(missing, all, "frames")),
             "leave out what the tracker lost instead of writing NaN or 0, or allow a larger --max-pose-gap");
}

/// Distances from pose to pose, and between any two.
struct Steps {
  std::vector<double> lengths;
  double meanLength = 0, meanDistance = 0;
};

Steps stepsOf(const std::vector<Pose>& poses) {
  Steps steps;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    steps.lengths.push_back(distanceBetween(poses[i - 1], poses[i]));
    steps.meanLength += steps.lengths.back() / static_cast<double>(poses.size() - 1);
  }
  const auto some = evenly(poses.size(), 300);  // poses that are compared in pairs
  double sum = 0;
  for (const std::size_t i : some)
    for (const std::size_t j : some) sum += distanceBetween(poses[i], poses[j]);
  steps.meanDistance = sum / static_cast<double>(some.size() * (some.size() - 1));
  return steps;
}

void checkJumps(const Sequence& sequence, const Posed& posed, const Steps& steps, Checklist& list) {
  std::vector<double> sorted = steps.lengths;
  std::ranges::sort(sorted);
  const double longStep = sorted[(sorted.size() - 1) * 95 / 100];
  const double limit = std::max({8 * longStep, 0.1 * steps.meanDistance, 1e-6});
  const auto usual = frameInterval(sequence);
  std::size_t jumps = 0, first = 0;
  double largest = 0;
  for (std::size_t i = 0; i < steps.lengths.size(); ++i) {
    // Steps are longer where frames or poses are missing.
    auto skipped = static_cast<double>(posed.index[i + 1] - posed.index[i]);
    const auto from = sequence.frame(posed.index[i]).timestamp,
               to = sequence.frame(posed.index[i + 1]).timestamp;
    if (usual && from && to) skipped = std::max(skipped, (*to - *from) / *usual);
    if (steps.lengths[i] <= limit * skipped) continue;
    if (jumps++ == 0) first = posed.index[i + 1];
    largest = std::max(largest, steps.lengths[i]);
  }
  if (jumps > 0)
    list.add(
        severityOfMissing(jumps, steps.lengths.size()), "pose-jump", "The trajectory jumps",
        fmt::format("{} longer than {:.3g} m, the longest {:.3g} m, first at {}",
                    share(jumps, steps.lengths.size(), "steps"), limit, largest, sequence.frame(first).name),
        "tracking was lost or a loop was closed there: use the optimized trajectory, or cut at the jumps");
}

void checkSpeed(const Sequence& sequence, const Posed& posed, const Steps& steps, Checklist& list) {
  std::vector<double> speeds;
  for (std::size_t i = 0; i < steps.lengths.size(); ++i) {
    const auto from = sequence.frame(posed.index[i]).timestamp,
               to = sequence.frame(posed.index[i + 1]).timestamp;
    if (from && to && *to > *from) speeds.push_back(steps.lengths[i] / (*to - *from));
  }
  constexpr double fastest = 60;  // [m/s] of a car
  if (speeds.empty()) return;
  if (const double median = medianOf(speeds); median > fastest)
    list.add(Severity::problem, "pose-scale", "The camera is implausibly fast: positions are in other units",
             fmt::format("median {:.3g} m/s over {} steps", median, speeds.size()),
             "divide the positions by 1000 if they are in millimeters, and check that stamps are in seconds");
}

}  // namespace

void checkTimes(const Sequence& sequence, Checklist& list) {
  checkOrder(sequence, list);
  checkDepthTimes(sequence, list);
}

void checkTrajectory(const Sequence& sequence, Checklist& list) {
  const std::size_t before = list.faults();
  checkClock(sequence, list);
  Posed posed;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (const auto& pose = sequence.frame(i).pose) {
      posed.index.push_back(i);
      posed.pose.push_back(*pose);
    }
  constexpr std::size_t minPoses = 3;
  if (posed.pose.empty()) {
    if (sequence.poseSource() && sequence.size() > 0)
      list.add(Severity::problem, "pose-missing", "No pose can be used: all are missing, NaN or no rotation",
               share(sequence.size(), sequence.size(), "frames have none"),
               "give the trajectory that the tracker found, with unit quaternions (t x y z qx qy qz qw)");
    return;
  }
  checkCoverage(sequence, posed, list);
  if (posed.pose.size() < minPoses) return;
  const Steps steps = stepsOf(posed.pose);
  const bool turns =
      !std::ranges::all_of(posed.pose, [&](const Pose& p) { return sameRotation(p, posed.pose[0]); });
  if (steps.meanDistance < 1e-9 && !turns) {
    list.add(Severity::problem, "pose-constant", "All poses are the same",
             share(posed.pose.size(), sequence.size(), "frames"),
             "write one pose a frame, of the moving camera");
  } else if (posed.pose.size() >= 20 && steps.meanLength > 0.8 * steps.meanDistance) {  // not by chance
    list.add(
        Severity::problem, "pose-order",
        "Poses do not follow each other: they are in another order than the frames",
        fmt::format("{:.2g} m from one to the next, {:.2g} m between any two of {}", steps.meanLength,
                    steps.meanDistance, posed.pose.size()),
        "give each pose its frame's time stamp, or sort both in the same way (frame2 comes before frame10)");
  } else {
    checkJumps(sequence, posed, steps, list);
    checkSpeed(sequence, posed, steps, list);
  }
  if (list.faults() == before)
    list.fine("trajectory", "Poses are complete and without jumps",
              fmt::format("{} poses, a path of {:.1f} m", posed.pose.size(),
                          steps.meanLength * static_cast<double>(steps.lengths.size())));
}

}  // namespace estancia::check
