// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/evaluate_world.hpp"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <set>

#include "estancia/core/printable.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

/// Standard deviation of positions along the second of their main axes [m].
double widthOfPath(std::span<const Pose> poses) {
  std::vector<cv::Vec3d> positions;
  for (const Pose& pose : poses) positions.emplace_back(pose.x, pose.y, pose.z);
  cv::Mat covariance, mean, values;
  cv::calcCovarMatrix(cv::Mat(positions).reshape(1), covariance, mean,
                      cv::COVAR_NORMAL | cv::COVAR_ROWS | cv::COVAR_SCALE);
  cv::eigen(covariance, values);
  return std::sqrt(std::max(0.0, values.at<double>(1)));
}

/// The mean rotation (chordal), and the mean shift that is left.
Pose byDirections(std::span<const Pose> estimated, std::span<const Pose> truth) {
  cv::Matx33d sum = cv::Matx33d::zeros();
  for (std::size_t i = 0; i < truth.size(); ++i)
    sum += rigidOf(truth[i]).rotation() * rigidOf(estimated[i]).rotation().t();
  cv::Matx31d w;
  cv::Matx33d u, vt;
  cv::SVD::compute(sum, w, u, vt);
  const double mirrored = cv::determinant(u) * cv::determinant(vt) < 0 ? -1 : 1;
  const cv::Matx33d rotation = u * cv::Matx33d::diag({1, 1, mirrored}) * vt;
  cv::Vec3d shift;
  for (std::size_t i = 0; i < truth.size(); ++i)
    shift += rigidOf(truth[i]).translation() - rotation * rigidOf(estimated[i]).translation();
  return poseOf({rotation, shift * (1.0 / static_cast<double>(truth.size()))});
}

/// The box of an object on the axes of the truth, whose z is up.
OrientedBox boxOf(const WorldObject& object, const Floor& floor, const cv::Affine3d& toTruth) {
  const cv::Vec3d along =
      toTruth.rotation() * cv::Vec3d(floor.point({std::cos(object.yaw), std::sin(object.yaw), 0}));
  return {toTruth * object.center, object.size, std::atan2(along[1], along[0])};
}

/// A map, the drive that it is of, and the frame of the drive that each of its frames is.
struct MapAndDrive {
  const WorldMap& world;
  const WorldStore& store;
  fs::path folder;
  const Sequence& drive;
  std::vector<std::size_t> frames;
};

/// Things that the objects' segments show by the masks of the drive; nothing if either is missing.
void addPixelsOfObjects(const MapAndDrive& both, std::vector<FoundInstance>& found) {
  const std::map<SegmentPlace, int> objectOf = both.store.objectSegments();
  if (objectOf.empty()) return;
  std::map<SegmentPlace, PixelsOfThings> pixels;
  both.store.forEachObservation([&](std::size_t frame, const Observation& seen) {
    const auto index = both.world.places.findFrame(frame);
    if (!index) return true;
    const fs::path mask = io::instanceMaskFile(both.folder, both.drive.frame(both.frames[*index]));
    if (fs::exists(mask)) addPixels(frame, seen.segments, io::readInstanceMask(mask), pixels);
    return true;
  });
  for (const auto& [place, shown] : pixels)
    if (const auto object = objectOf.find(place);
        object != objectOf.end() && object->second < static_cast<int>(found.size()))
      for (const auto& [id, count] : shown)
        found[static_cast<std::size_t>(object->second)].pixels[id] += count;
}

InstanceAccuracy judgeObjects(const MapAndDrive& both, const io::HomeTruth& truth, const Pose& toTruth,
                              const ThingClasses& classes) {
  const Floor floor = floorOf(both.world);
  std::vector<FoundInstance> found;
  for (const WorldObject& object : both.world.objects)
    found.push_back({boxOf(object, floor, rigidOf(toTruth)),
                     object.support == Support::wall,
                     object.words.empty() ? "" : object.words.front().label,
                     {}});
  addPixelsOfObjects(both, found);
  std::set<std::string> images;
  for (const MappedFrame& frame : both.world.places.frames)
    images.insert(fs::path(frame.name).filename().string());
  return judgeInstances(found, trueThings(truth, classes, &both.world.places.vocabulary, images));
}

/// A path that is off by more than half a meter is another one, or has lost its way.
void doubtTheDrive(WorldAccuracy& accuracy, const fs::path& drive, std::size_t mapped, std::size_t frames) {
  if (accuracy.trajectory && accuracy.trajectory->rmse > 0.5)
    accuracy.doubts.push_back(fmt::format(
        "the path of the map is off that of {} by {:.1f} m (root mean square): is it the drive that "
        "was mapped? Images of another one may have the same names",
        printable(drive.string()), accuracy.trajectory->rmse));
  if (mapped < frames)
    accuracy.doubts.push_back(
        fmt::format("the map holds {} of the {} images of {}: it was made of a part of "
                    "that drive, or of another one whose images have the same names",
                    mapped, frames, printable(drive.string())));
}

}  // namespace

Pose truthFromMap(std::span<const Pose> estimated, std::span<const Pose> truth) {
  const Pose byPositions = absoluteTrajectoryError(estimated, truth).truthFromEstimate;
  // Positions within 10 cm of one line leave the turn about it open.
  return std::min(widthOfPath(estimated), widthOfPath(truth)) < 0.1 ? byDirections(estimated, truth)
                                                                    : byPositions;
}

WorldAccuracy evaluateWorld(const fs::path& map, const fs::path& drive,
                            std::span<const std::string> roomsSeen, const ThingClasses& classes) {
  MapStore store = MapStore::open(map, MapStore::Access::read);
  store.beginReading();
  WorldMap world{store.load()};
  const WorldStore layers(store, MapStore::Access::read);
  layers.read(world);
  const io::HomeTruth truth = io::readHomeTruth(drive);
  const auto sequence = openSequence(drive);
  std::vector<std::string> images, stoodIn;
  for (const MappedFrame& frame : world.places.frames) images.push_back(frame.name);
  const MapAndDrive both{world, layers, drive, *sequence, io::framesOfImages(*sequence, drive, images)};

  std::vector<Pose> estimated, exact;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Frame& known = sequence->frame(both.frames[i]);
    stoodIn.push_back(known.room);
    if (!world.places.frames[i].pose || !known.pose) continue;
    estimated.push_back(*world.places.frames[i].pose);
    exact.push_back(*known.pose);
  }
  WorldAccuracy accuracy;
  accuracy.areas = world.areas.size();
  if (!world.areas.empty()) {
    accuracy.areasAndRooms = measureNamedAgreement(stoodIn, world.areaOfFrame).agreement;
    accuracy.areasAndRoomsSeen = measureNamedAgreement(roomsSeen, world.areaOfFrame).agreement;
  }
  if (!estimated.empty()) accuracy.trajectory = absoluteTrajectoryError(estimated, exact);
  doubtTheDrive(accuracy, drive, images.size(), sequence->size());
  if (estimated.empty()) return accuracy;
  if (!world.objects.empty() && !truth.instances.empty())
    accuracy.objects = judgeObjects(both, truth, truthFromMap(estimated, exact), classes);
  return accuracy;
}

}  // namespace estancia
