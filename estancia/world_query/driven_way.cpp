// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/driven_way.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <queue>
#include <set>

#include "estancia/map_file/places.hpp"

namespace estancia {
namespace {

/// Frames of one place this near to each other are one station [m]: a graph of any drive stays small.
constexpr double stationWidth = 0.15;
/// The robot came by again where it is this near to where it was [m].
constexpr double crossing = 0.4;
/// Another floor is farther up [m].
constexpr double sameHeight = 0.5;
/// Cost of changing to another place [m]: of equally long ways the one through fewer places is chosen.
constexpr double changeOfPlace = 0.3;

using StationCell = std::array<long, 2>;

StationCell stationCellOf(const cv::Point2d& at, double width) {
  return {std::lround(std::floor(at.x / width)), std::lround(std::floor(at.y / width))};
}

double lengthOf(const cv::Point2d& a, const cv::Point2d& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

bool isWallAt(const AreaPlan& plan, const cv::Point2d& point) {
  const cv::Point cell = plan.cells.at(point.x, point.y);
  return plan.cells.holds(cell) && plan.walls.at<unsigned char>(cell) != 0;
}

/// Calls `visit` with the stations in the nine cells around a point.
template <class Cells, class Visit>
void visitAround(const Cells& cells, const cv::Point2d& at, double width, const Visit& visit) {
  const StationCell middle = stationCellOf(at, width);
  for (long x = -1; x <= 1; ++x)
    for (long y = -1; y <= 1; ++y)
      if (const auto found = cells.find({middle[0] + x, middle[1] + y}); found != cells.end())
        for (const std::size_t station : found->second) visit(station);
}

}  // namespace

DrivenWays::DrivenWays(const WorldMap& world, int from, const RouteOptions& options, const RegionCosts& costs)
    : world_(world),
      bidirectional_(options.bidirectional),
      regions_(costs),
      framesOf_(world.places.nodes.size()) {
  world.places.getNode(from);
  const Floor floor = floorOf(world);
  for (const MappedFrame& frame : world.places.frames) {
    positions_.emplace_back();
    heights_.push_back(0);
    const std::size_t place = indexOf(world.places, frame.node);
    if (!frame.pose || !frame.pose->isPlausible() || place == framesOf_.size()) continue;
    const cv::Vec3d at(frame.pose->x, frame.pose->y, frame.pose->z);
    framesOf_[place].push_back(positions_.size() - 1);
    positions_.back() = floor.position(at);
    heights_.back() = floor.up().dot(at);
  }
  addStations();
  linkNeighbors();
  startFrame_ = middleOf(from);
  costs_.assign(stations_.size(), std::numeric_limits<double>::infinity());
  if (startFrame_) findWays(stationOf_[*startFrame_]);
}

void DrivenWays::addStations() {
  const TopologicalMap& map = world_.places;
  std::set<std::pair<int, int>> driven;
  for (const Transition& transition : map.transitions) {
    driven.emplace(transition.from, transition.to);
    if (bidirectional_) driven.emplace(transition.to, transition.from);
  }
  std::map<StationCell, std::vector<std::size_t>> cells;
  stationOf_.resize(positions_.size());
  constexpr auto nowhere = std::numeric_limits<std::size_t>::max();
  std::size_t last = nowhere;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (map.beginsDrive(i)) last = nowhere;  // the robot was carried
    if (!positions_[i]) continue;
    const Station here{*positions_[i], heights_[i], indexOf(map, map.frames[i].node),
                       i < world_.areaOfFrame.size() ? world_.areaOfFrame[i] : -1};
    std::size_t station = stations_.size();
    visitAround(cells, here.at, stationWidth, [&](std::size_t other) {
      if (stations_[other].place == here.place && stations_[other].area == here.area &&
          std::abs(stations_[other].height - here.height) < sameHeight &&
          lengthOf(stations_[other].at, here.at) < stationWidth)
        station = std::min(station, other);
    });
    if (station == stations_.size()) {
      stations_.push_back(here);
      cells[stationCellOf(here.at, stationWidth)].push_back(station);
    }
    stationOf_[i] = station;
    // Maps of older programs do not record where a drive was continued: there is no transition.
    if (last != nowhere && last != station &&
        (stations_[last].place == here.place ||
         driven.contains({map.nodes[stations_[last].place].id, map.nodes[here.place].id})) &&
        (!map.isThinned() || !hasWallBetween(stations_[last].at, here.at)))  // it went around corners
      drive(last, station);
    last = station;
  }
}

void DrivenWays::drive(std::size_t from, std::size_t to) {
  stations_[from].next.push_back(to);
  if (bidirectional_) stations_[to].next.push_back(from);
  const cv::Point2d heading = stations_[to].at - stations_[from].at;
  stations_[from].headings.push_back(heading);
  stations_[to].headings.push_back(heading);
}

void DrivenWays::linkNeighbors() {
  std::map<StationCell, std::vector<std::size_t>> cells;
  for (std::size_t i = 0; i < stations_.size(); ++i)
    cells[stationCellOf(stations_[i].at, crossing)].push_back(i);
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    Station& station = stations_[i];
    visitAround(cells, station.at, crossing, [&](std::size_t other) {
      if (other != i && mayCross(station, stations_[other])) station.next.push_back(other);
    });
    std::ranges::sort(station.next);
    station.next.erase(std::unique(station.next.begin(), station.next.end()), station.next.end());
  }
}

bool DrivenWays::mayCross(const Station& from, const Station& to) const {
  const cv::Point2d step = to.at - from.at;
  // Many small steps across must not lead back along a lane.
  const bool isForward = bidirectional_ || std::ranges::any_of(from.headings, [&step](const auto& heading) {
                           return heading.dot(step) >= 0;
                         });
  return isForward && lengthOf(from.at, to.at) < crossing && std::abs(from.height - to.height) < sameHeight &&
         !hasWallBetween(from.at, to.at);
}

bool DrivenWays::hasWallBetween(const cv::Point2d& from, const cv::Point2d& to) const {
  if (!world_.plan) return false;
  const double steps = std::ceil(2 * lengthOf(from, to) / world_.plan->cells.cell());
  for (double i = 0; i <= steps; ++i)
    if (isWallAt(*world_.plan, from + (to - from) * (steps > 0 ? i / steps : 0))) return true;
  return false;
}

std::optional<std::size_t> DrivenWays::middleOf(int node, const std::vector<int>& areas) const {
  std::vector<std::size_t> frames = framesOf_[indexOf(world_.places, node)];
  if (!areas.empty())
    std::erase_if(frames, [&](std::size_t frame) {
      return std::ranges::find(areas, world_.areaOfFrame[frame]) == areas.end();
    });
  if (frames.empty()) return std::nullopt;
  const cv::Point2d sum = std::accumulate(frames.begin(), frames.end(), cv::Point2d(),
                                          [this](auto at, auto frame) { return at + *positions_[frame]; });
  return *std::ranges::min_element(frames, {}, [&](std::size_t frame) {
    return lengthOf(*positions_[frame], sum / static_cast<double>(frames.size()));
  });
}

template <class Visit>
void DrivenWays::visitPieces(const Station& from, const Station& to, const Visit& visit) const {
  const double length = lengthOf(from.at, to.at);
  const double width = world_.plan ? world_.plan->cells.cell() : length;
  const double steps = std::max(2.0, 2 * std::ceil(length / width / 2));  // half of them nearer to each end
  for (double i = 0; i < steps; ++i) {
    const double part = (i + 0.5) / steps;
    const Station& nearer = part < 0.5 ? from : to;
    // Not all of the floor between frames was seen to be free.
    int area = world_.plan ? areaAt(*world_.plan, from.at + (to.at - from.at) * part, 0) : -1;
    if (area < 0) area = nearer.area;
    visit(WayPiece{nearer.place, area, length / steps});
  }
}

double DrivenWays::costBetween(const Station& from, const Station& to) const {
  double cost = from.place == to.place ? 0 : changeOfPlace;
  visitPieces(from, to,
              [&](const WayPiece& piece) { cost += piece.length * regions_.at(piece.place, piece.area); });
  return cost;
}

void DrivenWays::findWays(std::size_t start) {
  before_.resize(stations_.size());
  std::iota(before_.begin(), before_.end(), 0);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  costs_[start] = 0;
  open.emplace(0, start);
  while (!open.empty()) {
    const auto [cost, station] = open.top();
    open.pop();
    if (cost > costs_[station]) continue;
    for (const std::size_t next : stations_[station].next) {
      const double there = cost + costBetween(stations_[station], stations_[next]);
      if (!(there < costs_[next])) continue;
      costs_[next] = there;
      before_[next] = station;
      open.emplace(there, next);
    }
  }
}

double DrivenWays::costTo(std::size_t frame) const {
  return positions_.at(frame) ? costs_[stationOf_[frame]] : std::numeric_limits<double>::infinity();
}

std::optional<DrivenWay> DrivenWays::wayTo(std::size_t frame) const {
  if (!(costTo(frame) < std::numeric_limits<double>::infinity())) return std::nullopt;
  // From frame to frame: these are up to a station's width off it.
  std::vector<Station> way{stations_[stationOf_[frame]]};
  way.back().at = *positions_[frame];
  for (std::size_t at = stationOf_[frame]; before_[at] != at; at = before_[at])
    way.push_back(stations_[before_[at]]);
  way.push_back(way.back());
  way.back().at = *positions_[*startFrame_];
  std::ranges::reverse(way);
  DrivenWay driven{{way.front().at}, 0, {{way.front().place, way.front().area}}};
  for (std::size_t i = 1; i < way.size(); ++i) {
    if (way[i].at == way[i - 1].at) continue;
    driven.points.push_back(way[i].at);
    driven.length += lengthOf(way[i - 1].at, way[i].at);
    visitPieces(way[i - 1], way[i], [&](const WayPiece& piece) {
      WayPiece& last = driven.pieces.back();
      if (last.place == piece.place && last.area == piece.area)
        last.length += piece.length;
      else
        driven.pieces.push_back(piece);
    });
  }
  return driven;
}

namespace {

/// Between where the camera looks and the object's middle [rad].
double angleTo(const WorldObject& object, const Pose& pose) {
  const auto forward = pose.forward();
  const cv::Point3d look(forward[0], forward[1], forward[2]);
  const cv::Point3d ray = object.center - cv::Point3d(pose.x, pose.y, pose.z);
  const double length = std::sqrt(ray.dot(ray));
  return length > 0 ? std::acos(std::clamp(ray.dot(look) / length, -1.0, 1.0)) : 0;
}

}  // namespace

ViewPoses::ViewPoses(const WorldMap& world, double viewAngle)
    : world_(world), viewAngle_(viewAngle * std::numbers::pi / 180), floor_(floorOf(world)) {}

std::optional<ViewPose> ViewPoses::poseAt(std::size_t frame, const WorldObject& object) const {
  const std::optional<Pose>& pose = world_.places.frames[frame].pose;
  if (!pose) return std::nullopt;
  const cv::Point2d from = floor_.position({pose->x, pose->y, pose->z});
  const cv::Point2d ray = floor_.position(object.center) - from;
  const double distance = std::hypot(ray.x, ray.y);
  // Where the robot stood in it nothing can be faced.
  if (!(distance > 0)) return std::nullopt;
  return ViewPose{from.x, from.y, std::atan2(ray.y, ray.x), frame, distance};
}

bool ViewPoses::wallBetween(const cv::Point2d& from, const WorldObject& object) const {
  if (!world_.plan) return false;
  const FloorCells& cells = world_.plan->cells;
  const cv::Point2d to = floor_.position(object.center);
  const cv::Point2d ray = to - from;
  const double length = std::hypot(ray.x, ray.y), c = std::cos(object.yaw), s = std::sin(object.yaw);
  // An object on a wall lies in its cells, or beside them; only there, as behind it is the wall's other side.
  const cv::Point2d half(object.size.x / 2 + cells.cell(), object.size.y / 2 + cells.cell());
  for (double at = 0; at < length; at += cells.cell() / 2) {
    const cv::Point2d point = from + ray * (at / length), off = point - to;
    if (std::abs(c * off.x + s * off.y) <= half.x && std::abs(c * off.y - s * off.x) <= half.y) return false;
    if (isWallAt(*world_.plan, point)) return true;
  }
  return false;
}

std::optional<ViewPose> ViewPoses::find(const WorldObject& object,
                                        const std::function<bool(std::size_t frame)>& mayUse) const {
  const double fits =
      std::max(std::hypot(object.size.x, object.size.y) / 2, object.size.z / 2) / std::tan(viewAngle_);
  std::optional<ViewPose> whole, middle;
  const auto isNearer = [](const ViewPose& pose, const std::optional<ViewPose>& than) {
    return !than || pose.distance < than->distance;
  };
  for (std::size_t i = 0; i < world_.places.frames.size(); ++i) {
    const std::optional<ViewPose> pose = poseAt(i, object);
    if (!pose || (!isNearer(*pose, whole) && !isNearer(*pose, middle))) continue;
    if (angleTo(object, *world_.places.frames[i].pose) > viewAngle_ || !mayUse(i)) continue;
    if (wallBetween({pose->x, pose->y}, object)) continue;
    if (pose->distance >= fits && isNearer(*pose, whole)) whole = pose;
    if (isNearer(*pose, middle)) middle = pose;
  }
  if (whole) return whole;
  const std::optional<ViewPose> best = poseAt(object.bestFrame, object);
  return best && mayUse(object.bestFrame) ? best : middle;
}

}  // namespace estancia
