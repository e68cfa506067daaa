// Checks images, depth and camera frame by frame.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "estancia/check/checklist.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/odometry/pyramid.hpp"

namespace estancia::check {
namespace {

using odometry::sameShape;

constexpr double black = 8, white = 247;  // mean gray values of useless images

/// Counts frames and remembers the first.
struct Tally {
  std::size_t count = 0;
  std::string first;
  void add(const std::string& name) {
    if (count++ == 0) first = name;
  }
};

struct ImageTally {
  std::size_t looked = 0, pairs = 0;
  Tally unreadable, dark, bright, frozen;
};

/// Depth of all checked frames.
struct DepthTally {
  std::size_t looked = 0;
  Tally missing, empty, shape;
  std::string firstError;
  std::vector<double> medians, validShares;
  std::vector<float> values;  ///< some pixels of every frame
};

std::string text(cv::Size size) {
  return fmt::format("{} × {}", size.width, size.height);
}

/// Whether frame i has the same pixels as the next: cameras have noise, stuck drivers do not.
bool isFrozen(const Sequence& sequence, std::size_t i, const cv::Mat& image) {
  const std::string fingerprint = sequence.fingerprint(i);
  if (!fingerprint.empty()) return fingerprint == sequence.fingerprint(i + 1);
  const cv::Mat next = sequence.image(i + 1);
  return next.size() == image.size() && cv::norm(image, next, cv::NORM_INF) == 0;
}

/// The image's size, empty when it cannot be read.
cv::Size checkImage(const Sequence& sequence, std::size_t i, ImageTally& tally) {
  ++tally.looked;
  const std::string& name = sequence.frame(i).name;
  cv::Mat image;
  try {
    image = sequence.image(i);
  } catch (...) {
    frameFailure(name);
    tally.unreadable.add(name);
    return {};
  }
  const cv::Scalar mean = cv::mean(image);
  const double gray = (mean[0] + mean[1] + mean[2]) / 3;
  if (gray < black) tally.dark.add(name);
  if (gray > white) tally.bright.add(name);
  if (i + 1 < sequence.size()) try {
      ++tally.pairs;
      if (isFrozen(sequence, i, image)) tally.frozen.add(name);
    } catch (...) {
      frameFailure(name);  // the next one is unreadable: counted when it is checked
    }
  return image.size();
}

/// Whether the nearest depth has another time than the image, which checkTimes() reports.
bool isOutOfTime(const Sequence& sequence, std::size_t i) {
  const auto time = sequence.frame(i).timestamp, depthTime = sequence.depthTimestamp(i);
  return time && depthTime && std::abs(*depthTime - *time) > synchronous;
}

/// Samples about `pixels` of the frame's pixels.
cv::Size checkDepth(const Sequence& sequence, std::size_t i, cv::Size image, std::size_t pixels,
                    DepthTally& tally) {
  ++tally.looked;
  const std::string& name = sequence.frame(i).name;
  cv::Mat depth;
  try {
    depth = sequence.depth(i);
  } catch (...) {
    const Error failure = frameFailure(name);
    if (isOutOfTime(sequence, i)) return {};
    tally.missing.add(name);
    if (tally.firstError.empty()) tally.firstError = failure.what();
    return {};
  }
  std::vector<double> valid;
  const auto step =
      std::max<std::size_t>(1, depth.total() / pixels) | 1;  // odd, so that all columns are sampled
  std::size_t seen = 0;
  for (std::size_t p = 0; p < depth.total(); p += step, ++seen) {
    const float d = depth.at<float>(static_cast<int>(p) / depth.cols, static_cast<int>(p) % depth.cols);
    if (d > 0) valid.push_back(d);
  }
  tally.validShares.push_back(static_cast<double>(valid.size()) / static_cast<double>(seen));
  if (valid.empty())
    tally.empty.add(name);
  else
    tally.medians.push_back(medianOf(valid));
  tally.values.insert(tally.values.end(), valid.begin(), valid.end());
  if (!image.empty() && !sameShape(image, depth.size()))
    tally.shape.add(fmt::format("{}: depth {}, image {}", name, text(depth.size()), text(image)));
  return depth.size();
}

std::string seen(const Tally& tally, std::size_t of, const char* what) {
  return fmt::format("{} looked at, first {}", share(tally.count, of, what), tally.first);
}

void judgeImages(const ImageTally& tally, Checklist& list) {
  const std::size_t before = list.faults();
  const auto complain = [&](const Tally& t, std::size_t of, const char* name, const char* what,
                            const char* fix) {
    if (t.count > 0) list.add(severityOfMissing(t.count, of), name, what, seen(t, of, "images"), fix);
  };
  complain(tally.unreadable, tally.looked, "image-unreadable", "Images cannot be read",
           "copy them again, or leave them out");
  complain(tally.dark, tally.looked, "image-black", "Images are black",
           "check the exposure and the lens cap, and cut these frames");
  complain(tally.bright, tally.looked, "image-white", "Images are overexposed",
           "let the camera expose by itself, and cut these frames");
  complain(tally.frozen, tally.pairs, "image-frozen", "Images are the same as the next, to the pixel",
           "the camera or its driver hung: record again, or leave out the repeated frames");
  if (list.faults() == before)
    list.fine("images", "Images can be read and show something", fmt::format("{} looked at", tally.looked));
}

/// The step of depth with 8 bits, which has few different values [m]. Nothing when depth is finer.
std::optional<double> coarseStep(std::vector<float> values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  constexpr std::size_t minValues = 16, maxValues = 256;
  if (values.size() < minValues || values.size() > maxValues) return std::nullopt;
  double step = values.back();
  for (std::size_t i = 1; i < values.size(); ++i)
    step = std::min(step, static_cast<double>(values[i]) - values[i - 1]);
  const double middle = values[values.size() / 2];
  return step > 0.005 * middle ? std::optional(step) : std::nullopt;
}

void judgeRange(const DepthTally& tally, double median, Checklist& list) {
  constexpr double nearest = 0.1, farthest = 60, usual = 2;  // [m]; 60: beyond the range of depth cameras
  if (median >= nearest && median <= farthest) return;
  double best = 1;
  for (const double factor : {1000.0, 5000.0, 5.0, 0.2, 1 / 5000.0, 0.001, 0.01, 100.0})
    if (std::abs(std::log(median * factor / usual)) < std::abs(std::log(median * best / usual)))
      best = factor;
  const bool small = best > 1;
  list.add(
      Severity::problem, "depth-scale",
      fmt::format("Depth is implausibly {}, it is in other units", small ? "near" : "far"),
      fmt::format("median {:.4g} m in {} frames; {:.2g} m if {} {:g}", median, tally.medians.size(),
                  median * best, small ? "multiplied by" : "divided by", small ? best : 1 / best),
      fmt::format("give a --depth-scale {:g} times as {} (the default is 1000 for 16 bits, TUM RGB-D 5000, "
                  "float 1)",
                  small ? best : 1 / best, small ? "small" : "large"));
}

void judgeDepth(const DepthTally& tally, Checklist& list) {
  const std::size_t before = list.faults();
  if (tally.missing.count > 0)
    list.add(
        severityOfMissing(tally.missing.count, tally.looked), "depth-missing",
        "Depth is missing or cannot be read",
        fmt::format("{} looked at: {}", share(tally.missing.count, tally.looked, "frames"), tally.firstError),
        "give every image a depth file that can be read, or leave these frames out");
  if (tally.empty.count > 0)
    list.add(severityOfMissing(tally.empty.count, tally.looked), "depth-empty", "Depth holds no valid pixel",
             seen(tally.empty, tally.looked, "frames"),
             "check the depth stream and its range: 0, 65535 and NaN mean none");
  if (tally.shape.count > 0)
    list.add(Severity::problem, "depth-size",
             "Depth and image have different shapes: they show different views",
             seen(tally.shape, tally.looked, "frames"),
             "export depth registered to color (ROS: aligned_depth_to_color)");
  if (tally.medians.empty()) return;
  const double median = medianOf(tally.medians), valid = medianOf(tally.validShares);
  judgeRange(tally, median, list);
  if (valid < 0.2 && tally.empty.count * 2 < tally.looked)
    list.add(Severity::warning, "depth-sparse", "Depth is sparse",
             fmt::format("{:.0f} % of the pixels have depth, median of {} frames", 100 * valid, tally.looked),
             "keep nearer to what you look at, away from glass and sunlight, or fill in the holes");
  if (const auto step = coarseStep(tally.values))
    list.add(Severity::warning, "depth-coarse", "Depth is coarse, as 8 bits are",
             fmt::format("steps of {:.1f} cm in {} frames", 100 * *step, tally.medians.size()),
             "export depth with 16 bits, in millimeters");
  const float farthest = *std::ranges::max_element(tally.values);
  const auto saturated = static_cast<double>(std::ranges::count(tally.values, farthest)) /
                         static_cast<double>(tally.values.size());
  if (saturated > 0.1 && saturated < 0.9)
    list.add(Severity::warning, "depth-saturated", "Depth is cut off at its furthest value",
             fmt::format("{:.0f} % of the pixels are at {:.3g} m", 100 * saturated, farthest),
             "write 0 instead of the furthest value where nothing was measured");
  if (list.faults() == before)
    list.fine("depth", "Depth is there and plausible",
              fmt::format("median {:.1f} m, {:.0f} % of the pixels, in {} looked at", median, 100 * valid,
                          share(tally.validShares.size(), tally.looked, "frames")));
}

}  // namespace

DepthFacts checkImages(const Sequence& sequence, const CheckOptions& options, Progress& progress,
                       Checklist& list) {
  ImageTally images;
  DepthTally depths;
  DepthFacts facts;
  const auto indices = evenly(sequence.size(), options.maxFrames);
  const std::size_t pixels = 100 + 300000 / indices.size();  // depth of all frames: 300,000
  progress.begin("looking at frames", indices.size());
  for (const std::size_t i : indices) {
    const cv::Size image = checkImage(sequence, i, images);
    if (facts.image.empty()) facts.image = image;
    if (sequence.hasDepth()) {
      const cv::Size depth = checkDepth(sequence, i, image, pixels, depths);
      if (facts.depth.empty()) facts.depth = depth;
    }
    progress.advance();
    if (interrupted()) throw Interrupted("interrupted before the check was complete");
  }
  progress.end();
  judgeImages(images, list);
  if (!sequence.hasDepth()) return facts;
  judgeDepth(depths, list);
  if (!depths.medians.empty()) facts.median = medianOf(depths.medians);
  return facts;
}

void checkCamera(const Sequence& sequence, const DepthFacts& facts, Checklist& list) {
  const auto& camera = sequence.intrinsics();
  if (!camera) {
    if (sequence.hasDepth())
      list.add(Severity::warning, "camera-missing",
               "The camera's intrinsics are missing: depth makes no points, poses cannot be tested",
               fmt::format("{} frames with depth", sequence.size()),
               "give --intrinsics FILE with fx fy cx cy, or put it into the folder as intrinsics.txt");
    return;
  }
  const std::size_t before = list.faults();
  const double view = 2 * std::atan(camera->width / (2 * camera->fx)) * 180 / CV_PI;
  const double x = (camera->cx + 0.5) / camera->width, y = (camera->cy + 0.5) / camera->height;
  const std::string given = fmt::format("fx {:g}, fy {:g}, cx {:g}, cy {:g} for {} × {}", camera->fx,
                                        camera->fy, camera->cx, camera->cy, camera->width, camera->height);
  const char* const fix = "give --intrinsics the calibration of these images, at their size";
  if (!facts.image.empty() && !sameShape(facts.image, {camera->width, camera->height}))
    list.add(Severity::problem, "camera-size", "The intrinsics are for images of another shape",
             fmt::format("{}; images are {}", given, text(facts.image)), fix);
  else if (!(x > 0.3 && x < 0.7 && y > 0.3 && y < 0.7))
    list.add(Severity::problem, "camera-center", "The camera's principal point is far from the middle",
             fmt::format("{}: at {:.0f} % and {:.0f} %; it fits images of about {:.0f} × {:.0f}", given,
                         100 * x, 100 * y, 2 * camera->cx, 2 * camera->cy),
             fix);
  if (!(view > 20 && view < 150))
    list.add(Severity::problem, "camera-view", "The camera's field of view is implausible",
             fmt::format("{:.0f}° wide ({})", view, given), fix);
  if (const double ratio = camera->fx / camera->fy; !(ratio > 0.9 && ratio < 1.1))
    list.add(Severity::warning, "camera-pixels", "The camera's pixels are not square",
             fmt::format("fx / fy = {:.2f} ({})", ratio, given), fix);
  if (list.faults() == before)
    list.fine("camera", "The camera's intrinsics are plausible",
              fmt::format("{:.0f}° wide: {}", view, given));
}

}  // namespace estancia::check
