// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/frame_sample.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace estancia {
namespace {

/// A number in (0, 1) that looks random: the finalizer of SplitMix64 (Steele, Lea & Flood 2014).
double scrambled(std::uint64_t number) {
  number += 0x9e3779b97f4a7c15;
  number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9;
  number = (number ^ (number >> 27)) * 0x94d049bb133111eb;
  number ^= number >> 31;
  return (static_cast<double>(number >> 11) + 0.5) * 0x1p-53;
}

/// The entries of each place, smallest keys first.
std::map<int, std::vector<FrameSample::Entry>> byPlace(const std::vector<FrameSample::Entry>& entries) {
  std::map<int, std::vector<FrameSample::Entry>> places;
  for (const FrameSample::Entry& entry : entries) places[entry.node].push_back(entry);
  for (auto& [node, own] : places) std::ranges::sort(own, {}, &FrameSample::Entry::key);
  return places;
}

/// The bytes of the first `most` entries of each place, and of all needed ones.
std::uint64_t bytesOf(const std::map<int, std::vector<FrameSample::Entry>>& places, std::size_t most) {
  std::uint64_t bytes = 0;
  for (const auto& [node, entries] : places)
    for (std::size_t i = 0; i < entries.size(); ++i)
      if (i < most || entries[i].isNeeded) bytes += entries[i].bytes;
  return bytes;
}

}  // namespace

double FrameSample::keyOf(std::size_t frame, double information) {
  return -std::log(scrambled(frame)) / information;
}

bool FrameSample::takes(int node, double key) const {
  const auto bound = bounds_.find(node);
  return bound == bounds_.end() || key < bound->second;
}

std::uint64_t FrameSample::minBytes(const std::vector<Entry>& entries) {
  return bytesOf(byPlace(entries), 1);
}

std::optional<std::vector<std::size_t>> FrameSample::thin(const std::vector<Entry>& entries,
                                                          std::uint64_t bytes) {
  const std::map<int, std::vector<Entry>> places = byPlace(entries);
  std::size_t most = 0;
  for (const auto& [node, own] : places) most = std::max(most, own.size());
  if (bytesOf(places, 1) > bytes) return std::nullopt;
  std::size_t fits = 1;  // most frames of a place that fit: bytesOf() grows with it
  for (std::size_t end = most + 1; end - fits > 1;) {
    const std::size_t middle = std::midpoint(fits, end);
    (bytesOf(places, middle) <= bytes ? fits : end) = middle;
  }
  std::vector<std::size_t> gone;
  for (const auto& [node, own] : places) {
    if (own.size() <= fits) continue;
    for (std::size_t i = fits; i < own.size(); ++i)
      if (!own[i].isNeeded) gone.push_back(own[i].frame);
    const auto known = bounds_.find(node);
    bounds_[node] = known == bounds_.end() ? own[fits].key : std::min(known->second, own[fits].key);
  }
  std::ranges::sort(gone);
  return gone;
}

void FrameSample::merge(int absorbed) {
  bounds_.erase(absorbed);
}

std::string FrameSample::state() const {
  ByteWriter out;
  out.number<std::uint64_t>(bounds_.size());
  for (const auto& [node, bound] : bounds_) {
    out.number<std::int32_t>(node);
    out.number(bound);
  }
  return out.bytes();
}

void FrameSample::restore(ByteReader& in) {
  bounds_.clear();
  for (std::size_t count = in.count(sizeof(std::int32_t) + sizeof(double)); count > 0; --count) {
    const auto node = in.number<std::int32_t>();
    bounds_[node] = in.number<double>();
  }
}

}  // namespace estancia
