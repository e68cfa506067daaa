// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/growing_neural_gas.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/neuron_graph.hpp"
#include "estancia/cloud/neuron_grid.hpp"
#include "estancia/cloud/signals.hpp"
#include "estancia/core/error.hpp"

namespace estancia {
namespace {

/// The network while it grows. Steps are those of Fritzke 1995, section 3. Invariant: `colors_`, `graph_` and
/// `errors_` have one entry a neuron, and `grid_` holds each neuron in the cell of its position. Life cycle:
/// grow by steps until the requested number of neurons; signals are drawn by number, so the result depends on
/// the seed alone.
class Network {
 public:
  /// Step 0: two neurons, at the first signal and the first one elsewhere.
  Network(const Signals& signals, const GngOptions& options)
      : signals_(signals),
        options_(options),
        colored_(!signals.colors().empty()),
        grid_(signals.points(), signals.colors()),
        lastWinners_(signals.points().size()) {
    const auto& points = signals_.points();
    const std::size_t a = signals_.draw(drawn_++);
    std::size_t b = a;
    while (points[a].x == points[b].x && points[a].y == points[b].y && points[a].z == points[b].z)
      b = signals_.draw(drawn_++);
    for (const std::size_t point : {a, b}) {
      add(points[point]);
      if (colored_) colors_.push_back(signals_.colors()[point]);
    }
    first_ = drawn_;
    grid_.fit(neurons_, colors_, 2);
  }

  std::size_t size() const { return neurons_.size(); }
  const std::vector<Neuron>& neurons() const { return neurons_; }
  const NeuronGraph& graph() const { return graph_; }
  std::uint64_t signalsSeen() const { return drawn_ - first_; }

  /// Steps 1 to 7 for the next `count` signals. Returns the sum of the squared distances to their winners,
  /// before these moved.
  double learn(std::size_t count) {
    // The memory that a signal needs is known in advance, so it is prefetched: first the point, then its
    // cell, then the list of the cell.
    constexpr std::size_t ahead = 32, cellAhead = 20, listAhead = 10;
    std::array<std::size_t, ahead> ring{};
    double sum = 0;
    for (std::size_t k = 0; k < count + ahead; ++k) {
      if (k >= ahead) sum += learnFrom(ring[k % ahead]);
      ring[k % ahead] = signals_.draw(drawn_ + k);  // step 1: a random signal
      grid_.prefetchPoint(ring[k % ahead]);
      __builtin_prefetch(&lastWinners_[ring[k % ahead]], 1);
      if (k >= ahead - cellAhead) grid_.prefetchCell(ring[(k - (ahead - cellAhead)) % ahead]);
      if (k >= ahead - listAhead) {
        const std::size_t point = ring[(k - (ahead - listAhead)) % ahead];
        grid_.prefetchList(point);
        graph_.prefetch(lastWinners_[point]);
        errors_.prefetch(lastWinners_[point]);
      }
    }
    drawn_ += count;
    return sum;
  }

  /// Steps 8 and 9.
  void insert() {
    // Step 8: a new neuron r halfway between q, the neuron with the largest error, and f, the neighbor of q
    // with the largest error; edges q-r and f-r replace q-f.
    const std::uint32_t q = errors_.largest();
    std::uint32_t f = none;
    graph_.forNeighbors(q, [&](std::uint32_t n) {
      if (f == none || errors_.at(n) > errors_.at(f) || (errors_.at(n) == errors_.at(f) && n < f)) f = n;
    });
    const auto r = static_cast<std::uint32_t>(size());
    const Neuron &a = neurons_[q], &b = neurons_[f];
    const std::uint32_t winsOfQ = a.wins, winsOfF = b.wins;
    add({0.5F * (a.x + b.x), 0.5F * (a.y + b.y), 0.5F * (a.z + b.z), 0});
    if (colored_) {
      const Point4 c = colors_[q], d = colors_[f];
      colors_.push_back({0.5F * (c.x + d.x), 0.5F * (c.y + d.y), 0.5F * (c.z + d.z), 0});
    }
    grid_.insert(r, neurons_);
    graph_.disconnect(q, f);
    graph_.connect(q, r, winsOfQ);
    graph_.connect(f, r, winsOfF);
    errors_.set(f, errors_.at(f) * options_.insertionDecay);
    errors_.set(q, errors_.at(q) * options_.insertionDecay);
    errors_.set(r, errors_.at(q));
    // Step 9: all errors decay.
    errors_.decayAll(options_.errorDecay);
  }

  /// Fits the search grid again whenever the network has doubled; `rms` is the distance of the signals.
  void refitGrid(double rms) {
    constexpr std::size_t minNeurons = 24;  // with fewer, all are candidates anyway
    if (size() < 2 * fitted_ || size() < minNeurons) return;
    grid_.fit(neurons_, colors_, std::max(rms, 1e-6));
    fitted_ = size();
  }

  /// The neuron nearest to each point, and the sum of their squared distances.
  std::pair<std::vector<std::uint32_t>, double> winners() const {
    std::vector<std::uint32_t> winners(signals_.points().size());
    double sum = 0;
    for (std::size_t k = 0; k < winners.size(); ++k) {
      const NearestTwo two = grid_.nearestTwo(k, neurons_, colors_);
      winners[k] = two.first();
      sum += two.squaredDistance();
    }
    return {std::move(winners), sum};
  }

 private:
  static constexpr std::uint32_t none = 0xffffffff;

  void add(const Point4& p) {
    neurons_.push_back({.x = p.x, .y = p.y, .z = p.z});
    graph_.add();
    errors_.append(0);
  }

  /// Steps 2 to 7 for one signal. Returns its squared distance to the winner.
  float learnFrom(std::size_t point) {
    // Step 2: the winner s1 is the nearest neuron, s2 the second nearest.
    const NearestTwo two = grid_.nearestTwo(point, neurons_, colors_);
    const std::uint32_t winner = two.first();
    lastWinners_[point] = winner;
    // Step 4: its error grows by the squared distance.
    errors_.add(winner, two.squaredDistance());
    // Step 5: the winner moves towards the signal by ε_w, and its neighbors, below, by ε_n.
    const Point4& p = grid_.point(point);
    const Vector signal{p.x, p.y, p.z, 0};
    Neuron* const neurons = neurons_.data();
    const Vector tolerance = Vector{} + grid_.tolerance();
    attract(neurons, winner, signal, options_.winnerRate, tolerance);
    if (colored_) attractColor(winner, point, options_.winnerRate);
    // Step 3: the edges of the winner age by one. Step 6: that between s1 and s2 gets age 0, or is created.
    const std::uint32_t wins = ++neurons[winner].wins;
    const bool connected =
        graph_.win(winner, wins, two.second(), options_.maxAge,
                   [this, neurons, signal, tolerance, point, rate = options_.neighborRate](std::uint32_t n) {
                     attract(neurons, n, signal, rate, tolerance);
                     if (colored_) attractColor(n, point, rate);
                     return neurons[n].wins;
                   });
    if (!connected) graph_.connect(winner, two.second(), wins + neurons[two.second()].wins);
    // Step 7: edges older than a_max are removed, and neurons without edges.
    if (!graph_.old().empty()) removeOld(winner);
    return two.squaredDistance();
  }

  /// w += rate (signal - w)
  void attract(Neuron* neurons, std::uint32_t i, Vector signal, float rate, Vector tolerance) {
    constexpr Bits xyz{-1, -1, -1, 0};
    Neuron& n = neurons[i];
    const Vector whole = load(&n.x), home = load(&n.homeX);
    const auto place = reinterpret_cast<Vector>(reinterpret_cast<Bits>(whole) & xyz);
    const Vector moved = place + rate * (signal - place);
    const Bits next = reinterpret_cast<Bits>(moved) | (reinterpret_cast<Bits>(whole) & ~xyz);  // keeps wins
    std::memcpy(&n.x, &next, sizeof next);
    const Vector away = moved - home;
    if (signs((away > tolerance) | (away < -tolerance)) != 0) grid_.rehome(i, neurons_);
  }

  void attractColor(std::uint32_t i, std::size_t point, float rate) {
    Point4& n = colors_[i];
    const Point4& c = signals_.colors()[point];
    n.x += rate * (c.x - n.x);
    n.y += rate * (c.y - n.y);
    n.z += rate * (c.z - n.z);
  }

  void removeOld(std::uint32_t winner) {
    std::vector<std::uint32_t> isolated;
    for (const std::uint32_t n : graph_.old()) {
      graph_.disconnect(winner, n);
      if (graph_.isolated(n)) isolated.push_back(n);
    }
    // In descending order, because the last neuron takes the number of a removed one.
    std::sort(isolated.rbegin(), isolated.rend());
    for (const std::uint32_t i : isolated) {
      const auto last = static_cast<std::uint32_t>(size() - 1);
      grid_.erase(i, neurons_);
      if (i != last) grid_.rename(last, i, neurons_);
      graph_.remove(i);
      errors_.remove(i);
      neurons_[i] = neurons_[last];
      neurons_.pop_back();
      if (!colored_) continue;
      colors_[i] = colors_[last];
      colors_.pop_back();
    }
  }

  const Signals& signals_;
  const GngOptions& options_;
  const bool colored_;
  std::uint64_t drawn_ = 0, first_ = 0;
  std::size_t fitted_ = 2;  ///< neurons when the grid was fitted
  std::vector<Neuron> neurons_;
  NeuronGrid::Colors colors_;  ///< one a neuron where colors are signals, too; else none
  NeuronGraph graph_;
  NeuronGrid grid_;
  NeuronErrors errors_;
  /// last winner of every point: mostly its next one, for prefetching
  std::vector<std::uint32_t> lastWinners_;
};

/// Step 10: the stop criteria.
class StopRules {
 public:
  explicit StopRules(const GngOptions& options) : options_(options) {}

  bool reached() const { return reason_.has_value(); }
  GngStop reason() const { return reason_.value_or(GngStop::neurons); }

  void checkDeadline() {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    if (options_.seconds > 0 && elapsed.count() > options_.seconds) reason_ = GngStop::seconds;
  }
  void checkError(double quantizationError) {
    if (!reason_ && quantizationError < options_.quantizationError) reason_ = GngStop::quantizationError;
  }
  /// After an insertion. Returns by how much the network exceeds its largest size so far.
  std::size_t checkGrowth(std::size_t neurons) {
    if (neurons > largest_) {
      idle_ = 0;
      return neurons - std::exchange(largest_, neurons);
    }
    if (++idle_ > 1000 + largest_) reason_ = GngStop::stalled;
    return 0;
  }

 private:
  const GngOptions& options_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::optional<GngStop> reason_;
  std::size_t largest_ = 2, idle_ = 0;
};

/// Steps 1 to 7, λ times. Returns the root mean square distance of the signals to their winners.
double learnRound(Network& network, const GngOptions& options, StopRules& stop) {
  constexpr std::size_t chunk = 20000;  // signals between two looks at the clock
  double sum = 0;
  for (std::size_t left = options.signalsPerInsertion; left > 0 && !stop.reached();) {
    const std::size_t count = std::min(left, chunk);
    sum += network.learn(count);
    left -= count;
    if (interrupted()) throw Interrupted("interrupted while a neural gas grew");
    stop.checkDeadline();
  }
  return std::sqrt(sum / static_cast<double>(options.signalsPerInsertion));
}

NeuralGas withCloud(const Signals& signals, const std::vector<Neuron>& neurons) {
  NeuralGas gas;
  gas.cloud.points.reserve(neurons.size());
  for (const Neuron& n : neurons) gas.cloud.points.push_back(signals.inCloud(n.at()));
  gas.cloud.width = neurons.size();
  gas.cloud.height = 1;
  return gas;
}

/// The points themselves as neurons, each joined with its nearest.
NeuralGas networkOfPoints(const Signals& signals, const std::vector<Point4>& points) {
  std::vector<Neuron> neurons;
  for (const Point4& p : points) neurons.push_back({.x = p.x, .y = p.y, .z = p.z});
  NeuralGas gas = withCloud(signals, neurons);
  gas.stop = GngStop::points;
  if (points.size() < 2) return gas;
  NeuronGrid grid(points);
  grid.fit(neurons, {}, 1 / std::sqrt(static_cast<double>(points.size())));
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const NearestTwo nearest = grid.nearestTwo(i, neurons, {});
    // The point itself is first, unless squared distances underflow.
    const std::uint32_t n = nearest.second() == i ? nearest.first() : nearest.second();
    gas.edges.push_back({std::min(i, n), std::max(i, n)});
  }
  std::sort(gas.edges.begin(), gas.edges.end());
  gas.edges.erase(std::unique(gas.edges.begin(), gas.edges.end()), gas.edges.end());
  gas.ages.assign(gas.edges.size(), 0);
  return gas;
}

/// Each neuron gets the mean color of the points nearest to it, else that of the nearest point. `winners` are
/// the neurons of the finite points; empty: each neuron is at a point.
void paint(NeuralGas& gas, const PointCloud& cloud, const std::vector<std::uint32_t>& winners) {
  if (cloud.colors.empty()) return;
  struct Sum {
    cv::Vec<std::uint64_t, 3> color;
    std::uint64_t count = 0;
  };
  std::vector<Sum> sums(gas.cloud.points.size());
  for (std::size_t i = 0, k = 0; i < cloud.points.size() && k < winners.size(); ++i) {
    if (!isFinite(cloud.points[i])) continue;
    Sum& sum = sums[winners[k++]];
    for (int c = 0; c < 3; ++c) sum.color[c] += cloud.colors[i][c];
    ++sum.count;
  }
  std::optional<Neighbors> around;
  std::vector<Neighbor> buffer;
  for (std::size_t n = 0; n < sums.size(); ++n) {
    const Sum& sum = sums[n];
    if (sum.count == 0) {
      if (!around) around.emplace(cloud.points);
      gas.cloud.colors.push_back(cloud.colors[around->nearest(gas.cloud.points[n], 1, buffer).front().index]);
      continue;
    }
    const auto mean = [&sum](int c) {
      return static_cast<uchar>((sum.color[c] + sum.count / 2) / sum.count);
    };
    gas.cloud.colors.emplace_back(mean(0), mean(1), mean(2));
  }
}

NeuralGas toNeuralGas(const Network& network, const PointCloud& cloud, const Signals& signals, GngStop stop) {
  NeuralGas gas = withCloud(signals, network.neurons());
  gas.stop = stop;
  gas.signals = network.signalsSeen();
  for (std::uint32_t i = 0; i < network.size(); ++i)
    network.graph().forNeighbors(i, [&](std::uint32_t n) {
      if (i < n) gas.edges.push_back({i, n});
    });
  std::sort(gas.edges.begin(), gas.edges.end());
  gas.ages.reserve(gas.edges.size());
  for (const auto& [a, b] : gas.edges)
    gas.ages.push_back(network.graph().age(a, b, network.neurons()[a].wins + network.neurons()[b].wins));
  const auto [winners, sum] = network.winners();
  gas.quantizationError = std::sqrt(sum / static_cast<double>(signals.points().size())) / signals.scale();
  paint(gas, cloud, winners);
  return gas;
}

}  // namespace

OptionGroup declare(GngOptions& o) {
  OptionGroup group("gng", "Growing Neural Gas.");
  group.add("neurons", &o.neurons, "Neurons of the network").range(2, 100'000'000);
  group.add("signals-per-insertion", &o.signalsPerInsertion, "Signals between two insertions (λ)")
      .range(1)
      .why("More fit the surface better and take proportionally longer.");
  group.add("winner-rate", &o.winnerRate, "Share of the way to a signal that the winner moves").above(0, 1);
  group.add("neighbor-rate", &o.neighborRate, "Share of the way that neighbors of the winner move")
      .range(0, 1);
  group
      .add("insertion-decay", &o.insertionDecay,
           "Share of their error that both parents of a new neuron keep")
      .range(0, 1);
  group.add("error-decay", &o.errorDecay, "Share of its error that every neuron keeps at an insertion")
      .above(0, 1);
  group.add("max-age", &o.maxAge, "Age above which edges are removed");
  group.add("color-weight", &o.colorWeight, "Weight of colors beside positions; 0: positions only")
      .range(0, 1e6)
      .why("With 1 the noise of the colors counts as much as the spacing of the points.");
  group.add("seed", &o.seed, "Seed of the signals");
  group.add("quantization-error", &o.quantizationError, "Stop below this quantization error; 0: never")
      .range(0)
      .unit("unit of the cloud");
  group.add("seconds", &o.seconds, "Stop after this time; 0: never. The result is then not reproducible")
      .range(0)
      .unit("s");
  return group;
}

NeuralGas growNeuralGas(const PointCloud& cloud, const GngOptions& options, Progress& progress) {
  validate(options);
  StopRules stop(options);
  const Signals signals(cloud, options.seed, options.colorWeight);
  const std::vector<Point4> distinct = distinctPoints(signals.points(), options.neurons + 1);
  if (distinct.size() <= options.neurons) {
    NeuralGas gas = networkOfPoints(signals, distinct);
    paint(gas, cloud, {});
    return gas;
  }

  Network network(signals, options);  // step 0
  progress.begin("neural gas", options.neurons, network.size());
  while (network.size() < options.neurons) {
    const double rms = learnRound(network, options, stop);  // steps 1 to 7
    stop.checkError(rms / signals.scale());                 // step 10
    if (stop.reached()) break;
    network.insert();  // steps 8 and 9
    network.refitGrid(rms);
    if (const std::size_t grown = stop.checkGrowth(network.size()); grown > 0) progress.advance(grown);
    if (stop.reached()) break;
  }
  progress.end();
  return toNeuralGas(network, cloud, signals, stop.reason());
}

}  // namespace estancia
