// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/areas.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <unordered_map>

#include "estancia/areas/occupancy_grid.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/zones/naming.hpp"

namespace estancia {
namespace {

/// What a drive shows of the floor.
struct Survey {
  OccupancyGrid grid;
  WordMap words;
};

std::vector<Pose> posesOf(const DescriptorSequence& labeled) {
  std::vector<Pose> poses;
  for (const Frame& frame : labeled.frames)
    if (frame.pose && frame.pose->isPlausible()) poses.push_back(*frame.pose);
  return poses;
}

Survey survey(const Sequence& sequence, const DescriptorSequence& labeled, const AreaOptions& options,
              Progress& progress) {
  if (!sequence.intrinsics())
    fail(ErrorCode::insufficientData, "{}: the camera of the depth images is unknown; give its intrinsics",
         sequence.name());
  const std::vector<Pose> poses = posesOf(labeled);
  const Floor floor(poses);
  Survey result{{floor, options.cell}, {floor, labeled.vocabulary.size(), options.words}};
  std::unordered_map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < sequence.size(); ++i) places.emplace(sequence.frame(i).name, i);
  std::string why = poses.empty() ? "none has a pose" : "none with a pose has depth";
  progress.begin("areas", labeled.frames.size());
  for (std::size_t i = 0; i < labeled.frames.size(); ++i) {
    if (interrupted()) throw Interrupted(fmt::format("stopped after {} frames", i));
    progress.advance();
    const Frame& frame = labeled.frames[i];
    const auto place = places.find(frame.name);
    if (!frame.pose || !frame.pose->isPlausible() || place == places.end()) continue;
    cv::Mat depth;
    try {
      depth = sequence.depth(place->second);
    } catch (...) {
      why = frameFailure(frame.name).what();  // it still has a pose: it is in an area
      continue;
    }
    result.grid.add(depth, *sequence.intrinsics(), *frame.pose);
    result.words.add(labeled.descriptors.row(i), depth, *sequence.intrinsics(), *frame.pose);
  }
  progress.end();
  if (result.grid.cells().empty())
    fail(ErrorCode::insufficientData,
         "{}: no frame has a pose and depth to see the floor plan by ({}); `estancia check` tells more, "
         "`estancia odometry estimate` finds poses",
         sequence.name(), why);
  return result;
}

/// Rooms (1, 2 …) where they are, and elsewhere the nearest one that is not farther than `reach` cells.
cv::Mat nearestRooms(const cv::Mat& rooms, double reach) {
  cv::Mat distance, nearest;
  cv::distanceTransform(rooms == 0, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  double most = 0;
  cv::minMaxLoc(nearest, nullptr, &most);
  std::vector<int> roomOf(static_cast<std::size_t>(most) + 1);
  for (int row = 0; row < rooms.rows; ++row)
    for (int column = 0; column < rooms.cols; ++column)
      if (const int room = rooms.at<int>(row, column)) roomOf[nearest.at<int>(row, column)] = room;
  cv::Mat_<int> result(rooms.size(), 0);
  for (int row = 0; row < rooms.rows; ++row)
    for (int column = 0; column < rooms.cols; ++column)
      if (distance.at<float>(row, column) <= reach)
        result(row, column) = roomOf[nearest.at<int>(row, column)];
  return result;
}

/// The room of each frame's camera; where it has no pose, that of the frame before, else of the first that
/// has one.
std::vector<int> roomsOfFrames(const DescriptorSequence& labeled, const Survey& survey,
                               const cv::Mat& rooms) {
  const cv::Mat nearest = nearestRooms(rooms, rooms.rows + rooms.cols);
  std::vector<int> result;
  int last = 0;
  for (const Frame& frame : labeled.frames) {
    if (frame.pose && frame.pose->isPlausible()) {
      const PlanarPose at = survey.grid.floor().project(*frame.pose);
      const FloorCells& cells = survey.grid.cells();
      const cv::Point cell = cells.at(at.x, at.y);
      last = nearest.at<int>(std::clamp(cell.y, 0, cells.rows() - 1),
                             std::clamp(cell.x, 0, cells.columns() - 1));
    }
    result.push_back(last);
  }
  const auto first = std::find_if(result.begin(), result.end(), [](int room) { return room > 0; });
  std::fill(result.begin(), first, first == result.end() ? 1 : *first);
  return result;
}

/// The number of each room: those with frames by their zone, then the others by size.
std::vector<int> areaNumbers(const Zones& zones, const std::vector<int>& roomOf, int rooms) {
  std::vector<int> numbers(static_cast<std::size_t>(rooms) + 1, -1);
  for (std::size_t i = 0; i < roomOf.size(); ++i) numbers[roomOf[i]] = zones.zoneOf[i];
  int next = static_cast<int>(zones.zones.size());
  for (std::size_t room = 1; room < numbers.size(); ++room)
    if (numbers[room] < 0) numbers[room] = next++;
  return numbers;
}

void describe(Area& area, const cv::Mat& areaOf, const FloorCells& cells) {
  const cv::Mat everywhere = areaOf == area.id;
  const cv::Rect box = cv::boundingRect(everywhere);
  if (box.empty()) return;
  const cv::Mat mask = everywhere(box);  // OpenCV's distances are wrong in images wider than 46,340 pixels
  const auto centerOf = [&](const cv::Point& cell) { return cells.centerOf(cell + box.tl()); };
  area.size = cv::countNonZero(mask) * cells.cell() * cells.cell();
  cv::Mat framed, distance;
  cv::copyMakeBorder(mask, framed, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::distanceTransform(framed, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Point middle;
  cv::minMaxLoc(distance, nullptr, nullptr, nullptr, &middle);
  area.center = centerOf(middle - cv::Point(1, 1));
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  const auto largest = std::max_element(contours.begin(), contours.end(), [](const auto& a, const auto& b) {
    return cv::contourArea(a) < cv::contourArea(b);
  });
  if (largest == contours.end()) return;
  std::vector<cv::Point> outline;
  cv::approxPolyDP(*largest, outline, 2, true);  // to two cells
  for (const cv::Point& corner : outline) area.outline.push_back(centerOf(corner));
  if (cv::contourArea(outline, true) < 0) std::reverse(area.outline.begin(), area.outline.end());
}

/// What is seen above the floor of an area and up to half a meter beyond it: walls and what stands at them.
std::vector<float> wordsOf(int area, const cv::Mat& nearest, const FloorCells& cells, const WordMap& words) {
  cv::Mat mask(words.cells().rows(), words.cells().columns(), CV_8U, cv::Scalar(0));
  for (int row = 0; row < mask.rows; ++row)
    for (int column = 0; column < mask.cols; ++column) {
      const cv::Point2d at = words.cells().centerOf({column, row});
      const cv::Point cell = cells.at(at.x, at.y);
      if (cells.holds(cell) && nearest.at<int>(cell) == area + 1) mask.at<unsigned char>(row, column) = 255;
    }
  return words.mean(mask);
}

std::vector<Area> describeAreas(const Zones& zones, std::size_t count, const Survey& survey,
                                const cv::Mat& areaOf) {
  constexpr double beyond = 0.5;  // [m]
  const FloorCells& cells = survey.grid.cells();
  const cv::Mat nearest = nearestRooms(areaOf + 1, beyond / cells.cell());
  std::vector<Area> areas;
  std::vector<std::vector<float>> means;
  for (std::size_t id = 0; id < count; ++id) {
    Area area{.id = static_cast<int>(id)};
    if (id < zones.zones.size()) area.frames = zones.zones[id].images.size();
    describe(area, areaOf, cells);
    means.push_back(wordsOf(area.id, nearest, cells, survey.words));
    areas.push_back(std::move(area));
  }
  const std::vector<std::string> names = nameZones(zones.vocabulary, means, runMean(zones));
  for (std::size_t id = 0; id < count; ++id) areas[id].name = names[id];
  return areas;
}

}  // namespace

OptionGroup declare(AreaOptions& options) {
  OptionGroup group("areas", "How a drive becomes areas.");
  group.add("cell", &options.cell, "Width of a cell of the floor plan.")
      .range(0.01, 1)
      .unit("m")
      .why("Narrower than the thinnest wall, wider than the noise of the poses.");
  group.add(declare(options.segmentation));
  group.add(declare(options.words));
  return group;
}

Areas findAreas(const Sequence& sequence, const DescriptorSequence& labeled, const AreaOptions& options,
                Progress& progress) {
  validate(options);
  Survey seen = survey(sequence, labeled, options, progress);
  const cv::Mat walls = seen.grid.walls();
  const cv::Mat rooms = segmentRooms(seen.grid.freeSpace(), walls, options.cell, options.segmentation);
  double count = 0;
  cv::minMaxLoc(rooms, nullptr, &count);
  if (count == 0)
    fail(ErrorCode::insufficientData,
         "{}: no room of {} m² was seen; give a smaller areas.room-segmentation.min-area by --set",
         sequence.name(), options.segmentation.minArea);
  const std::vector<int> roomOf = roomsOfFrames(labeled, seen, rooms);
  Zones zones = describeZones(labeled, roomOf);
  zones.distance = "floor plan";
  zones.linkage = "doors";
  zones.cutReason = "rooms of the floor plan, split at doors and narrow passages";
  const std::vector<int> number = areaNumbers(zones, roomOf, static_cast<int>(count));
  cv::Mat_<int> areaOf(rooms.size(), -1);
  std::transform(rooms.begin<int>(), rooms.end<int>(), areaOf.begin(),
                 [&](int room) { return room == 0 ? -1 : number[room]; });
  std::vector<Area> areas = describeAreas(zones, number.size() - 1, seen, areaOf);
  for (Zone& zone : zones.zones) zone.name = areas[zone.id].name;
  return {std::move(zones),     std::move(areas), seen.grid.floor(), seen.grid.cells(), areaOf, walls,
          std::move(seen.words)};
}

}  // namespace estancia
