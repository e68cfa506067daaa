// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/driven_way.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>

#include "estancia/topology/places.hpp"

namespace estancia {
namespace {

/// Frames of one place that are this near to each other are one station [m]: a graph of any drive stays
/// small.
constexpr double stationWidth = 0.15;
/// The robot came by again where it is this near to where it was [m].
constexpr double crossing = 0.4;
/// What a meter outside of the route's places costs.
constexpr double outsideFactor = 2;

using StationCell = std::array<long, 2>;

StationCell stationCellOf(const cv::Point2d& at, double width) {
  return {std::lround(std::floor(at.x / width)), std::lround(std::floor(at.y / width))};
}

double lengthOf(const cv::Point2d& a, const cv::Point2d& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
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

DrivenWays::DrivenWays(const WorldMap& world, const RouteOptions& options, std::vector<double> factors)
    : world_(world), bidirectional_(options.bidirectional), factors_(std::move(factors)) {
  factors_.resize(world.places.nodes.size(), 1);
  const Floor floor = floorOf(world);
  for (const MappedFrame& frame : world.places.frames) {
    positions_.emplace_back();
    if (frame.pose && frame.pose->isPlausible() &&
        indexOf(world.places, frame.node) < world.places.nodes.size())
      positions_.back() = floor.position({frame.pose->x, frame.pose->y, frame.pose->z});
  }
  addStations();
  linkNeighbors();
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
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (!positions_[i]) continue;
    const std::size_t node = indexOf(map, map.frames[i].node);
    std::size_t station = stations_.size();
    visitAround(cells, *positions_[i], stationWidth, [&](std::size_t other) {
      if (stations_[other].node == node && lengthOf(stations_[other].at, *positions_[i]) < stationWidth)
        station = std::min(station, other);
    });
    if (station == stations_.size()) {
      stations_.push_back({*positions_[i], node});
      cells[stationCellOf(*positions_[i], stationWidth)].push_back(station);
    }
    stationOf_[i] = station;
    // Where a drive was continued the robot was carried: there is no transition.
    if (last && *last != station &&
        (stations_[*last].node == node ||
         driven.contains({map.nodes[stations_[*last].node].id, map.nodes[node].id}))) {
      stations_[*last].next.push_back(station);
      if (bidirectional_) stations_[station].next.push_back(*last);
    }
    last = station;
  }
}

void DrivenWays::linkNeighbors() {
  std::map<StationCell, std::vector<std::size_t>> cells;
  for (std::size_t i = 0; i < stations_.size(); ++i)
    cells[stationCellOf(stations_[i].at, crossing)].push_back(i);
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    Station& station = stations_[i];
    visitAround(cells, station.at, crossing, [&](std::size_t other) {
      if (other != i && lengthOf(stations_[other].at, station.at) < crossing &&
          !hasWallBetween(station.at, stations_[other].at))
        station.next.push_back(other);
    });
    std::ranges::sort(station.next);
    const auto repeated = std::ranges::unique(station.next);
    station.next.erase(repeated.begin(), repeated.end());
  }
}

bool DrivenWays::hasWallBetween(const cv::Point2d& from, const cv::Point2d& to) const {
  if (!world_.plan) return false;
  const FloorCells& cells = world_.plan->cells;
  const double steps = std::ceil(2 * lengthOf(from, to) / cells.cell());
  for (double i = 0; i <= steps; ++i) {
    const cv::Point2d point = from + (to - from) * (steps > 0 ? i / steps : 0);
    const cv::Point cell = cells.at(point.x, point.y);
    if (cells.holds(cell) && world_.plan->walls.at<unsigned char>(cell) != 0) return true;
  }
  return false;
}

std::optional<std::size_t> DrivenWays::middleOf(int node) const {
  cv::Point2d sum;
  double count = 0;
  const auto visit = [&](const auto& take) {
    for (std::size_t i = 0; i < positions_.size(); ++i)
      if (positions_[i] && world_.places.frames[i].node == node) take(i, *positions_[i]);
  };
  visit([&](std::size_t, const cv::Point2d& at) { sum += at, ++count; });
  std::optional<std::size_t> nearest;
  visit([&](std::size_t i, const cv::Point2d& at) {
    if (!nearest || lengthOf(at, sum / count) < lengthOf(*positions_[*nearest], sum / count)) nearest = i;
  });
  return nearest;
}

std::vector<std::size_t> DrivenWays::waysFrom(std::size_t start, const Route& route) const {
  std::vector<double> factors = factors_;
  for (std::size_t i = 0; i < factors.size(); ++i)
    if (std::ranges::find(route.nodes, world_.places.nodes[i].id) == route.nodes.end())
      factors[i] *= outsideFactor;
  std::vector<std::size_t> before(stations_.size());
  for (std::size_t i = 0; i < before.size(); ++i) before[i] = i;
  std::vector<double> costs(stations_.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  costs[start] = 0;
  open.emplace(0, start);
  while (!open.empty()) {
    const auto [cost, station] = open.top();
    open.pop();
    if (cost > costs[station]) continue;
    const Station& here = stations_[station];
    for (const std::size_t next : here.next) {
      const double factor = (factors[here.node] + factors[stations_[next].node]) / 2;
      const double there = cost + factor * lengthOf(here.at, stations_[next].at);
      if (!(there < costs[next])) continue;
      costs[next] = there;
      before[next] = station;
      open.emplace(there, next);
    }
  }
  return before;
}

std::optional<DrivenWay> DrivenWays::along(const Route& route, std::size_t frame) const {
  const auto start = middleOf(route.nodes.front());
  if (!start || !positions_.at(frame)) return std::nullopt;
  const std::size_t first = stationOf_[*start];
  const std::vector<std::size_t> before = waysFrom(first, route);
  DrivenWay way;
  way.points.push_back(*positions_[frame]);
  for (std::size_t at = stationOf_[frame]; at != first; at = before[at]) {
    if (before[at] == at) return std::nullopt;
    way.points.push_back(stations_[at].at);
  }
  way.points.push_back(*positions_[*start]);
  std::ranges::reverse(way.points);
  const auto repeated = std::ranges::unique(way.points);
  way.points.erase(repeated.begin(), repeated.end());
  for (std::size_t i = 1; i < way.points.size(); ++i)
    way.length += lengthOf(way.points[i - 1], way.points[i]);
  return way;
}

std::optional<DrivenWay> DrivenWays::along(const Route& route) const {
  const auto goal = middleOf(route.nodes.back());
  return goal ? along(route, *goal) : std::nullopt;
}

}  // namespace estancia
