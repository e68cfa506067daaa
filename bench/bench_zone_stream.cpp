// Zones kept while a robot drives: time an image, and how far they are from all images at once.
//   bench_zone_stream [FRAMES [LABELS [GROUPS]]]   a made-up drive; default: 10,000 × 1,001, 512 groups
//   bench_zone_stream RECORDING [GROUPS]           the frames of a recording (.labels, .npy, .csv)
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <random>
#include <string>
#include <vector>

#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/zones/zone_stream.hpp"

namespace {

using namespace estancia;
using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// A robot that stays about fifty images in each of a hundred places, each of one of twelve kinds, and comes
/// back to them.
DescriptorSequence madeUp(std::size_t frames, std::size_t labels) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < labels; ++i) words.push_back(fmt::format("word {}", i));
  DescriptorSequence recording{Vocabulary(words), "made up", {}, DescriptorMatrix(labels)};
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  const auto vary = [&](const std::vector<float>& logits, float by) {
    std::vector<float> varied = logits;
    for (float& l : varied) l += by * normal(random);
    return varied;
  };
  std::vector<std::vector<float>> kinds, places;
  for (std::size_t k = 0; k < 12; ++k) kinds.push_back(vary(std::vector<float>(labels), 1.5F));
  for (std::size_t p = 0; p < 100; ++p) places.push_back(vary(kinds[p % kinds.size()], 0.7F));
  for (std::size_t i = 0; i < frames; ++i) {
    std::vector<float> p = vary(places[i / 50 % places.size()], 1.0F);
    float sum = 0;
    for (float& v : p) sum += v = std::exp(v);
    for (float& v : p) v /= sum;
    Frame frame;
    frame.name = fmt::format("{}", i);
    frame.room = fmt::format("kind {}", i / 50 % places.size() % kinds.size());
    recording.frames.push_back(frame);
    recording.descriptors.append(p);
  }
  return recording;
}

void measure(const DescriptorSequence& recording, const ZoneStreamOptions& options) {
  const std::size_t frames = recording.frames.size();
  ZoneStream stream(recording.vocabulary, {}, options);
  std::vector<double> times;
  for (std::size_t i = 0; i < frames; ++i) {
    const auto start = Clock::now();
    stream.add(recording.descriptors.row(i));
    times.push_back(millisecondsSince(start));
  }
  double sum = 0, late = 0;
  const std::size_t last = std::max<std::size_t>(frames / 10, 1);
  for (std::size_t i = 0; i < frames; ++i) (i + last < frames ? sum : late) += times[i];
  std::sort(times.begin(), times.end());
  fmt::print(
      "{} images × {} labels, {} groups: {:.3f} ms an image, {:.3f} ms for the last tenth, 99 % within "
      "{:.2f} ms, worst {:.1f} ms\n",
      frames, recording.vocabulary.size(), options.groups, (sum + late) / static_cast<double>(frames),
      late / static_cast<double>(last), times[frames * 99 / 100], times.back());
  stream.update();
  const std::vector<int> streamed = stream.zoneOf();
  auto start = Clock::now();
  const Zones exact = findZones(recording);
  const Agreement agreement = measureAgreement(exact.zoneOf, streamed);
  fmt::print("{} zones; all at once ({:.1f} s) {}: ARI {:.3f}, V-measure {:.3f} between the two\n",
             stream.zones().size(), millisecondsSince(start) / 1000, exact.zones.size(),
             agreement.adjustedRandIndex, agreement.vMeasure);
  std::vector<int> rooms, a, b;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < frames; ++i) {
    const std::string& room = recording.frames[i].room;
    if (room.empty()) continue;
    const auto found = std::find(names.begin(), names.end(), room);
    rooms.push_back(static_cast<int>(found - names.begin()));
    if (found == names.end()) names.push_back(room);
    a.push_back(streamed[i]);
    b.push_back(exact.zoneOf[i]);
  }
  if (!rooms.empty())
    fmt::print("V-measure against rooms: {:.3f}; all at once {:.3f}\n", measureAgreement(rooms, a).vMeasure,
               measureAgreement(rooms, b).vMeasure);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    ZoneStreamOptions options;
    if (argc > 1 && isDescriptorFile(argv[1])) {
      if (argc > 2) options.groups = std::stoul(argv[2]);
      measure(readDescriptors(argv[1]), options);
    } else {
      if (argc > 3) options.groups = std::stoul(argv[3]);
      measure(madeUp(argc > 1 ? std::stoul(argv[1]) : 10000, argc > 2 ? std::stoul(argv[2]) : 1001), options);
    }
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 2;
  }
}
