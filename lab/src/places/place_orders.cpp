// SPDX-License-Identifier: Apache-2.0
#include "places/place_orders.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <variant>

#include "estancia/stats/clustering_agreement.hpp"

namespace estancia::experiments {

std::vector<int> nodesOf(const DescriptorSequence& recording, const std::vector<std::size_t>& tour,
                         const MapperOptions& options) {
  Mapper mapper(recording.vocabulary, options);
  std::vector<int> nodes;
  const auto take = [&] {
    const MapChanges changes = mapper.takeChanges();
    if (changes.restarted) nodes.clear();
    for (const auto& event : changes.events)
      if (const auto* decision = std::get_if<Decision>(&event))
        nodes.push_back(decision->node);
      else
        std::ranges::replace(nodes, std::get<Merge>(event).absorbed, std::get<Merge>(event).kept);
  };
  for (const std::size_t frame : tour) {
    mapper.add(recording.descriptors.row(frame));
    take();
  }
  mapper.finish();
  take();
  return nodes;
}

MappedRooms mapRooms(const DescriptorSequence& recording, const std::vector<std::size_t>& tour,
                     const MapperOptions& options) {
  const std::vector<int> nodes = nodesOf(recording, tour, options);
  std::map<std::string, int> numbers;
  std::vector<int> rooms;
  for (const std::size_t frame : tour)
    rooms.push_back(
        numbers.try_emplace(recording.frames[frame].room, static_cast<int>(numbers.size())).first->second);
  const std::set<int> different(nodes.begin(), nodes.end());
  return {measureAgreement(rooms, nodes).vMeasure, static_cast<double>(different.size())};
}

std::vector<std::vector<std::size_t>> ordersOfStays(const std::vector<Frame>& frames, std::size_t orders) {
  std::vector<std::vector<std::size_t>> stays;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i == 0 || frames[i].room != frames[i - 1].room) stays.emplace_back();
    stays.back().push_back(i);
  }
  std::vector<std::size_t> order(stays.size());
  std::vector<std::vector<std::size_t>> all;
  for (std::size_t seed = 1; seed <= orders; ++seed) {
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    Chance(seed).shuffle(order);
    auto& tour = all.emplace_back();
    for (const std::size_t stay : order) tour.insert(tour.end(), stays[stay].begin(), stays[stay].end());
  }
  return all;
}

}  // namespace estancia::experiments
