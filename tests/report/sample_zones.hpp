// Zones to draw in tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <string>

#include "estancia/core/progress.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia::test {

struct SampleZonesOptions {
  std::size_t zones = 5, imagesPerZone = 8, labels = 30;
  bool poses = true, rooms = true, dendrogram = true;
  std::string marker = {};  ///< put into every text
};

/// A robot that drives a ring of zones twice; zone z is the only one to show label z, the first ones have an
/// image more than the last.
inline Zones sampleZones(const SampleZonesOptions& options = {}) {
  std::vector<std::string> labels;
  for (std::size_t l = 0; l < options.labels; ++l)
    labels.push_back(fmt::format("word{}{}", l, options.marker));
  DescriptorSequence recording{
      Vocabulary(labels), "model" + options.marker, {}, DescriptorMatrix(labels.size())};
  std::vector<int> groups;
  for (int round = 0; round < 2; ++round)
    for (std::size_t z = 0; z < options.zones; ++z) {
      const std::size_t more = round == 0 && 2 * z < options.zones ? 1 : 0;
      for (std::size_t i = 0; i < options.imagesPerZone / 2 + more; ++i) {
        Frame frame;
        const std::size_t number = recording.frames.size();
        frame.name = fmt::format("frame{:05}{}.jpg", number, options.marker);
        const double angle = 6.28 * (static_cast<double>(z) + 0.1 * static_cast<double>(i)) /
                             static_cast<double>(options.zones);
        if (options.poses) frame.pose = Pose::planar(5 * std::cos(angle), 3 * std::sin(angle), angle);
        if (options.rooms) frame.room = fmt::format("room {}{}", z % 7, options.marker);
        recording.frames.push_back(frame);
        LexicalDescriptor words(options.labels, 0.001F);
        words[z % options.labels] = 0.8F - 0.001F * static_cast<float>(number % 97);
        recording.descriptors.append(words);
        groups.push_back(static_cast<int>(z));
      }
    }
  if (!options.dendrogram) {
    Zones zones = describeZones(recording, groups);
    zones.distance = "ks" + options.marker;
    zones.linkage = "average" + options.marker;
    zones.cut = 0.5;
    zones.cutReason = "the test says so" + options.marker;
    return zones;
  }
  Progress silent;
  return findZones(recording, ZoneOptions::thesis(), silent);
}

}  // namespace estancia::test
