// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/instance_map.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/objects/standing.hpp"
#include "estancia/stats/proportion.hpp"

namespace estancia {
namespace {

/// Min share of the frames seeing a voxel that must assign it to the object.
constexpr double keptShare = 0.3;
constexpr std::size_t fewVoxels = 8;
/// Vote of a frame that sees a wall there.
constexpr double wallVote = 0.5;
/// ObjectInstance::support below which it is a part of things, or none.
constexpr double minSupport = 0.25;
/// Minimum share of wall beside a thing that hangs.
constexpr double atWall = 0.15;
/// Maximum height [m] above the floor of a thing without support that stands on an unseen part of it.
constexpr double hiddenLegs = 0.7;

std::size_t segmentsIn(const cv::Mat& image) {
  std::uint8_t most = 0;
  for (const std::uint8_t pixel : cv::Mat_<std::uint8_t>(image))
    if (inSegment(pixel)) most = std::max(most, pixel);
  return most;
}

/// A voxel is in one segment, the first one; else it is loose, or a surface, or a wall.
bool precedes(std::uint8_t pixel, std::uint8_t other) {
  const auto rank = [](std::uint8_t p) { return p == wallPixel ? 0 : p == 0 ? 1 : p == loosePixel ? 2 : 3; };
  return rank(pixel) > rank(other);
}

/// The voxels that most views of the things agree on.
std::vector<Thing> thingsOf(const std::vector<std::vector<std::uint32_t>>& clusters,
                            const InstanceMap::Voxels& voxels, const std::vector<InstanceMap::Mask>& masks,
                            std::size_t minViews) {
  std::vector<Thing> things;
  for (const auto& cluster : clusters) {
    std::set<std::size_t> frames;
    std::unordered_map<VoxelKey, std::pair<cv::Vec3f, float>, VoxelHash> sums;
    for (const std::uint32_t m : cluster) {
      frames.insert(masks[m].frame);
      for (const InstanceMap::Mask::Part& part : masks[m].parts) {
        auto& [sum, count] = sums[part.at];
        sum += part.inside;
        ++count;
      }
    }
    if (frames.size() < minViews) continue;
    Thing thing{cluster};
    for (const auto& [at, sum] : sums)
      if (static_cast<double>(sum.second) >= keptShare * voxels.at(at).seen)
        thing.voxels.emplace(at, sum.first / sum.second);
    if (thing.voxels.size() >= fewVoxels) things.push_back(std::move(thing));
  }
  return things;
}

double supportOf(const Thing& thing, const InstanceMap::Voxels& voxels,
                 const std::vector<InstanceMap::Mask>& masks) {
  std::set<std::size_t> frames;
  std::set<VoxelKey> places;
  double shown = 0, seen = 0;
  for (const std::uint32_t m : thing.masks) {
    frames.insert(masks[m].frame);
    for (const InstanceMap::Mask::Part& part : masks[m].parts) {
      if (!thing.voxels.contains(part.at)) continue;
      ++shown;
      if (places.insert(part.at).second) seen += voxels.at(part.at).seen;
    }
  }
  if (shown == 0) return 0;
  // A frame may show a part of it only: the share is that of the voxels, the trials are frames.
  const double share = std::min(1.0, shown / seen);
  return wilsonInterval(share, static_cast<double>(frames.size()) / share).first;
}

}  // namespace

OptionGroup declare(InstanceMapOptions& options) {
  OptionGroup group("instance-map", "How segments become things that last.");
  group.add("voxel", &options.voxel, "Width of a voxel.")
      .range(0.005, 0.2)
      .unit("m")
      .why("Wider than the noise of depth and poses, narrower than the gaps between things.");
  group
      .add("consensus", &options.consensus,
           "Share of the frames that see two segments and have them in one, for them to be one thing.")
      .above(0, 1);
  group.add("min-views", &options.minViews, "Frames that must show a thing.").range(1);
  return group;
}

InstanceMap::InstanceMap(const Floor& floor, const InstanceMapOptions& options)
    : floor_(floor), options_(options) {
  declare(options_).validate();
}

void InstanceMap::add(std::size_t frame, const cv::Mat& depth, const cv::Mat& segments,
                      const CameraIntrinsics& camera, const Pose& pose) {
  if (depth.type() != CV_32F || segments.type() != CV_8U || depth.size() != segments.size())
    fail(ErrorCode::invalidInput,
         "an instance map takes a depth image and the segment of each of its pixels");
  constexpr double farthest = 1e6;  // voxels are counted by int
  const CameraIntrinsics scaled = camera.scaledTo(depth.cols, depth.rows);
  const cv::Affine3d rigid = rigidOf(pose);
  heights_.push_back(floor_.height(rigid.translation()));
  const std::size_t count = segmentsIn(segments);
  newest_ = masks_.size();
  struct Sum {
    std::uint8_t pixel = wallPixel;
    cv::Vec3d inside;
    int points = 0;
  };
  std::unordered_map<VoxelKey, Sum, VoxelHash> here;
  here.reserve(depth.total() / 4);
  std::vector<std::size_t> pixels(count + 1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const double z = depth.at<float>(v, u);
      if (!(z > 0) || !std::isfinite(z)) continue;
      const cv::Vec3d point = rigid * cv::Vec3d(scaled.slopeX(u) * z, scaled.slopeY(v) * z, z);
      const cv::Point2d at = floor_.position(point);
      const cv::Vec3d place = cv::Vec3d(at.x, at.y, floor_.height(point)) / options_.voxel;
      if (!(cv::norm(place, cv::NORM_INF) < farthest)) continue;
      const VoxelKey key{static_cast<std::int32_t>(std::floor(place[0])),
                         static_cast<std::int32_t>(std::floor(place[1])),
                         static_cast<std::int32_t>(std::floor(place[2]))};
      const std::uint8_t pixel = segments.at<std::uint8_t>(v, u);
      Sum& sum = here[key];
      if (precedes(pixel, sum.pixel)) sum.pixel = pixel;
      if (!inSegment(pixel)) continue;
      ++pixels[pixel];
      if (pixel != sum.pixel) continue;
      sum.inside += options_.voxel * (place - cv::Vec3d(key.x, key.y, key.z));
      ++sum.points;
    }
  for (std::size_t s = 1; s <= count; ++s) masks_.push_back({frame, s, pixels[s], {}});
  for (const auto& [key, sum] : here) {
    Voxel& voxel = voxels_[key];
    voxel.seen += sum.pixel == wallPixel ? wallVote : 1;
    if (sum.pixel == loosePixel) ++voxel.loose;
    if (!inSegment(sum.pixel)) continue;
    ++voxel.masked;
    const std::size_t mask = newest_ + sum.pixel - 1;
    voxel.masks.push_back(static_cast<std::uint32_t>(mask));
    masks_[mask].parts.push_back({key, sum.inside / sum.points});
  }
  for (std::size_t m = newest_; m < masks_.size(); ++m)  // in an order that no hash decides
    std::ranges::sort(masks_[m].parts, {}, &Mask::Part::at);
}

std::vector<double> InstanceMap::worthLabeling() const {
  std::vector<double> worth;
  for (std::size_t m = newest_; m < masks_.size(); ++m) {
    double labeled = 0;
    for (const Mask::Part& part : masks_[m].parts) labeled += voxels_.at(part.at).labeled;
    const auto parts = static_cast<double>(std::max<std::size_t>(1, masks_[m].parts.size()));
    worth.push_back(std::sqrt(static_cast<double>(masks_[m].pixels)) /
                    ((1 + labeled / parts) * (1 + labeled / parts)));
  }
  return worth;
}

void InstanceMap::labeled(const SegmentPlace& segment) {
  const auto mask = std::ranges::lower_bound(masks_, segment, {},
                                             [](const Mask& m) { return SegmentPlace(m.frame, m.segment); });
  if (mask == masks_.end() || SegmentPlace(mask->frame, mask->segment) != segment)
    fail(ErrorCode::invalidInput, "frame {} has no segment {}", segment.first, segment.second);
  for (const Mask::Part& part : mask->parts) ++voxels_.at(part.at).labeled;
}

std::vector<ObjectInstance> InstanceMap::instances() const {
  std::vector<Thing> things = thingsOf(clusterMasks(), voxels_, masks_, options_.minViews);
  if (things.empty()) return {};
  std::vector<double> heights = heights_;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  Standing standing(voxels_, things);
  const int level = standing.floorLevel(static_cast<int>(std::floor(*middle / options_.voxel)));
  standing.joinParts(level);
  standing.joinLoose(level, options_.voxel);
  const double floor = (level + 0.5) * options_.voxel;
  std::vector<ObjectInstance> instances;
  std::vector<int> numbers(things.size(), -1), carriers;
  for (std::size_t t = 0; t < things.size(); ++t) {
    const Thing& thing = things[t];
    if (thing.gone) continue;
    const double support = supportOf(thing, voxels_, masks_);
    if (support < minSupport) continue;
    const Footing footing = standing.footingOf(static_cast<int>(t));
    ObjectInstance instance;
    std::vector<cv::Point3d> points;
    for (const auto& [at, inside] : thing.voxels)
      points.emplace_back(at.x * options_.voxel + static_cast<double>(inside[0]),
                          at.y * options_.voxel + static_cast<double>(inside[1]),
                          at.z * options_.voxel + static_cast<double>(inside[2]));
    instance.box = fitBox(points, trimmedOfBoxes, options_.voxel / 2);
    const double top = instance.box.center.z + instance.box.size.z / 2;
    double bottom = instance.box.center.z - instance.box.size.z / 2;
    using Stands = ObjectInstance::Stands;
    const bool onFloor = bottom < floor + 5 * options_.voxel;
    if (onFloor)
      instance.stands = Stands::floor;
    else if (carrierOf(footing) >= 0)
      instance.stands = Stands::instance;
    else if (stands(footing))
      instance.stands = Stands::surface;
    else if (footing.wall >= atWall)
      instance.stands = Stands::wall;
    else if (bottom < floor + hiddenLegs)
      instance.stands = Stands::floor;
    if (instance.stands == Stands::floor && top > floor) bottom = floor;
    instance.box.center.z = (top + bottom) / 2;
    instance.box.size.z = top - bottom;
    std::set<std::size_t> frames;
    for (const std::uint32_t m : thing.masks) {
      instance.segments.emplace_back(masks_[m].frame, masks_[m].segment);
      frames.insert(masks_[m].frame);
    }
    std::ranges::sort(instance.segments);
    instance.views = frames.size();
    instance.support = support;
    numbers[t] = static_cast<int>(instances.size());
    carriers.push_back(instance.stands == Stands::instance ? carrierOf(footing) : -1);
    instances.push_back(std::move(instance));
  }
  for (std::size_t i = 0; i < instances.size(); ++i)
    if (carriers[i] >= 0) instances[i].on = numbers[static_cast<std::size_t>(carriers[i])];
  return instances;
}

}  // namespace estancia
