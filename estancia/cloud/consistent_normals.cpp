// Consistent orientation of normals without a viewpoint.
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "estancia/cloud/disjoint_sets.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

struct NormalEdge {
  float turn;  // 1 − |cosine|
  std::uint32_t a, b;
};

/// Each point with its nearest ones, the most parallel first.
std::vector<NormalEdge> edgesByTurn(std::span<const cv::Point3f> points, const Neighbors& neighbors,
                                    const std::vector<cv::Point3f>& normals) {
  constexpr std::size_t near = 10;
  std::vector<NormalEdge> edges;
  edges.reserve(points.size() * near);
  std::vector<Neighbor> buffer;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    for (const Neighbor& n : neighbors.nearest(points[i], near + 1, buffer)) {
      const float turn = 1 - std::abs(normals[i].dot(normals[n.index]));
      if (n.index != i && std::isfinite(turn))
        edges.push_back({turn, std::min(i, n.index), std::max(i, n.index)});
    }
  }
  std::ranges::sort(edges, [](const NormalEdge& x, const NormalEdge& y) {
    return std::pair(x.turn, std::pair(x.a, x.b)) < std::pair(y.turn, std::pair(y.a, y.b));
  });
  return edges;
}

}  // namespace

void orientConsistently(std::span<const cv::Point3f> points, const Neighbors& neighbors,
                        std::vector<cv::Point3f>& normals) {
  if (normals.size() != points.size())
    fail(ErrorCode::invalidInput, "{} normals for {} points; give one a point", normals.size(),
         points.size());
  // Kruskal's tree, and the signs along it
  DisjointSets parts(points.size());
  std::vector<std::vector<std::uint32_t>> tree(points.size());
  for (const NormalEdge& edge : edgesByTurn(points, neighbors, normals)) {
    if (parts.find(edge.a) == parts.find(edge.b)) continue;
    parts.join(edge.a, edge.b);
    tree[edge.a].push_back(edge.b);
    tree[edge.b].push_back(edge.a);
  }
  std::vector<bool> reached(points.size());
  std::vector<std::uint32_t> next;
  for (std::uint32_t root = 0; root < points.size(); ++root) {
    if (reached[root]) continue;
    reached[root] = true;
    next.assign(1, root);
    while (!next.empty()) {
      const std::uint32_t i = next.back();
      next.pop_back();
      for (const std::uint32_t j : tree[i]) {
        if (reached[j]) continue;
        reached[j] = true;
        if (normals[i].dot(normals[j]) < 0) normals[j] = -normals[j];
        next.push_back(j);
      }
    }
  }
}

}  // namespace estancia
