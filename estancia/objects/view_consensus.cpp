// View consensus: which segments of different frames show one thing (InstanceMap::clusterMasks()).
// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <map>
#include <unordered_map>

#include "estancia/objects/instance_map.hpp"
#include "estancia/segmentation/segments.hpp"

namespace estancia {
namespace {

using SeenMask = InstanceMap::Mask;
using Voxels = InstanceMap::Voxels;

/// Min share of a mask that is visible in another frame for the frame to count as seeing it.
constexpr double visibleShare = 0.3;
constexpr std::uint32_t visibleVoxels = 4;
/// Min share of a mask's visible part that lies in one mask of a frame for that mask to contain it.
constexpr double heldShare = 0.8;
/// Share of the frames seeing a mask above which the mask is split.
constexpr double splitShare = 0.3;
/// Min share of the views of a mask's place that are masks for an object to be there.
constexpr double objectShare = 0.5;

/// A set of frames.
class FrameSet {
 public:
  void insert(std::size_t frame) {
    if (frame / 64 >= bits_.size()) bits_.resize(frame / 64 + 1);
    bits_[frame / 64] |= std::uint64_t{1} << frame % 64;
  }
  void merge(const FrameSet& other) {
    bits_.resize(std::max(bits_.size(), other.bits_.size()));
    for (std::size_t i = 0; i < other.bits_.size(); ++i) bits_[i] |= other.bits_[i];
  }
  std::size_t inCommon(const FrameSet& other) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < std::min(bits_.size(), other.bits_.size()); ++i)
      count += static_cast<std::size_t>(std::popcount(bits_[i] & other.bits_[i]));
    return count;
  }

 private:
  std::vector<std::uint64_t> bits_;
};

/// Masks that show one thing.
struct Group {
  std::vector<std::uint32_t> masks;
  /// Masks that hold one of them, ascending.
  std::vector<std::uint32_t> holders;
  FrameSet seenBy;
};

bool isObject(const SeenMask& mask, const Voxels& voxels) {
  double seen = 0, masked = 0;
  for (const SeenMask::Part& part : mask.parts) {
    const InstanceMap::Voxel& voxel = voxels.at(part.at);
    seen += voxel.seen;
    masked += voxel.masked;
  }
  return masked >= objectShare * seen;
}

/// Compares a mask with the other frames. Returns whether it is of use.
bool observe(std::uint32_t number, const Voxels& voxels, const std::vector<SeenMask>& masks,
             const std::vector<std::size_t>& frameOf, Group& group) {
  const SeenMask& mask = masks[number];
  if (!isObject(mask, voxels)) return false;
  std::unordered_map<std::uint32_t, std::uint32_t> shared;  // voxels by mask
  for (const SeenMask::Part& part : mask.parts)
    for (const std::uint32_t other : voxels.at(part.at).masks) ++shared[other];
  struct View {
    std::uint32_t voxels = 0, most = 0, holder = 0;
  };
  std::map<std::size_t, View> views;
  for (const auto& [other, count] : shared) {
    View& view = views[frameOf[other]];
    view.voxels += count;
    if (count > view.most || (count == view.most && other < view.holder)) {
      view.most = count;
      view.holder = other;
    }
  }
  std::size_t seen = 0, split = 0;
  for (const auto& [frame, view] : views) {
    if (view.voxels < visibleVoxels || view.voxels < visibleShare * static_cast<double>(mask.parts.size()))
      continue;
    ++seen;
    group.seenBy.insert(frame);
    if (view.most >= heldShare * view.voxels)
      group.holders.push_back(view.holder);
    else
      ++split;
  }
  std::ranges::sort(group.holders);
  group.masks = {number};
  return static_cast<double>(split) <= splitShare * static_cast<double>(seen);
}

/// Frames that hold both in one mask. Masks are numbered frame by frame.
std::size_t agreeing(const Group& a, const Group& b, const std::vector<std::size_t>& frameOf) {
  std::size_t frames = 0, last = frameOf.size();
  for (auto i = a.holders.begin(), j = b.holders.begin(); i != a.holders.end() && j != b.holders.end();) {
    if (*i < *j) {
      ++i;
    } else if (*j < *i) {
      ++j;
    } else {
      if (frameOf[*i] != last) ++frames;
      last = frameOf[*i];
      ++i, ++j;
    }
  }
  return frames;
}

/// Two groups that most frames which see both have in one mask.
struct Pair {
  std::uint32_t a, b;
  std::size_t seen;
};

/// Pairs of masks that any mask contains.
std::vector<Pair> agreedPairs(const std::vector<Group>& groups, const std::vector<std::size_t>& frameOf,
                              double consensus) {
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> heldBy;
  for (std::uint32_t g = 0; g < groups.size(); ++g)
    for (const std::uint32_t holder : groups[g].holders) heldBy[holder].push_back(g);
  std::vector<Pair> pairs;
  // One group after the other: the cost is quadratic in the views of one object.
  std::vector<std::uint32_t> others, foundFor(groups.size(), 0);
  for (std::uint32_t a = 0; a < groups.size(); ++a) {
    others.clear();
    for (const std::uint32_t holder : groups[a].holders) {
      const std::vector<std::uint32_t>& together = heldBy[holder];
      for (auto b = std::ranges::upper_bound(together, a); b != together.end(); ++b)
        if (std::exchange(foundFor[*b], a + 1) != a + 1) others.push_back(*b);
    }
    std::ranges::sort(others);
    for (const std::uint32_t b : others) {
      const std::size_t seen = groups[a].seenBy.inCommon(groups[b].seenBy);
      if (static_cast<double>(agreeing(groups[a], groups[b], frameOf)) >=
          consensus * static_cast<double>(seen))
        pairs.push_back({a, b, seen});
    }
  }
  return pairs;
}

std::vector<Group> merged(const std::vector<Group>& groups, DisjointSets& sets) {
  std::map<std::uint32_t, Group> bySet;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    Group& into = bySet[sets.find(static_cast<std::uint32_t>(g))];
    into.masks.insert(into.masks.end(), groups[g].masks.begin(), groups[g].masks.end());
    into.holders.insert(into.holders.end(), groups[g].holders.begin(), groups[g].holders.end());
    into.seenBy.merge(groups[g].seenBy);
  }
  std::vector<Group> result;
  for (auto& [set, group] : bySet) {
    std::ranges::sort(group.masks);
    std::ranges::sort(group.holders);
    group.holders.erase(std::unique(group.holders.begin(), group.holders.end()), group.holders.end());
    result.push_back(std::move(group));
  }
  return result;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> InstanceMap::clusterMasks() const {
  std::vector<std::size_t> frameOf;  // by the order of frames, without gaps
  std::map<std::size_t, std::size_t> order;
  for (const Mask& mask : masks_) frameOf.push_back(order.emplace(mask.frame, order.size()).first->second);
  std::vector<Group> groups;
  for (std::uint32_t m = 0; m < masks_.size(); ++m)
    if (Group group; observe(m, voxels_, masks_, frameOf, group)) groups.push_back(std::move(group));
  std::vector<Pair> pairs = agreedPairs(groups, frameOf, options_.consensus);
  for (std::size_t observers = order.size(); observers > 0; observers = observers * 4 / 5) {
    DisjointSets sets(groups.size());
    bool any = false;
    for (const Pair& pair : pairs)
      if (pair.seen >= observers) {
        sets.join(pair.a, pair.b);
        any = true;
      }
    if (!any) continue;
    groups = merged(groups, sets);
    pairs = agreedPairs(groups, frameOf, options_.consensus);
  }
  std::vector<std::vector<std::uint32_t>> clusters;
  for (Group& group : groups) clusters.push_back(std::move(group.masks));
  std::ranges::sort(clusters);
  return clusters;
}

}  // namespace estancia
