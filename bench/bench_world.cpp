// A long drive into a map with all layers: time a frame, resident memory and the size of the file, at each
// tenth.
//   bench_world DRIVE FRAMES MAP [tracked [LENGTH]]
//                           drives the first LENGTH frames (else all) of DRIVE, a sequence with depth, to and
//                           fro until there are FRAMES; by its poses, or by tracking the camera
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "estancia/readers/open_sequence.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/world_mapper.hpp"

namespace {

using namespace estancia;
namespace fs = std::filesystem;

constexpr std::size_t labels = 200;

/// A frame of the drive at 160 × 120, decoded once.
struct Shown {
  Frame frame;
  cv::Mat image, depth;
  LexicalDescriptor words;
};

/// Alike where frames are near in the drive.
LexicalDescriptor wordsAt(std::size_t i) {
  LexicalDescriptor words(labels);
  for (std::size_t w = 0; w < labels; ++w)
    words[w] = static_cast<float>(
        std::exp(4 * std::cos(0.02 * static_cast<double>(i * (w % 17 + 1)) + static_cast<double>(w))) /
        (12 * static_cast<double>(labels)));
  return words;
}

std::vector<Shown> framesOf(const Sequence& drive, std::size_t length) {
  std::vector<Shown> frames;
  for (std::size_t i = 0; i < std::min(length, drive.size()); ++i) {
    Shown shown{drive.frame(i), {}, {}, wordsAt(i)};
    cv::resize(drive.image(i), shown.image, {160, 120}, 0, 0, cv::INTER_AREA);
    cv::resize(drive.depth(i), shown.depth, {160, 120}, 0, 0, cv::INTER_NEAREST);
    frames.push_back(std::move(shown));
  }
  return frames;
}

double megabytes(double bytes) {
  return bytes / (1 << 20);
}

double residentMegabytes() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return megabytes(resident * static_cast<double>(sysconf(_SC_PAGESIZE)));
}

void drive(const std::string& path, std::size_t count, const fs::path& map, bool tracked,
           std::size_t length) {
  const auto sequence = openSequence(path);
  const std::vector<Shown> frames = framesOf(*sequence, length);
  if (frames.size() < 2) throw std::runtime_error("a drive to and fro needs two frames or more");
  const CameraIntrinsics camera = sequence->intrinsics().value();
  std::vector<std::string> names;
  for (std::size_t w = 0; w < labels; ++w) names.push_back(fmt::format("word {}", w));
  auto session = MappingSession::create(map, Vocabulary(names), "bench", {}, ExistingMap::replace);
  WorldMapper world(session, nullptr, tracked ? std::optional(camera) : std::nullopt);
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto seconds = [&](auto since) { return std::chrono::duration<double>(now() - since).count(); };
  fmt::print("{:>8} {:>8} {:>10} {:>10} {:>10} {:>10}\n", "frames", "places", "ms/frame", "worst ms",
             "memory MB", "file MB");
  auto since = now();
  double worst = 0;
  std::size_t reported = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t round = 2 * (frames.size() - 1), at = i % round;
    const Shown& shown = frames[at < frames.size() ? at : round - at];
    Frame frame = shown.frame;
    frame.name = fmt::format("frame {}", i);
    frame.timestamp = 0.2 * static_cast<double>(i);
    if (tracked) frame.pose.reset();
    const auto begin = now();
    frame.pose = world.observe(frame, shown.words, shown.image, shown.depth, camera);
    session.add(frame, shown.words);
    worst = std::max(worst, seconds(begin));
    if ((i + 1) * 10 / count == i * 10 / count) continue;
    const auto written = static_cast<double>(fs::exists(map) ? fs::file_size(map) : 0);
    fmt::print("{:>8} {:>8} {:>10.2f} {:>10.0f} {:>10.0f} {:>10.1f}\n", i + 1, session.mapper().nodes(),
               1000 * seconds(since) / static_cast<double>(i + 1 - reported), 1000 * worst,
               residentMegabytes(), megabytes(written));
    std::fflush(stdout);
    since = now();
    reported = i + 1;
    worst = 0;
  }
  const auto begin = now();
  session.finish();
  world.finish();
  fmt::print("finished in {:.1f} s: memory {:.0f} MB, file {:.1f} MB\n", seconds(begin), residentMegabytes(),
             megabytes(static_cast<double>(fs::file_size(map))));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr, "usage: bench_world DRIVE FRAMES MAP [tracked [LENGTH]]\n");
    return 2;
  }
  try {
    drive(argv[1], std::strtoul(argv[2], nullptr, 10), argv[3], argc > 4 && argv[4] == std::string("tracked"),
          argc > 5 ? std::strtoul(argv[5], nullptr, 10) : 1000000);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}
