// SPDX-License-Identifier: Apache-2.0
#include "tests/cloud/textbook_neural_gas.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::size_t block = 64;
constexpr float nowhere = 1e18F;  ///< coordinate of what fills the last block

/// Squared distances of p to a block of points, as the bits of floats (which order as the floats do), and the
/// least of them.
ESTANCIA_MULTIVERSION std::uint32_t distances(const float* __restrict x, const float* __restrict y,
                                              const float* __restrict z, Point4 p,
                                              std::uint32_t* __restrict out) {
  for (std::size_t i = 0; i < block; ++i) {
    const float dx = p.x - x[i], dy = p.y - y[i], dz = p.z - z[i];
    out[i] = std::bit_cast<std::uint32_t>((dx * dx + dy * dy) + dz * dz);
  }
  std::uint32_t least = out[0];
  for (std::size_t i = 1; i < block; ++i) least = out[i] < least ? out[i] : least;
  return least;
}

}  // namespace

TextbookNeuralGas::TextbookNeuralGas(const Signals& signals, const GngOptions& options)
    : signals_(signals), options_(options) {
  const auto& points = signals.points();
  const std::size_t a = signals.draw(t_++);
  std::size_t b = a;
  while (points[a].x == points[b].x && points[a].y == points[b].y && points[a].z == points[b].z)
    b = signals.draw(t_++);
  for (const std::size_t point : {a, b}) {
    add(points[point]);
    if (!signals.colors().empty()) colors_.push_back(signals.colors()[point]);
  }
  first_ = t_;
}

std::pair<std::array<std::uint32_t, 2>, float> TextbookNeuralGas::nearestTwo(const Point4& p) const {
  std::uint32_t d[block], best = 0xffffffff, second = 0xffffffff;
  std::array<std::uint32_t, 2> nearest{};
  for (std::size_t i = 0; i < size(); i += block) {
    if (distances(&x_[i], &y_[i], &z_[i], p, d) >= second) continue;
    for (std::size_t k = 0; k < block; ++k) {
      if (d[k] < best) {
        second = best;
        nearest[1] = nearest[0];
        best = d[k];
        nearest[0] = static_cast<std::uint32_t>(i + k);
      } else if (d[k] < second) {
        second = d[k];
        nearest[1] = static_cast<std::uint32_t>(i + k);
      }
    }
  }
  return {nearest, std::bit_cast<float>(best)};
}

std::pair<std::array<std::uint32_t, 2>, float> TextbookNeuralGas::nearestTwo(std::size_t point) const {
  const Point4& p = signals_.points()[point];
  if (colors_.empty()) return nearestTwo(p);
  constexpr float infinity = std::numeric_limits<float>::infinity();
  std::array<std::uint32_t, 2> nearest{};
  float best = infinity, second = infinity;
  for (std::uint32_t i = 0; i < size(); ++i) {
    const float d = squaredDistance(p, at(i)) + squaredDistance(signals_.colors()[point], colors_[i]);
    if (d < best) {
      second = best;
      nearest[1] = nearest[0];
      best = d;
      nearest[0] = i;
    } else if (d < second) {
      second = d;
      nearest[1] = i;
    }
  }
  return {nearest, best};
}

double TextbookNeuralGas::learn() {
  double sum = 0;
  for (std::size_t k = 0; k < options_.signalsPerInsertion; ++k) {
    const std::size_t signal = signals_.draw(t_++);
    const auto [nearest, squaredDistance] = nearestTwo(signal);
    const auto [s1, s2] = nearest;
    sum += squaredDistance;
    for (Edge& e : neighbors_[s1]) {
      ++e.age;
      for (Edge& back : neighbors_[e.neighbor])
        if (back.neighbor == s1) ++back.age;
    }
    errors_[s1] += squaredDistance;
    attract(s1, signal, options_.winnerRate);
    for (const Edge& e : neighbors_[s1]) attract(e.neighbor, signal, options_.neighborRate);
    bool connected = false;
    for (Edge& e : neighbors_[s1])
      if (e.neighbor == s2) {
        connected = true;
        e.age = 0;
        for (Edge& back : neighbors_[s2])
          if (back.neighbor == s1) back.age = 0;
      }
    if (!connected) connect(s1, s2);
    std::vector<std::uint32_t> old;
    for (const Edge& e : neighbors_[s1])
      if (e.age > options_.maxAge) old.push_back(e.neighbor);
    if (old.empty()) continue;
    for (const std::uint32_t n : old) disconnect(s1, n);
    for (std::size_t i = size(); i-- > 0;)
      if (neighbors_[i].empty()) remove(static_cast<std::uint32_t>(i));
  }
  return sum;
}

void TextbookNeuralGas::insert() {
  const auto q =
      static_cast<std::uint32_t>(std::max_element(errors_.begin(), errors_.end()) - errors_.begin());
  std::uint32_t f = neighbors_[q][0].neighbor;
  for (const Edge& e : neighbors_[q])
    if (errors_[e.neighbor] > errors_[f] || (errors_[e.neighbor] == errors_[f] && e.neighbor < f))
      f = e.neighbor;
  const auto r = static_cast<std::uint32_t>(size());
  add({0.5F * (x_[q] + x_[f]), 0.5F * (y_[q] + y_[f]), 0.5F * (z_[q] + z_[f]), 0});
  if (!colors_.empty()) {
    const Point4 c = colors_[q], d = colors_[f];
    colors_.push_back({0.5F * (c.x + d.x), 0.5F * (c.y + d.y), 0.5F * (c.z + d.z), 0});
  }
  disconnect(q, f);
  connect(q, r);
  connect(f, r);
  errors_[q] *= options_.insertionDecay;
  errors_[f] *= options_.insertionDecay;
  errors_[r] = errors_[q];
  for (double& e : errors_) e *= options_.errorDecay;
}

bool TextbookNeuralGas::grow(Progress& progress) {
  std::size_t most = size(), idle = 0;
  progress.begin("textbook", options_.neurons, most);
  while (size() < options_.neurons) {
    learn();
    insert();
    if (size() > most) {
      progress.advance(size() - most);
      most = size();
      idle = 0;
    } else if (++idle > 1000 + most) {
      return false;
    }
  }
  return true;
}

std::vector<std::pair<std::array<std::uint32_t, 2>, std::uint32_t>> TextbookNeuralGas::edges() const {
  std::vector<std::pair<std::array<std::uint32_t, 2>, std::uint32_t>> edges;
  for (std::uint32_t i = 0; i < size(); ++i)
    for (const Edge& e : neighbors_[i])
      if (i < e.neighbor) edges.push_back({{i, e.neighbor}, e.age});
  std::sort(edges.begin(), edges.end());
  return edges;
}

void TextbookNeuralGas::add(const Point4& p) {
  const std::size_t i = size();
  if (i == x_.size())
    for (std::vector<float>* v : {&x_, &y_, &z_}) v->resize(i + block, nowhere);
  x_[i] = p.x;
  y_[i] = p.y;
  z_[i] = p.z;
  errors_.push_back(0);
  neighbors_.emplace_back();
}

void TextbookNeuralGas::connect(std::uint32_t a, std::uint32_t b) {
  neighbors_[a].push_back({b, 0});
  neighbors_[b].push_back({a, 0});
}

void TextbookNeuralGas::disconnect(std::uint32_t a, std::uint32_t b) {
  std::erase_if(neighbors_[a], [b](const Edge& e) { return e.neighbor == b; });
  std::erase_if(neighbors_[b], [a](const Edge& e) { return e.neighbor == a; });
}

void TextbookNeuralGas::remove(std::uint32_t i) {
  ++removed_;
  const auto last = static_cast<std::uint32_t>(size() - 1);
  for (const Edge& e : neighbors_[last])
    for (Edge& back : neighbors_[e.neighbor])
      if (back.neighbor == last) back.neighbor = i;
  x_[i] = x_[last];
  y_[i] = y_[last];
  z_[i] = z_[last];
  errors_[i] = errors_[last];
  neighbors_[i] = neighbors_[last];
  x_[last] = y_[last] = z_[last] = nowhere;
  if (!colors_.empty()) {
    colors_[i] = colors_[last];
    colors_.pop_back();
  }
  errors_.pop_back();
  neighbors_.pop_back();
}

void TextbookNeuralGas::attract(std::uint32_t i, std::size_t point, float rate) {
  const Point4& signal = signals_.points()[point];
  x_[i] += rate * (signal.x - x_[i]);
  y_[i] += rate * (signal.y - y_[i]);
  z_[i] += rate * (signal.z - z_[i]);
  if (colors_.empty()) return;
  const Point4& color = signals_.colors()[point];
  colors_[i].x += rate * (color.x - colors_[i].x);
  colors_[i].y += rate * (color.y - colors_[i].y);
  colors_[i].z += rate * (color.z - colors_[i].z);
}

}  // namespace estancia
