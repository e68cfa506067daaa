// The live loop beside the bare forward pass of its network, and its memory over a long drive.
//   bench_live DRIVE          latency and rate by the default network: images only and with depth, as fast as
//                             frames are taken and as they were recorded
//   bench_live DRIVE FRAMES   drives to and fro until there are FRAMES, by made-up words: resident memory
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <vector>

#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/live/live_loop.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sources/replay_source.hpp"

namespace {

using namespace estancia;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

double quantile(std::vector<double> values, double p) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
}

double residentMegabytes() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

/// A drive, perhaps without its depth, perhaps small, to and fro.
class Driven : public Sequence {
 public:
  Driven(std::unique_ptr<Sequence> drive, bool depth, std::size_t count = 0, cv::Size size = {})
      : drive_(std::move(drive)), depth_(depth), size_(size) {
    if (depth) intrinsics_ = drive_->intrinsics();
    poseSource_ = drive_->poseSource();
    const std::size_t all = drive_->size(), round = 2 * (all - 1);
    for (std::size_t i = 0; i < (count == 0 ? all : count); ++i) {
      const std::size_t at = i % round;
      from_.push_back(at < all ? at : round - at);
      frames_.push_back(drive_->frame(from_.back()));
      if (count == 0) continue;
      frames_.back().name = fmt::format("frame {}", i);
      frames_.back().timestamp = 0.2 * static_cast<double>(i);
    }
  }
  std::string name() const override { return drive_->name(); }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_.at(i); }
  cv::Mat image(std::size_t i) const override { return sized(drive_->image(from_[i]), cv::INTER_AREA); }
  bool hasDepth() const override { return depth_; }
  cv::Mat depth(std::size_t i) const override { return sized(drive_->depth(from_[i]), cv::INTER_NEAREST); }

 private:
  cv::Mat sized(cv::Mat image, int how) const {
    if (size_.width > 0) cv::resize(image, image, size_, 0, 0, how);
    return image;
  }

  std::unique_ptr<Sequence> drive_;
  bool depth_;
  cv::Size size_;
  std::vector<std::size_t> from_;
  std::vector<Frame> frames_;
};

void measure(const char* what, const std::string& drive, Labeler& labeler, bool depth, double rate) {
  const fs::path map = fs::temp_directory_path() / fmt::format("bench_live_{}.estancia", getpid());
  fs::remove(map);
  auto source = std::make_unique<ReplaySource>(std::make_unique<Driven>(openSequence(drive), depth),
                                               ReplayOptions{.rate = rate});
  LiveLoop live(std::move(source), labeler, map);
  std::atomic<std::int64_t> published = 0;
  std::atomic<bool> over = false;
  std::vector<double> heard;  // from the place to another thread that waits for it
  std::thread page([&] {
    for (std::uint64_t revision = 0, frames = 0; !over;) {
      const LiveStatus now = live.waitForChange(revision, std::chrono::milliseconds(50));
      revision = now.revision;
      if (now.frames == frames) continue;
      frames = now.frames;
      heard.push_back(static_cast<double>(Clock::now().time_since_epoch().count() - published) / 1e6 +
                      now.latency);
    }
  });
  Clock::time_point begin;
  double seconds = 0;
  std::vector<double> latencies;
  live.run([&](const LiveStatus& now) {
    published = Clock::now().time_since_epoch().count();
    if (latencies.empty()) begin = Clock::now();
    seconds = millisecondsSince(begin) / 1000;
    latencies.push_back(now.latency);
  });
  over = true;
  page.join();
  const LiveStatus end = live.status();
  fmt::print("{:<28} {:>6} {:>8} {:>8.1f} {:>10.1f} {:>10.1f} {:>8.1f} {:>8.1f} {:>7.1f} {:>6}\n", what,
             end.frames, end.dropped, end.forward, quantile(latencies, 0.5), quantile(latencies, 0.95),
             quantile(latencies, 1), quantile(heard, 0.95),
             static_cast<double>(latencies.size() - 1) / seconds, end.mapRevision);
  std::fflush(stdout);
  fs::remove(map);
}

void measureAll(const std::string& drive) {
  const auto labeler = loadModel();
  const auto sequence = openSequence(drive);
  std::vector<cv::Mat> images;
  for (std::size_t i = 0; i < std::min<std::size_t>(200, sequence->size()); ++i)
    images.push_back(sequence->image(i));
  std::vector<double> passes;
  labeler->label(images.front());
  const auto begin = Clock::now();
  for (const cv::Mat& image : images) {
    const Prepared prepared = labeler->prepare(image);
    const auto pass = Clock::now();
    labeler->infer(prepared);
    passes.push_back(millisecondsSince(pass));
  }
  fmt::print("bare forward pass of {}: median {:.1f} ms, 95 % {:.1f} ms; with its preprocessing {:.1f}/s\n\n",
             labeler->identity(), quantile(passes, 0.5), quantile(passes, 0.95),
             1000 * static_cast<double>(images.size()) / millisecondsSince(begin));
  fmt::print("{:<28} {:>6} {:>8} {:>8} {:>10} {:>10} {:>8} {:>8} {:>7} {:>6}\n", "", "frames", "dropped",
             "pass ms", "place ms", "95 % ms", "worst", "page ms", "per s", "maps");
  measure("images, as fast as taken", drive, *labeler, false, 0);
  measure("depth, as fast as taken", drive, *labeler, true, 0);
  measure("images, as recorded", drive, *labeler, false, 1);
  measure("depth, as recorded", drive, *labeler, true, 1);
}

/// Words that are alike where frames are near in the drive.
class MadeUpWords : public Labeler {
 public:
  MadeUpWords() {
    std::vector<std::string> names;
    for (std::size_t w = 0; w < labels; ++w) names.push_back(fmt::format("word {}", w));
    vocabulary_ = Vocabulary(names);
  }
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return "made up"; }
  bool needsImage() const override { return false; }
  Prepared prepare(const cv::Mat&, const std::string& frame) const override { return {{}, frame, {}}; }
  LexicalDescriptor infer(const Prepared& prepared) override {
    const double i = std::strtod(prepared.frame.c_str() + 6, nullptr);
    LexicalDescriptor words(labels);
    for (std::size_t w = 0; w < labels; ++w)
      words[w] = static_cast<float>(
          std::exp(4 * std::cos(0.02 * i * static_cast<double>(w % 17 + 1) + static_cast<double>(w))) /
          (12 * static_cast<double>(labels)));
    return words;
  }

 private:
  static constexpr std::size_t labels = 200;
  Vocabulary vocabulary_{std::vector<std::string>{"word"}};
};

void soak(const std::string& drive, std::size_t count) {
  const fs::path map = fs::temp_directory_path() / fmt::format("bench_live_{}.estancia", getpid());
  fs::remove(map);
  MadeUpWords words;
  auto source = std::make_unique<ReplaySource>(
      std::make_unique<Driven>(openSequence(drive), true, count, cv::Size(160, 120)),
      ReplayOptions{.rate = 0});
  LiveLoop live(std::move(source), words, map);
  fmt::print("{:>8} {:>10} {:>10} {:>10} {:>8}\n", "frames", "memory MB", "file MB", "frames/s", "maps");
  auto since = Clock::now();
  live.run([&](const LiveStatus& now) {
    if (now.frames * 10 / count == (now.frames - 1) * 10 / count) return;
    const double megabytes = fs::exists(map) ? static_cast<double>(fs::file_size(map)) / (1 << 20) : 0;
    fmt::print("{:>8} {:>10.0f} {:>10.1f} {:>10.1f} {:>8}\n", now.frames, residentMegabytes(), megabytes,
               static_cast<double>(count) / 10 / (millisecondsSince(since) / 1000), now.mapRevision);
    std::fflush(stdout);
    since = Clock::now();
  });
  fs::remove(map);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: bench_live DRIVE [FRAMES]\n");
    return 2;
  }
  try {
    if (argc > 2)
      soak(argv[1], std::strtoul(argv[2], nullptr, 10));
    else
      measureAll(argv[1]);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}
