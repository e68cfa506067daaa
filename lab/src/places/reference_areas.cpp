// SPDX-License-Identifier: Apache-2.0
#include "places/reference_areas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <unordered_map>

#include "estancia/areas/areas.hpp"
#include "estancia/areas/occupancy_grid.hpp"
#include "estancia/core/error.hpp"

namespace estancia::experiments {
namespace {

/// Calls use(mask) with each connected part that is farther than `threshold` from walls and of such a size
/// [m²].
template <class Use>
void eachPart(const cv::Mat& distance, double threshold, double cell, double least, double most,
              const Use& use) {
  cv::Mat parts, stats, centers;
  const int count = cv::connectedComponentsWithStats(distance > threshold, parts, stats, centers);
  for (int part = 1; part < count; ++part) {
    const double size = stats.at<int>(part, cv::CC_STAT_AREA) * cell * cell;
    if (size >= least && size <= most) use(cv::Mat(parts == part));
  }
}

/// Rooms grow over the cells of `over` (CV_8U, not 0) that they reach, all at the same pace.
void grow(cv::Mat& rooms, const cv::Mat& over) {
  for (int left = -1;;) {
    const cv::Mat open = (rooms == 0) & over;
    const int now = cv::countNonZero(open);
    if (now == left) return;
    left = now;
    cv::Mat grown;
    cv::dilate(rooms, grown, cv::Mat());
    grown.copyTo(rooms, open);
  }
}

/// `seeds` (CV_16U) grown over free space.
cv::Mat roomsOf(cv::Mat seeds, const cv::Mat& distance) {
  grow(seeds, distance > 0);
  cv::Mat rooms;
  seeds.convertTo(rooms, CV_32S);
  return rooms;
}

OccupancyGrid gridOf(const Sequence& sequence, const DescriptorSequence& labeled) {
  std::unordered_map<std::string, std::size_t> numbers;
  for (std::size_t i = 0; i < sequence.size(); ++i) numbers.emplace(sequence.frame(i).name, i);
  std::vector<Pose> poses;
  for (const Frame& frame : labeled.frames)
    if (frame.pose) poses.push_back(*frame.pose);
  if (!sequence.intrinsics() || poses.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: areas need poses and the camera of the depth images", sequence.name()));
  OccupancyGrid grid(Floor(poses), AreaOptions{}.cell);
  for (const Frame& frame : labeled.frames)
    if (frame.pose) grid.add(sequence.depth(numbers.at(frame.name)), *sequence.intrinsics(), *frame.pose);
  return grid;
}

}  // namespace

cv::Mat morphologicalRooms(const cv::Mat& distance, double cell) {
  cv::Mat rest = distance.clone(), seeds(distance.size(), CV_16U, cv::Scalar(0));
  int count = 0;
  for (double eroded = cell; cv::countNonZero(rest > eroded) > 0; eroded += cell)
    eachPart(rest.clone(), eroded, cell, 0.8, 25, [&](const cv::Mat& part) {
      seeds.setTo(++count, part);
      rest.setTo(0, part);
    });
  return roomsOf(seeds, distance);
}

cv::Mat distanceTransformRooms(const cv::Mat& distance, double cell) {
  cv::Mat best(distance.size(), CV_16U, cv::Scalar(0));
  int most = 0;
  double farthest = 0;
  cv::minMaxLoc(distance, nullptr, &farthest);
  for (double threshold = farthest; threshold > 0; threshold -= cell) {
    cv::Mat seeds(distance.size(), CV_16U, cv::Scalar(0));
    int count = 0;
    eachPart(distance, threshold, cell, 0.1, 163, [&](const cv::Mat& part) { seeds.setTo(++count, part); });
    if (count > most) most = count, best = seeds;
  }
  return roomsOf(best, distance);
}

std::vector<int> referenceAreas(const Sequence& sequence, const DescriptorSequence& labeled,
                                RoomMethod method) {
  const OccupancyGrid grid = gridOf(sequence, labeled);
  cv::Mat freeSpace, distance, rooms;
  cv::morphologyEx(grid.freeSpace(), freeSpace, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  cv::distanceTransform(grid.walls() == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  distance.setTo(0, freeSpace == 0);
  method(distance * grid.cells().cell(), grid.cells().cell()).convertTo(rooms, CV_16U);
  grow(rooms, cv::Mat::ones(rooms.size(), CV_8U));  // cameras pass over what is not free
  std::vector<int> areas;
  for (const Frame& frame : labeled.frames) {
    int area = areas.empty() ? 0 : areas.back();
    if (frame.pose) {
      const PlanarPose at = grid.floor().project(*frame.pose);
      const cv::Point cell = grid.cells().at(at.x, at.y);
      area = rooms.at<std::uint16_t>(std::clamp(cell.y, 0, rooms.rows - 1),
                                     std::clamp(cell.x, 0, rooms.cols - 1));
    }
    areas.push_back(area);
  }
  return areas;
}

}  // namespace estancia::experiments
