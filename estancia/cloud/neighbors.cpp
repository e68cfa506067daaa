// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/neighbors.hpp"

#include <array>

#include "estancia/core/cores.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {

/// A point while the tree is built.
struct Neighbors::Item {
  std::array<float, 3> at;
  std::uint32_t index;
};

namespace {

constexpr std::size_t blockSize = Neighbors::blockSize;

/// Appends the points of a block that are near enough; `found` has room for all of them. Returns their
/// number.
ESTANCIA_MULTIVERSION std::size_t scan(const Neighbors::Block& block, float x, float y, float z,
                                       float squared, Neighbor* found) {
  float distances[blockSize];
  for (std::size_t i = 0; i < blockSize; ++i) {
    const float dx = block.x[i] - x, dy = block.y[i] - y, dz = block.z[i] - z;
    distances[i] = dx * dx + dy * dy + dz * dz;
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < blockSize; ++i) {  // branchless: the outcome is unpredictable
    found[count] = {block.index[i], distances[i]};
    count += distances[i] <= squared ? 1 : 0;
  }
  return count;
}

/// Room for `count` more behind the first `used`.
Neighbor* room(std::vector<Neighbor>& buffer, std::size_t used, std::size_t count) {
  if (buffer.size() < used + count) buffer.resize(2 * used + count + 8 * blockSize);
  return buffer.data() + used;
}

bool nearer(const Neighbor& a, const Neighbor& b) {
  return a.squared < b.squared || (a.squared == b.squared && a.index < b.index);
}

}  // namespace

Neighbors::Neighbors(std::span<const cv::Point3f> points, int threads) {
  constexpr std::size_t limit = std::numeric_limits<std::uint32_t>::max();
  if (points.size() >= limit)
    fail(ErrorCode::tooLarge, "a cloud of {} points is too large for a search tree; thin it out",
         points.size());
  std::vector<Item> items;
  items.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    if (isFinite(points[i]))
      items.push_back({{points[i].x, points[i].y, points[i].z}, static_cast<std::uint32_t>(i)});
  if (items.empty()) return;
  blocks_.resize((items.size() + blockSize - 1) / blockSize);
  nodes_.resize(2 * blocks_.size() - 1);
  build(items, 0, 0, static_cast<std::size_t>(threads > 0 ? threads : usableCores()));
  order_.reserve(items.size());
  for (const Item& item : items) order_.push_back(item.index);
}

void Neighbors::build(std::span<Item> items, std::size_t node, std::size_t block, std::size_t threads) {
  const std::size_t blocks = (items.size() + blockSize - 1) / blockSize;
  std::array<float, 3> low = items[0].at, high = items[0].at;
  for (const Item& item : items)
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], item.at[a]);
      high[a] = std::max(high[a], item.at[a]);
    }
  nodes_[node] = {{low[0], low[1], low[2]},
                  {high[0], high[1], high[2]},
                  static_cast<std::uint32_t>(node + 2 * blocks - 1),
                  static_cast<std::uint32_t>(block),
                  static_cast<std::uint32_t>(block + blocks)};
  if (blocks == 1) {
    Block& leaf = blocks_[block];
    for (std::size_t i = 0; i < blockSize; ++i) {
      const bool exists = i < items.size();
      leaf.x[i] = exists ? items[i].at[0] : std::numeric_limits<float>::quiet_NaN();
      leaf.y[i] = exists ? items[i].at[1] : 0;
      leaf.z[i] = exists ? items[i].at[2] : 0;
      leaf.index[i] = exists ? items[i].index : 0;
    }
    return;
  }
  std::size_t widest = 0;
  for (std::size_t a = 1; a < 3; ++a)
    if (high[a] - low[a] > high[widest] - low[widest]) widest = a;
  const std::size_t leftBlocks = (blocks + 1) / 2,
                    middle = leftBlocks * blockSize;  // full blocks on the left
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(middle), items.end(),
                   [widest](const Item& a, const Item& b) { return a.at[widest] < b.at[widest]; });
  inParallel(2, std::min<std::size_t>(threads, 2), [&](std::size_t side) {
    if (side == 0)
      build(items.first(middle), node + 1, block, (threads + 1) / 2);
    else
      build(items.subspan(middle), node + 2 * leftBlocks, block + leftBlocks, threads / 2);
  });
}

std::span<const Neighbor> Neighbors::within(const cv::Point3f& place, float radius,
                                            std::vector<Neighbor>& buffer) const {
  if (!isFinite(place) || !(radius >= 0)) return {};
  const float squared = radius * radius;
  std::size_t count = 0;
  eachBlock(place, squared, [&](std::uint32_t block) {
    count += scan(blocks_[block], place.x, place.y, place.z, squared, room(buffer, count, blockSize));
  });
  return {buffer.data(), count};
}

std::span<const Neighbor> Neighbors::nearest(const cv::Point3f& place, std::size_t count,
                                             std::vector<Neighbor>& buffer, float maxDistance) const {
  count = std::min(count, size());
  if (!isFinite(place) || count == 0 || !(maxDistance >= 0)) return {};
  struct Visit {
    std::uint32_t node;
    float squared;
  };
  std::array<Visit, 64> visits;  // one a level of a tree of fewer than 2³² points
  std::size_t waiting = 0, found = 0;
  float worst = maxDistance * maxDistance;
  Neighbor* best = room(buffer, count, blockSize) - count;  // the found ones, then those of a block
  visits[waiting++] = {0, squaredTo(nodes_[0], place)};
  while (waiting > 0) {
    const Visit visit = visits[--waiting];
    if (visit.squared > worst || (found == count && visit.squared >= worst)) continue;
    const Node& node = nodes_[visit.node];
    if (node.last == node.first + 1) {
      Neighbor* near = best + count;
      const std::size_t some = scan(blocks_[node.first], place.x, place.y, place.z, worst, near);
      for (std::size_t i = 0; i < some; ++i) {
        if (found == count) {
          if (!nearer(near[i], best[0])) continue;
          std::pop_heap(best, best + found, nearer);
          best[found - 1] = near[i];
        } else {
          best[found++] = near[i];
        }
        std::push_heap(best, best + found, nearer);
      }
      if (found == count) worst = best[0].squared;
      continue;
    }
    const std::uint32_t left = visit.node + 1, right = nodes_[left].skip;
    Visit near{left, squaredTo(nodes_[left], place)}, far{right, squaredTo(nodes_[right], place)};
    if (far.squared < near.squared) std::swap(near, far);
    visits[waiting++] = far;
    visits[waiting++] = near;
  }
  std::sort_heap(best, best + found, nearer);
  return {best, found};
}

}  // namespace estancia
