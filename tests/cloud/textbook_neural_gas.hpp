// Growing neural gas as the textbook has it: every signal looks at every neuron, ages and errors are counted
// one by one. What the library's must equal, and is measured against.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "estancia/cloud/growing_neural_gas.hpp"
#include "estancia/cloud/signals.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

class TextbookNeuralGas {
 public:
  TextbookNeuralGas(const Signals& signals, const GngOptions& options);

  /// δ signals, without an insertion. Returns the sum of their squared distances.
  double learn();
  void insert();
  /// Until there are `neurons` neurons; false when it gave up, as the library does.
  bool grow(Progress& progress);

  std::size_t size() const { return errors_.size(); }
  std::uint64_t signalsSeen() const { return t_ - first_; }
  std::size_t removed() const { return removed_; }
  Point4 at(std::size_t i) const { return {x_[i], y_[i], z_[i], 0}; }
  /// Sorted, with their ages.
  std::vector<std::pair<std::array<std::uint32_t, 2>, std::uint32_t>> edges() const;
  /// The two nearest neurons and the squared distance to the first.
  std::pair<std::array<std::uint32_t, 2>, float> nearestTwo(const Point4& p) const;
  /// The nearest two neurons of a signal, by its color, too, if the signals have colors.
  std::pair<std::array<std::uint32_t, 2>, float> nearestTwo(std::size_t point) const;

 private:
  struct Edge {
    std::uint32_t neighbor, age;
  };
  void add(const Point4& p);
  void connect(std::uint32_t a, std::uint32_t b);
  void disconnect(std::uint32_t a, std::uint32_t b);
  void remove(std::uint32_t i);
  void attract(std::uint32_t i, std::size_t point, float rate);

  const Signals& signals_;
  GngOptions options_;
  std::uint64_t t_ = 0, first_ = 0;
  std::size_t removed_ = 0;
  std::vector<float> x_, y_, z_;  ///< a whole number of blocks
  std::vector<Point4> colors_;    ///< one a neuron if the signals have colors
  std::vector<double> errors_;
  std::vector<std::vector<Edge>> neighbors_;
};

}  // namespace estancia
