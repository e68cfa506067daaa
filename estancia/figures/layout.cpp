// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/layout.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/core.hpp>

// Boost.Graph hides an iterator pair in an optional, which GCC 12 takes for uninitialized memory.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpragmas"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/circle_layout.hpp>
#include <boost/graph/connected_components.hpp>
#include <boost/graph/kamada_kawai_spring_layout.hpp>
#include <boost/graph/topology.hpp>
#pragma GCC diagnostic pop

namespace estancia::report {
namespace {

/// Ends Kamada–Kawai when it has converged or, in large graphs or should it circle, after so many moves (each
/// costs time in proportion to the number of vertices).
class Convergence {
 public:
  explicit Convergence(std::size_t moves) : left_(moves) {}

  template <typename Graph, typename Vertex>
  bool operator()(double delta, Vertex vertex, const Graph& graph, bool global) {
    if (left_ == 0) return true;
    --left_;
    return tolerance_(delta, vertex, graph, global);
  }

 private:
  std::size_t left_;
  boost::layout_tolerance<double> tolerance_{1e-3};
};

/// The mean of the members that have a position.
std::optional<Point> meanOf(const std::vector<std::size_t>& members,
                            const std::vector<std::optional<Point>>& positions) {
  Point sum;
  double count = 0;
  for (const std::size_t member : members)
    if (const auto& at = positions[member]) {
      sum = {sum.x + at->x, sum.y + at->y};
      ++count;
    }
  return count == 0 ? std::nullopt : std::optional(Point{sum.x / count, sum.y / count});
}

/// Positions of nodes without a pose: the mean of their neighbors', spreading out from those that have one.
void fillGaps(const std::vector<Link>& links, std::vector<std::optional<Point>>& nodes) {
  std::vector<std::vector<std::size_t>> neighbors(nodes.size());
  for (const Link& link : links) {
    neighbors[link.a].push_back(link.b);
    neighbors[link.b].push_back(link.a);
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (!nodes[i] && (nodes[i] = meanOf(neighbors[i], nodes))) changed = true;
  }
  std::vector<std::size_t> all(nodes.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const Point center = meanOf(all, nodes).value_or(Point{});
  for (auto& node : nodes)
    if (!node) node = center;
}

}  // namespace

std::vector<Point> layoutGraph(std::size_t vertices, const std::vector<Link>& edges) {
  using Weight = boost::property<boost::edge_weight_t, double>;
  using Graph =
      boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS, boost::no_property, Weight>;
  std::vector<Point> points(vertices);
  if (vertices < 2) return points;

  Graph graph(vertices);
  for (const Link& edge : edges) boost::add_edge(edge.a, edge.b, Weight(1), graph);
  // Kamada–Kawai needs a connected graph: tie the parts together, at some distance.
  std::vector<std::size_t> part(vertices);
  const auto parts = static_cast<std::size_t>(boost::connected_components(graph, part.data()));
  std::vector<std::size_t> firstOf(parts, vertices);
  for (std::size_t v = 0; v < vertices; ++v) firstOf[part[v]] = std::min(firstOf[part[v]], v);
  for (std::size_t p = 1; p < parts; ++p) boost::add_edge(firstOf[p - 1], firstOf[p], Weight(2), graph);

  using Plane2 = boost::square_topology<>;
  std::vector<Plane2::point_type> places(vertices);
  const auto position =
      boost::make_iterator_property_map(places.begin(), boost::get(boost::vertex_index, graph));
  const auto count = static_cast<double>(vertices);
  boost::circle_graph_layout(graph, position, count / (2 * std::numbers::pi));  // in driven order
  boost::kamada_kawai_spring_layout(graph, position, boost::get(boost::edge_weight, graph), Plane2(count),
                                    boost::edge_length(1.0), Convergence(20'000'000 / vertices));
  for (std::size_t v = 0; v < vertices; ++v)
    if (std::isfinite(places[v][0]) && std::isfinite(places[v][1])) points[v] = {places[v][0], places[v][1]};
  return points;
}

Point Fit::operator()(const Point& p) const {
  const double x = p.x - from.x, y = p.y - from.y;
  return turned ? Point{to.x + scale * y, to.y + scale * x} : Point{to.x + scale * x, to.y - scale * y};
}

Fit fitInto(const std::vector<Point>& points, const Box& box, bool mayTurn) {
  Fit fit;
  fit.to = {box.x + box.width / 2, box.y + box.height / 2};
  if (points.empty()) return fit;
  Extent extent;
  for (const Point& p : points) extent.add(p);
  const auto& [low, high] = extent;
  fit.from = {(low.x + high.x) / 2, (low.y + high.y) / 2};
  constexpr double tiny = 1e-9;
  const double width = std::max(high.x - low.x, tiny), height = std::max(high.y - low.y, tiny);
  const auto scale = [&box](double w, double h) { return std::min(box.width / w, box.height / h); };
  fit.turned = mayTurn && scale(height, width) > scale(width, height);
  fit.scale = fit.turned ? scale(height, width) : scale(width, height);
  if (std::max(width, height) <= tiny) fit.scale = 0;  // one place only
  return fit;
}

void separate(std::vector<Point>& centers, const std::vector<double>& radii, double gap, const Box& box) {
  for (int round = 0; round < 200; ++round) {
    bool moved = false;
    for (std::size_t i = 0; i < centers.size(); ++i)
      for (std::size_t j = i + 1; j < centers.size(); ++j) {
        Point& a = centers[i];
        Point& b = centers[j];
        const double wanted = radii[i] + radii[j] + gap;
        double dx = b.x - a.x, dy = b.y - a.y;
        if (dx * dx + dy * dy >= wanted * wanted) continue;  // most pairs: no root for them
        double distance = std::hypot(dx, dy);
        if (distance < 1e-6) {  // the golden angle: no two pairs part in the same direction
          const double angle = 2.399963 * static_cast<double>(i + j + 1);
          dx = std::cos(angle);
          dy = std::sin(angle);
          distance = 1;
          b = {b.x + 1e-3 * dx, b.y + 1e-3 * dy};
        }
        const double push = 0.505 * std::max(wanted - std::hypot(b.x - a.x, b.y - a.y), 0.0) / distance;
        a = {a.x - push * dx, a.y - push * dy};
        b = {b.x + push * dx, b.y + push * dy};
        moved = true;
      }
    for (std::size_t i = 0; i < centers.size(); ++i) {
      const double r = radii[i];
      centers[i].x = std::clamp(centers[i].x, box.x + r, std::max(box.x + r, box.x + box.width - r));
      centers[i].y = std::clamp(centers[i].y, box.y + r, std::max(box.y + r, box.y + box.height - r));
    }
    if (!moved) break;
  }
}

MapLayout layoutMap(const MapSummary& summary, bool fromAbove) {
  std::vector<std::optional<Pose>> poses;
  for (const MappedFrame& frame : summary.map->frames) poses.push_back(frame.pose);
  const DrivenPath path = projectPath(poses, fromAbove);

  MapLayout layout;
  layout.metric = !path.empty;
  if (!layout.metric) {
    layout.nodes = layoutGraph(summary.nodes.size(), summary.links);
    return layout;
  }
  layout.frames = path.points;
  for (const Drive& drive : summary.map->drives) layout.driveStarts.push_back(drive.firstFrame);

  std::vector<std::optional<Point>> nodes;
  for (const NodeSummary& node : summary.nodes) nodes.push_back(meanOf(node.frames, layout.frames));
  fillGaps(summary.links, nodes);
  for (const auto& node : nodes) layout.nodes.push_back(*node);
  return layout;
}

namespace {

cv::Vec3d positionOf(const Pose& pose) {
  return {pose.x, pose.y, pose.z};
}

cv::Matx33d covariance(const std::vector<cv::Vec3d>& positions) {
  cv::Vec3d mean;
  for (const cv::Vec3d& p : positions)
    for (int i = 0; i < 3; ++i) mean[i] += p[i] / static_cast<double>(positions.size());
  cv::Matx33d sum = cv::Matx33d::zeros();
  for (const cv::Vec3d& p : positions)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) sum(i, j) += (p[i] - mean[i]) * (p[j] - mean[j]);
  return sum;
}

}  // namespace

Point GroundPlane::project(const cv::Vec3d& position) const {
  return {position.dot(right), position.dot(up)};
}

GroundPlane planeOf(const std::vector<cv::Vec3d>& positions) {
  if (positions.empty()) return {};
  const cv::Matx33d spread = covariance(positions);
  const std::array<double, 3> variance{spread(0, 0), spread(1, 1), spread(2, 2)};
  std::array<double, 3> sorted = variance;
  std::ranges::sort(sorted);
  // "clearly least": half the standard deviation of the next axis, or nothing to choose between at all
  if (sorted[0] <= 0.25 * sorted[1] || sorted[1] == 0) {
    if (variance[2] == sorted[0]) return {};
    if (variance[1] == sorted[0]) return {{1, 0, 0}, {0, 0, 1}};
    return {{0, 1, 0}, {0, 0, 1}};
  }
  cv::Mat values, vectors;  // rows of eigenvectors, largest first
  cv::eigen(cv::Mat(spread), values, vectors);
  const auto axis = [&vectors](int row) {
    return cv::Vec3d(vectors.at<double>(row, 0), vectors.at<double>(row, 1), vectors.at<double>(row, 2));
  };
  // The signs of eigenvectors are arbitrary: right points along its largest component, and the viewer is
  // above the plane (+z; −y in a camera's frame) so that the map is not mirrored.
  cv::Vec3d right = axis(0), normal = axis(2);
  const auto largest = [](const cv::Vec3d& v) {
    return *std::ranges::max_element(v.val, {}, [](double value) { return std::abs(value); });
  };
  if (largest(right) < 0) right = -right;
  const double height = largest(normal) == normal[1] ? -normal[1] : largest(normal);
  if (height < 0) normal = -normal;
  return {right, normal.cross(right)};
}

DrivenPath projectPath(std::span<const std::optional<Pose>> poses, bool fromAbove) {
  std::vector<cv::Vec3d> positions;
  for (const auto& pose : poses)
    if (pose && pose->isPlausible()) positions.push_back(positionOf(*pose));
  DrivenPath path;
  path.empty = positions.empty();
  if (path.empty) return path;
  if (!fromAbove) path.plane = planeOf(positions);
  path.points.resize(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (poses[i] && poses[i]->isPlausible()) path.points[i] = path.plane.project(positionOf(*poses[i]));
  return path;
}

LabelPlaces::LabelPlaces(double width, double height, const std::vector<Point>& centers,
                         const std::vector<double>& radii,
                         std::vector<std::pair<std::size_t, std::size_t>> lines)
    : frame_{4, 4, width - 8, height - 8}, centers_(centers), radii_(radii), lines_(std::move(lines)) {}

std::optional<LabelPlace> LabelPlaces::take(std::size_t disc, double width, double height) {
  constexpr std::array<std::array<int, 2>, 8> sides{
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
  const Point& center = centers_[disc];
  std::optional<LabelPlace> best;
  double bestCost = 1e9;
  for (std::size_t side = 0; side < sides.size(); ++side) {
    const auto [dx, dy] = sides[side];
    const double reach = (radii_[disc] + 4) * (dx != 0 && dy != 0 ? std::sqrt(0.5) : 1);
    const double x = center.x + dx * (reach + width / 2);
    const double y = center.y + dy * (reach + height / 2);
    const Box box{x - width / 2, y - height / 2, width, height};
    const LabelPlace place{box, dx == 0 ? center.x : x - dx * width / 2,  // text begins or ends at its disc
                           dx == 0  ? "middle"
                           : dx > 0 ? "start"
                                    : "end"};
    if (!isInside(place) || !isFree(box)) continue;
    double cost = 0.1 * static_cast<double>(side);
    for (const auto& [a, b] : lines_)
      if (box.crosses(centers_[a], centers_[b])) cost += 1;
    if (cost >= bestCost) continue;
    bestCost = cost;
    best = place;
  }
  if (best) taken_.push_back(best->box);
  return best;
}

/// Readers' fonts run up to a fourth wider than what is estimated. Where labels touch then, they can still be
/// read; what leaves the frame is lost.
bool LabelPlaces::isInside(const LabelPlace& place) const {
  Box box = place.box;
  const double more = box.width / 4;
  box.width += more;
  if (place.anchor != "start") box.x -= place.anchor == "end" ? more : more / 2;
  return box.inside(frame_);
}

bool LabelPlaces::isFree(const Box& box) const {
  for (std::size_t i = 0; i < centers_.size(); ++i)
    if (box.overlapsCircle(centers_[i], radii_[i] + 3)) return false;
  const Box withAir{box.x - 3, box.y, box.width + 6, box.height};  // words side by side would read as one
  return std::ranges::none_of(taken_, [&](const Box& other) { return other.overlaps(withAir); });
}

bool Thumbnails::isFree(const Box& box) const {
  return box.inside(frame_) &&
         std::ranges::none_of(taken_, [&box](const Box& other) { return other.overlaps(box); });
}

std::optional<Box> Thumbnails::take(const Point& at) {
  constexpr double gap = 2;
  constexpr std::array<Point, 9> sides{
      {{0, 0}, {0, -1}, {1, 0}, {-1, 0}, {0, 1}, {1, -1}, {-1, -1}, {1, 1}, {-1, 1}}};
  for (const double size : {size_, 0.72 * size_})
    for (const Point& side : sides) {
      // Beside its point the image leaves it to be seen.
      const double away = size / 2 + 6;
      const Point middle{at.x + away * side.x, at.y + away * side.y};
      const Box box{middle.x - size / 2, middle.y - size / 2, size, size};
      if (!isFree({box.x - gap, box.y - gap, size + 2 * gap, size + 2 * gap})) continue;
      taken_.push_back(box);
      return box;
    }
  return std::nullopt;
}

}  // namespace estancia::report
