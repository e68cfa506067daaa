// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/standing.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_set>
#include <utility>

#include "estancia/core/oriented_box.hpp"

namespace estancia {
namespace {

/// A surface is found again within this [voxels]: the noise of depth and the pixels that mix two surfaces.
constexpr int reach = 2;
/// Shares of the cells around a foot that must be a surface to stand on. What a thing hides is not seen.
constexpr double enoughSurface = 0.1, enoughThing = 0.25;
/// Lower than this above the floor it stands there [voxels]; legs are thin, and seen late.
constexpr int nearFloor = 5;
constexpr std::size_t fewContacts = 3;
/// Min count of the floor's height, as a share of the largest of all heights: tables hide some of the floor.
constexpr double floorShare = 0.5;
/// Min share of a part's voxels that lie in the box of an object.
constexpr double partShare = 0.8;
/// Min share of the frames seeing a voxel in which it is loose.
constexpr double looseShare = 0.5;

template <class Use>
void forEachAround(VoxelKey voxel, const Use& use) {  // a copy: `use` may add to the list that it is from
  for (int x = -reach; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y)
      for (int z = -reach; z <= reach; ++z) use(VoxelKey{voxel.x + x, voxel.y + y, voxel.z + z});
}

OrientedBox boxOf(const Thing& thing) {
  std::vector<cv::Point3d> points;
  for (const auto& [at, inside] : thing.voxels) points.emplace_back(at.x, at.y, at.z);
  return fitBox(points, trimmedOfBoxes, 1);
}

/// Share of an object's voxels in the box or below it, within a voxel: legs are found later than tops.
double shareInside(const Thing& thing, const OrientedBox& box) {
  const double c = std::cos(box.yaw), s = std::sin(box.yaw);
  const auto inside = std::ranges::count_if(thing.voxels, [&](const auto& voxel) {
    const auto& at = voxel.first;
    const double x = at.x - box.center.x, y = at.y - box.center.y;
    return std::abs(c * x + s * y) <= box.size.x / 2 + 1 && std::abs(c * y - s * x) <= box.size.y / 2 + 1 &&
           at.z <= box.center.z + box.size.z / 2 + 1;
  });
  return static_cast<double>(inside) / static_cast<double>(thing.voxels.size());
}

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

void Standing::joinParts(int floor) {
  std::map<int, OrientedBox> boxes;  // boxes of things as they are now [voxels]
  const auto sizeOf = [this](int t) { return things_[static_cast<std::size_t>(t)].voxels.size(); };
  const auto isInside = [&](int part, int whole) {
    auto box = boxes.find(whole);
    if (box == boxes.end()) box = boxes.emplace(whole, boxOf(things_[static_cast<std::size_t>(whole)])).first;
    return shareInside(things_[static_cast<std::size_t>(part)], box->second) >= partShare;
  };
  for (bool again = true; again;) {
    again = false;
    std::vector<int> order;
    for (std::size_t t = 0; t < things_.size(); ++t)
      if (!things_[t].gone) order.push_back(static_cast<int>(t));
    std::ranges::stable_sort(order, {}, sizeOf);
    for (const int t : order) {
      const Footing footing = footingOf(t);
      const bool floats = footing.bottom > floor + nearFloor && !stands(footing);
      int whole = -1;
      std::size_t most =
          std::max(fewContacts, static_cast<std::size_t>(std::sqrt(static_cast<double>(sizeOf(t)))) / 2);
      for (const auto& [other, contacts] : footing.contact) {
        const bool more = contacts > most || (contacts == most && (whole < 0 || other < whole));
        if (!more || sizeOf(other) < sizeOf(t)) continue;
        if (!floats && (carrierOf(footing) == other || !isInside(t, other))) continue;
        most = contacts;
        whole = other;
      }
      if (whole < 0) continue;
      Thing &from = things_[static_cast<std::size_t>(t)], &into = things_[static_cast<std::size_t>(whole)];
      for (const auto& [at, inside] : from.voxels) {
        into.voxels.emplace(at, inside);
        owner_[at] = whole;
      }
      into.masks.insert(into.masks.end(), from.masks.begin(), from.masks.end());
      boxes.erase(whole);
      from.gone = again = true;
    }
  }
}

std::vector<std::vector<VoxelKey>> Standing::looseClusters(int floor) const {
  std::vector<VoxelKey> loose;
  for (const auto& [at, voxel] : voxels_)
    if (at.z > floor + reach && voxel.loose >= looseShare * voxel.seen && !owner_.contains(at))
      loose.push_back(at);
  std::ranges::sort(loose);  // in an order that no hash decides
  std::unordered_set<VoxelKey, VoxelHash> open(loose.begin(), loose.end());
  std::vector<std::vector<VoxelKey>> clusters;
  for (const VoxelKey& seed : loose) {
    if (open.erase(seed) == 0) continue;
    std::vector<VoxelKey> cluster{seed};
    for (std::size_t next = 0; next < cluster.size(); ++next)
      forEachAround(cluster[next], [&](const VoxelKey& at) {
        if (open.erase(at) != 0) cluster.push_back(at);
      });
    clusters.push_back(std::move(cluster));
  }
  return clusters;
}

int Standing::touchedBy(const std::vector<VoxelKey>& voxels) const {
  std::map<int, std::size_t> contacts;
  for (const VoxelKey& voxel : voxels) {
    std::set<int> touched;
    forEachAround(voxel, [&](const VoxelKey& at) {
      if (const auto owner = owner_.find(at); owner != owner_.end()) touched.insert(owner->second);
    });
    for (const int thing : touched) ++contacts[thing];
  }
  int most = -1;
  for (const auto& [thing, count] : contacts)
    if (count >= fewContacts && (most < 0 || count > contacts.at(most))) most = thing;
  return most;
}

void Standing::joinLoose(int floor, double voxel) {
  const cv::Vec3f middle = cv::Vec3f::all(static_cast<float>(voxel / 2));
  for (const std::vector<VoxelKey>& cluster : looseClusters(floor)) {
    const int thing = touchedBy(cluster);
    if (thing < 0) continue;
    auto& into = things_[static_cast<std::size_t>(thing)].voxels;
    if (cluster.size() > into.size()) continue;
    for (const VoxelKey& at : cluster) into.emplace(at, middle);
  }
}

}  // namespace estancia
