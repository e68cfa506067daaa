// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/standing.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace estancia {
namespace {

/// A surface is found again within this [voxels]: the noise of depth and the pixels that mix two surfaces.
constexpr int reach = 2;
/// Shares of the cells around a foot that must be a surface to stand on. What a thing hides is not seen.
constexpr double enoughSurface = 0.1, enoughThing = 0.25;
/// Lower than this above the floor it stands there [voxels]; legs are thin, and seen late.
constexpr int nearFloor = 5;
constexpr std::size_t fewContacts = 3;
/// Of what was seen at the height where most was, on the floor: tables may hide the rest of it.
constexpr double floorShare = 0.5;

}  // namespace

bool stands(const Footing& footing) {
  return footing.surface >= enoughSurface || carrierOf(footing) >= 0;
}

int carrierOf(const Footing& footing) {
  int carrier = -1;
  double most = enoughThing;
  for (const auto& [thing, share] : footing.things)
    if (share > most || (share == most && (carrier < 0 || thing < carrier))) {
      most = share;
      carrier = thing;
    }
  return carrier;
}

Standing::Standing(const InstanceMap::Voxels& voxels, std::vector<Thing>& things)
    : voxels_(voxels), things_(things) {
  // Voxels in several things belong to the one with most voxels around; the first one where equal.
  for (std::size_t t = 0; t < things.size(); ++t)
    for (const auto& [at, inside] : things[t].voxels) {
      const auto [place, isNew] = owner_.emplace(at, static_cast<int>(t));
      if (!isNew && things[t].voxels.size() > things[static_cast<std::size_t>(place->second)].voxels.size())
        place->second = static_cast<int>(t);
    }
}

Footing Standing::footingOf(int thing) const {
  const Thing& self = things_[static_cast<std::size_t>(thing)];
  Footing footing;
  std::vector<int> heights;
  std::map<std::pair<int, int>, int> columns;  // lowest voxel
  for (const auto& [at, inside] : self.voxels) {
    heights.push_back(at.z);
    const auto [column, isNew] = columns.emplace(std::pair(at.x, at.y), at.z);
    if (!isNew) column->second = std::min(column->second, at.z);
  }
  std::ranges::sort(heights);
  footing.bottom = heights[heights.size() / 50];
  std::set<std::pair<int, int>> foot, around;
  for (const auto& [column, lowest] : columns)
    if (lowest <= footing.bottom + reach + 1) foot.insert(column);
  for (const auto& [x, y] : foot)
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j)
        if (!foot.contains({x + i, y + j})) around.emplace(x + i, y + j);
  for (const auto& [x, y] : around) {
    std::set<int> here;
    bool surface = false;
    for (int z = footing.bottom - reach; z <= footing.bottom + 1; ++z) {
      const auto owner = owner_.find({x, y, z});
      if (owner == owner_.end())
        surface = surface || voxels_.contains({x, y, z});
      else if (owner->second != thing)
        here.insert(owner->second);
    }
    footing.surface += surface;
    for (const int other : here) footing.things[other] += 1;
  }
  const auto cells = static_cast<double>(std::max<std::size_t>(1, around.size()));
  footing.surface /= cells;
  for (auto& [other, share] : footing.things) share /= cells;
  for (const auto& [at, inside] : self.voxels) {
    std::set<int> touched;
    bool wall = false;
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j) {
        for (int k = -1; k <= 1; ++k)
          if (const auto owner = owner_.find({at.x + i, at.y + j, at.z + k});
              owner != owner_.end() && owner->second != thing)
            touched.insert(owner->second);
        wall = wall || isSurface({at.x + i, at.y + j, at.z});
      }
    for (const int other : touched) ++footing.contact[other];
    footing.wall += wall;
  }
  footing.wall /= static_cast<double>(self.voxels.size());
  return footing;
}

int Standing::floorLevel(int eyes) const {
  std::map<int, std::size_t> counts;
  for (const auto& [at, voxel] : voxels_)
    if (at.z < eyes) ++counts[at.z];
  std::size_t most = 0;
  for (const auto& [level, count] : counts) most = std::max(most, count);
  int floor = eyes;
  std::size_t here = 0;
  for (const auto& [level, count] : counts) {  // upwards
    if (here > 0 && count <= here) break;
    if (here == 0 && static_cast<double>(count) < floorShare * static_cast<double>(most)) continue;
    floor = level;
    here = count;
  }
  return floor;
}

void Standing::joinFloating(int floor) {
  for (bool again = true; again;) {
    again = false;
    std::vector<int> order;
    for (std::size_t t = 0; t < things_.size(); ++t)
      if (!things_[t].gone) order.push_back(static_cast<int>(t));
    const auto sizeOf = [this](int t) { return things_[static_cast<std::size_t>(t)].voxels.size(); };
    std::ranges::stable_sort(order, {}, sizeOf);
    for (const int t : order) {
      const Footing footing = footingOf(t);
      if (footing.bottom <= floor + nearFloor || stands(footing)) continue;
      int neighbor = -1;
      std::size_t most =
          std::max(fewContacts, static_cast<std::size_t>(std::sqrt(static_cast<double>(sizeOf(t)))) / 2);
      for (const auto& [other, contacts] : footing.contact)
        if (sizeOf(other) >= sizeOf(t) &&
            (contacts > most || (contacts == most && (neighbor < 0 || other < neighbor)))) {
          most = contacts;
          neighbor = other;
        }
      if (neighbor < 0) continue;
      Thing &from = things_[static_cast<std::size_t>(t)], &into = things_[static_cast<std::size_t>(neighbor)];
      for (const auto& [at, inside] : from.voxels) {
        into.voxels.emplace(at, inside);
        owner_[at] = neighbor;
      }
      into.masks.insert(into.masks.end(), from.masks.begin(), from.masks.end());
      from.gone = again = true;
    }
  }
}

}  // namespace estancia
