// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/area_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "estancia/areas/plan_areas.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/words/label_concepts.hpp"
#include "estancia/zones/naming.hpp"

namespace estancia {
namespace {

constexpr double maxCells = 24e6;  // 240 × 240 m at 5 cm; each takes 50 bytes on the way to areas

/// Positions that no grid reaches are all as far away, so that differences of cells are numbers, too.
int cellOf(double position, double cell) {
  constexpr double far = 1e9;
  const double number = std::floor(position / cell);
  if (!(number > -far)) return static_cast<int>(-far);
  return static_cast<int>(std::min(number, far));
}

int maxOf(const cv::Mat& numbers) {
  double max = 0;
  cv::minMaxLoc(numbers, nullptr, &max);
  return static_cast<int>(max);
}

/// Rooms (1, 2 …) where they are, and elsewhere the nearest one that is not farther than `reach` cells.
cv::Mat nearestRooms(const cv::Mat& rooms, double reach) {
  cv::Mat distance, nearest;
  cv::distanceTransform(rooms == 0, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<int> roomOf(static_cast<std::size_t>(maxOf(nearest)) + 1);
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

/// The room of each frame's camera; where it has no pose, that of the frame before in its drive, else of the
/// drive's first that has one; 0 where the drive has none.
std::vector<int> roomsOfFrames(const DrivePoses& frames, const Floor& floor, const FloorCells& cells,
                               const cv::Mat& rooms) {
  const cv::Mat nearest = nearestRooms(rooms, rooms.rows + rooms.cols);
  std::vector<int> result;
  auto start = frames.starts.begin();
  std::size_t begin = 0;
  const auto endDrive = [&] {
    const auto from = result.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto first = std::find_if(from, result.end(), [](int room) { return room > 0; });
    if (first != result.end()) std::fill(from, first, *first);
    begin = result.size();
  };
  int last = 0;
  for (const auto& [frame, pose] : frames.poses.entries()) {
    for (; start != frames.starts.end() && *start <= frame; ++start) {
      endDrive();
      last = 0;
    }
    if (pose && pose->isPlausible()) {
      const PlanarPose at = floor.project(*pose);
      const cv::Point cell = cells.at(at.x, at.y);
      last = nearest.at<int>(std::clamp(cell.y, 0, cells.rows() - 1),
                             std::clamp(cell.x, 0, cells.columns() - 1));
    }
    result.push_back(last);
  }
  endDrive();
  return result;
}

/// The number of each room, 1 … `rooms`: those with frames first, by falling count, of equal ones the one
/// that the robot was in first; then the others by size.
std::vector<int> areaNumbers(const std::vector<int>& roomOf, int rooms) {
  std::vector<std::size_t> frames(static_cast<std::size_t>(rooms) + 1), firsts(frames.size(), roomOf.size());
  for (std::size_t i = roomOf.size(); i-- > 0;) {
    ++frames[static_cast<std::size_t>(roomOf[i])];
    firsts[static_cast<std::size_t>(roomOf[i])] = i;
  }
  std::vector<std::size_t> order(static_cast<std::size_t>(rooms));
  std::iota(order.begin(), order.end(), 1);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return frames[a] != frames[b] ? frames[a] > frames[b] : firsts[a] < firsts[b];
  });
  std::vector<int> numbers(frames.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) numbers[order[i]] = static_cast<int>(i);
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

/// Words seen above the floor of an area and up to half a meter beyond it: walls and furniture at them.
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

void describeAreas(AreaPlan& plan, const WordMap& words, const Vocabulary& vocabulary,
                   const std::vector<float>& mean, const NamingOptions& naming) {
  constexpr double beyond = 0.5;  // [m]
  const cv::Mat nearest = nearestRooms(plan.areaOf + 1, beyond / plan.cells.cell());
  std::vector<std::vector<float>> means;
  for (Area& area : plan.areas) {
    describe(area, plan.areaOf, plan.cells);
    means.push_back(wordsOf(area.id, nearest, plan.cells, words));
  }
  const std::vector<std::string> names =
      nameZones(vocabulary, means, mean, *installedConcepts(vocabulary, naming));
  for (Area& area : plan.areas) area.name = names[static_cast<std::size_t>(area.id)];
}

/// The room of a cell, else of one beside it; 0 where there is none.
int roomAt(const cv::Mat& rooms, const cv::Point& cell) {
  const cv::Rect around = cv::Rect(cell.x - 1, cell.y - 1, 3, 3) & cv::Rect({}, rooms.size());
  if (around.contains(cell) && rooms.at<int>(cell) > 0) return rooms.at<int>(cell);
  return around.empty() ? 0 : maxOf(rooms(around));
}

bool mergeRooms(cv::Mat& rooms, const AreaEdit& edit, const FloorCells& cells) {
  const cv::Point from = cells.at(edit.from.x, edit.from.y), to = cells.at(edit.to.x, edit.to.y);
  if (!cells.holds(from) || !cells.holds(to)) return false;
  const int kept = rooms.at<int>(from), gone = rooms.at<int>(to);
  if (kept == 0 || gone == 0 || kept == gone) return false;
  rooms.setTo(kept, rooms == gone);
  return true;
}

/// The cells of a line across a room (CV_8U): from end to end, and beyond each end to where the room ends.
cv::Mat cutAcross(const cv::Mat& room, const cv::Point2d& middle, const cv::Point2d& half) {
  const auto cellOf = [](const cv::Point2d& at) {
    return cv::Point(static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)));
  };
  const auto endOf = [&](const cv::Point2d& end) {
    const cv::Point2d step = end * (0.5 / cv::norm(end));
    cv::Point2d at = middle + end;
    while (cv::Rect({}, room.size()).contains(cellOf(at)) && room.at<unsigned char>(cellOf(at)) != 0)
      at += step;
    return cellOf(at);
  };
  cv::Mat cut(room.size(), CV_8U, cv::Scalar(0));
  cv::line(cut, endOf(-half), endOf(half), cv::Scalar(255));
  return cut;
}

/// Makes the part left of the line a room of its own if the line separates it. Returns whether it does.
bool splitRoom(cv::Mat& rooms, const AreaEdit& edit, const FloorCells& cells) {
  const cv::Point2d corner = cells.centerOf({0, 0}) - cv::Point2d(cells.cell(), cells.cell()) / 2;
  const cv::Point2d middle = ((edit.from + edit.to) / 2 - corner) / cells.cell();
  cv::Point2d half = (edit.to - edit.from) / 2 / cells.cell();
  const double most = rooms.cols + rooms.rows;
  if (!(cv::norm(half) > 0) || !(cv::norm(middle) < 2 * most)) return false;
  if (cv::norm(half) > most) half *= most / cv::norm(half);
  const int room =
      roomAt(rooms, {static_cast<int>(std::floor(middle.x)), static_cast<int>(std::floor(middle.y))});
  if (room == 0) return false;
  const cv::Mat inside = rooms == room, cut = cutAcross(inside, middle, half);
  cv::Mat parts, beside;
  const int count = cv::connectedComponents(inside & ~cut, parts, 4, CV_32S);  // the line is 8-connected
  cv::dilate(cut, beside, cv::Mat::ones(3, 3, CV_8U));
  std::vector<int> leftness(static_cast<std::size_t>(count));
  const auto isLeft = [&](int column, int row) {
    return half.cross(cv::Point2d(column + 0.5, row + 0.5) - middle) > 0;
  };
  for (int row = 0; row < rooms.rows; ++row)
    for (int column = 0; column < rooms.cols; ++column)
      if (const int part = parts.at<int>(row, column); part > 0 && beside.at<unsigned char>(row, column) != 0)
        leftness[static_cast<std::size_t>(part)] += isLeft(column, row) ? 1 : -1;
  leftness[0] = 0;
  const auto [right, left] = std::ranges::minmax(leftness);
  if (left <= 0 || right >= 0) return false;
  std::transform(rooms.begin<int>(), rooms.end<int>(), parts.begin<int>(), rooms.begin<int>(),
                 [&, own = maxOf(rooms) + 1](int number, int part) {
                   return leftness[static_cast<std::size_t>(part)] > 0 ? own : number;
                 });
  return true;
}

/// Merges and splits rooms as a person did. Returns whether that changed them.
bool correct(cv::Mat& rooms, const AreaEdit& edit, const FloorCells& cells) {
  return edit.kind == AreaEdit::Kind::merge   ? mergeRooms(rooms, edit, cells)
         : edit.kind == AreaEdit::Kind::split ? splitRoom(rooms, edit, cells)
                                              : false;
}

/// Numbers rooms 1, 2 … without gaps, in their order. Returns how many there are.
int closeGaps(cv::Mat& rooms) {
  std::vector<int> number(static_cast<std::size_t>(maxOf(rooms)) + 1);
  std::for_each(rooms.begin<int>(), rooms.end<int>(),
                [&](int room) { number[static_cast<std::size_t>(room)] = 1; });
  number[0] = 0;
  std::partial_sum(number.begin(), number.end(), number.begin());
  std::for_each(rooms.begin<int>(), rooms.end<int>(),
                [&](int& room) { room = room == 0 ? 0 : number[static_cast<std::size_t>(room)]; });
  return number.back();
}

/// The plan of these rooms, whose numbers may have gaps. `rooms` > 0 somewhere.
PlannedFrames planOfRooms(cv::Mat rooms, const cv::Mat& walls, const Floor& floor, const FloorCells& cells,
                          const DrivePoses& frames, const WordMap& words, const Vocabulary& vocabulary,
                          const std::vector<float>& mean, const NamingOptions& naming) {
  const int count = closeGaps(rooms);
  const std::vector<int> roomOf = roomsOfFrames(frames, floor, cells, rooms);
  const std::vector<int> number = areaNumbers(roomOf, count);
  PlannedFrames planned{
      {std::vector<Area>(static_cast<std::size_t>(count)), floor, cells, {}, walls}, {}, {}};
  AreaPlan& plan = planned.plan;
  plan.areaOf = cv::Mat(rooms.size(), CV_32S);
  std::transform(rooms.begin<int>(), rooms.end<int>(), plan.areaOf.begin<int>(),
                 [&](int room) { return number[static_cast<std::size_t>(room)]; });
  for (std::size_t i = 0; i < plan.areas.size(); ++i) plan.areas[i].id = static_cast<int>(i);
  for (const auto& entry : frames.poses.entries()) planned.frames.push_back(entry.frame);
  for (const int room : roomOf) {
    planned.areaOfFrame.push_back(number[static_cast<std::size_t>(room)]);
    if (planned.areaOfFrame.back() < 0) continue;
    ++plan.areas[static_cast<std::size_t>(planned.areaOfFrame.back())].frames;
  }
  describeAreas(plan, words, vocabulary, mean, naming);
  return planned;
}

constexpr double sameFloor = std::numbers::pi / 180;  // directions of up that differ by less [rad]

/// Cells that an area has in common with one of before.
GroupOverlap overlapOf(const AreaPlan& now, const AreaPlan& before) {
  GroupOverlap overlap;
  const cv::Rect common = now.cells.extent() & before.cells.extent();
  for (int y = common.y; y < common.y + common.height; ++y)
    for (int x = common.x; x < common.x + common.width; ++x) {
      const int area = now.areaOf.at<int>(y - now.cells.extent().y, x - now.cells.extent().x);
      const int known = before.areaOf.at<int>(y - before.cells.extent().y, x - before.cells.extent().x);
      if (area >= 0 && known >= 0)
        ++overlap[{static_cast<std::size_t>(area), static_cast<std::size_t>(known)}];
    }
  return overlap;
}

}  // namespace

cv::Point FloorCells::at(double x, double y) const {
  return {cellOf(x, cell_) - extent_.x, cellOf(y, cell_) - extent_.y};
}

cv::Point2d FloorCells::centerOf(cv::Point cell) const {
  return {(cell.x + extent_.x + 0.5) * cell_, (cell.y + extent_.y + 0.5) * cell_};
}

cv::Vec4i FloorCells::cover(double x, double y, double radius) {
  const double limit = 1e8 * cell_;  // cells are counted by int
  if (!(std::abs(x) + radius < limit && std::abs(y) + radius < limit))
    fail(ErrorCode::tooLarge, "a view at ({:.0f}, {:.0f}) m is too far from the origin; check the poses", x,
         y);
  const cv::Point from(cellOf(x - radius, cell_), cellOf(y - radius, cell_));
  const cv::Point to(cellOf(x + radius, cell_) + 1, cellOf(y + radius, cell_) + 1);
  const cv::Rect wanted = extent_.empty() ? cv::Rect(from, to) : extent_ | cv::Rect(from, to);
  if (static_cast<double>(wanted.width) * wanted.height > maxCells)
    fail(
        ErrorCode::tooLarge,
        "the views span {:.0f} × {:.0f} m, more than a grid of cells of {} m holds; check the poses, or give "
        "larger cells",
        wanted.width * cell_, wanted.height * cell_, cell_);
  const cv::Vec4i border(extent_.x - wanted.x, extent_.y - wanted.y, wanted.br().x - extent_.br().x,
                         wanted.br().y - extent_.br().y);
  const bool first = extent_.empty();
  extent_ = wanted;
  return first ? cv::Vec4i(0, 0, wanted.width, wanted.height) : border;
}

PlannedFrames planAreas(const FloorSurvey& survey, const DrivePoses& frames, const Vocabulary& vocabulary,
                        const std::vector<float>& mean, const RoomSegmentationOptions& options,
                        std::span<const AreaEdit> edits, const NamingOptions& naming) {
  const FloorCells& cells = survey.grid.cells();
  const cv::Mat walls = survey.grid.walls();
  cv::Mat rooms = segmentRooms(survey.grid.freeSpace(), walls, cells.cell(), options);
  for (const AreaEdit& edit : edits) correct(rooms, edit, cells);
  if (cv::countNonZero(rooms) == 0)
    fail(ErrorCode::insufficientData, "no room of {} m² was seen", options.minArea);
  return planOfRooms(rooms, walls, survey.grid.floor(), cells, frames, survey.words, vocabulary, mean,
                     naming);
}

std::optional<PlannedFrames> correctPlan(const AreaPlan& plan, const AreaEdit& edit, const DrivePoses& frames,
                                         const WordMap& words, const Vocabulary& vocabulary,
                                         const std::vector<float>& mean, const NamingOptions& naming) {
  cv::Mat rooms = plan.areaOf + 1;
  if (!correct(rooms, edit, plan.cells)) return std::nullopt;
  return planOfRooms(rooms, plan.walls, plan.floor, plan.cells, frames, words, vocabulary, mean, naming);
}

void keepNumbers(PlannedFrames& planned, const AreaPlan& before) {
  AreaPlan& plan = planned.plan;
  const double turn = std::acos(std::clamp(plan.floor.up().dot(before.floor.up()), -1.0, 1.0));
  if (plan.cells.cell() != before.cells.cell() || !(turn < sameFloor)) return;
  const std::vector<std::size_t> numbers = keptNumbers(plan.areas.size(), overlapOf(plan, before));
  std::vector<Area> areas(plan.areas.size());
  for (std::size_t i = 0; i < plan.areas.size(); ++i) {
    areas[numbers[i]] = std::move(plan.areas[i]);
    areas[numbers[i]].id = static_cast<int>(numbers[i]);
  }
  plan.areas = std::move(areas);
  const auto renumber = [&numbers](int& area) {
    if (area >= 0) area = static_cast<int>(numbers[static_cast<std::size_t>(area)]);
  };
  plan.areaOf.forEach<int>([&](int& area, const int*) { renumber(area); });
  std::ranges::for_each(planned.areaOfFrame, renumber);
}

int areaAt(const AreaPlan& plan, const cv::Point2d& at, double reach) {
  const int cells = static_cast<int>(std::ceil(reach / plan.cells.cell()));
  const cv::Point middle = plan.cells.at(at.x, at.y);
  const cv::Rect window = cv::Rect(middle.x - cells, middle.y - cells, 2 * cells + 1, 2 * cells + 1) &
                          cv::Rect(0, 0, plan.areaOf.cols, plan.areaOf.rows);
  int nearest = -1;
  double least = reach * reach / (plan.cells.cell() * plan.cells.cell());
  for (int row = window.y; row < window.br().y; ++row)
    for (int column = window.x; column < window.br().x; ++column) {
      const int area = plan.areaOf.at<int>(row, column);
      const cv::Point apart = cv::Point(column, row) - middle;
      if (const double d = apart.dot(apart); area >= 0 && (d < least || (nearest < 0 && d <= least))) {
        least = d;
        nearest = area;
      }
    }
  return nearest;
}

int areaOfObject(const AreaPlan& plan, const cv::Point3d& at) {
  constexpr double reach = 2;  // [m]
  return areaAt(plan, plan.floor.position({at.x, at.y, at.z}), reach);
}

}  // namespace estancia
