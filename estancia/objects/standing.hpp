// Standing: what things stand on, and which parts belong together because nothing floats.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "estancia/objects/instance_map.hpp"

namespace estancia {

/// Outermost points of a thing that are left out of its box, at each end: mixed pixels.
constexpr double trimmedOfBoxes = 0.005;

/// The voxels of a thing, each with its masks' mean point [m], from the voxel's corner.
struct Thing {
  std::vector<std::uint32_t> masks;
  std::unordered_map<VoxelKey, cv::Vec3f, VoxelHash> voxels = {};
  bool gone = false;
};

/// Surfaces around the foot and the sides of a thing.
struct Footing {
  /// Height of its foot [voxels].
  int bottom = 0;
  /// Share of the cells around its foot that are a surface at that height: free, and of each thing.
  double surface = 0;
  std::unordered_map<int, double> things;
  /// Its voxels that touch this thing.
  std::unordered_map<int, std::size_t> contact;
  /// Share of its voxels adjacent to an unassigned surface.
  double wall = 0;
};

/// Where things are among what was seen.
class Standing {
 public:
  Standing(const InstanceMap::Voxels& voxels, std::vector<Thing>& things);

  Footing footingOf(int thing) const;
  /// The height of the floor [voxels]: the lowest one below `eyes` at which much was seen.
  int floorLevel(int eyes) const;
  /// Joins each part of a thing to it: what stands on nothing, to the larger thing that it touches most, and
  /// what a larger thing that it touches but does not stand on holds nearly whole.
  void joinParts(int floor);
  /// Gives loose voxels above the floor to the thing that their cluster touches most, unless it is larger.
  /// They remain an unassigned surface for footingOf(). `voxel`: their width [m].
  void joinLoose(int floor, double voxel);

 private:
  bool isSurface(const VoxelKey& at) const { return voxels_.contains(at) && !owner_.contains(at); }
  std::vector<std::vector<VoxelKey>> looseClusters(int floor) const;
  /// The thing that owns most of the space around the voxels; -1 for none.
  int touchedBy(const std::vector<VoxelKey>& voxels) const;

  const InstanceMap::Voxels& voxels_;
  std::vector<Thing>& things_;
  std::unordered_map<VoxelKey, int, VoxelHash> owner_;
};

/// Whether so much around its foot is a surface that it stands there.
bool stands(const Footing& footing);
/// The thing that it stands on; -1 for none.
int carrierOf(const Footing& footing);

}  // namespace estancia
