#include "estancia/cloud/growing_neural_gas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "estancia/cloud/neuron_errors.hpp"
#include "estancia/cloud/neuron_graph.hpp"
#include "estancia/cloud/neuron_grid.hpp"
#include "estancia/cloud/signals.hpp"
#include "estancia/core/error.hpp"

namespace estancia {
namespace {

void requireValid(const GngOptions& o) {
  const auto refuse = [](const std::string& what, const char* rule) {
    throw Error(fmt::format("growing neural gas: {}; {}", what, rule));
  };
  constexpr std::size_t most = 100'000'000;
  if (o.neurons < 2 || o.neurons > most)
    refuse(fmt::format("{} neurons", o.neurons), "2 to 100,000,000 can be had");
  if (o.signalsPerInsertion < 1) refuse("no signals between two insertions", "at least 1 is needed");
  if (!(o.winnerRate > 0 && o.winnerRate <= 1))
    refuse(fmt::format("a winner's learning step of {}", o.winnerRate), "it lies above 0 and is at most 1");
  if (!(o.neighborRate >= 0 && o.neighborRate <= 1))
    refuse(fmt::format("a neighbor's learning step of {}", o.neighborRate), "it lies between 0 and 1");
  if (!(o.insertionDecay >= 0 && o.insertionDecay <= 1))
    refuse(fmt::format("an error decay at insertions of {}", o.insertionDecay), "it lies between 0 and 1");
  if (!(o.errorDecay > 0 && o.errorDecay <= 1))
    refuse(fmt::format("an error decay of {}", o.errorDecay), "it lies above 0 and is at most 1");
  if (!(o.quantizationError >= 0)) refuse("a negative quantization error", "0 means none is asked for");
  if (!(o.seconds >= 0)) refuse("negative seconds", "0 means that there is no deadline");
}

/// The network while it grows.
class Network {
 public:
  Network(const Signals& signals, const GngOptions& options)
      : signals_(signals),
        options_(options),
        grid_(signals.points()),
        lastWinners_(signals.points().size()) {}

  /// Two neurons at the first signal and the first that is elsewhere.
  void begin() {
    const auto& points = signals_.points();
    const Point4 a = points[signals_.draw(drawn_++)];
    Point4 b = a;
    while (a.x == b.x && a.y == b.y && a.z == b.z) b = points[signals_.draw(drawn_++)];
    for (const Point4& p : {a, b}) add(p);
    first_ = drawn_;
    grid_.fit(neurons_, 2);
  }

  std::size_t size() const { return neurons_.size(); }
  const std::vector<Neuron>& neurons() const { return neurons_; }
  const NeuronGraph& graph() const { return graph_; }
  std::uint64_t signalsSeen() const { return drawn_ - first_; }

  /// Shows so many signals. Returns the sum of their squared distances to the winners as those were before.
  double learn(std::size_t count) {
    // What a signal will read is known before its turn, so it is called for: first the point, then the cell
    // that this names, then the list that that names.
    constexpr std::size_t ahead = 32, cellAhead = 20, listAhead = 10;
    std::array<std::size_t, ahead> ring{};
    double sum = 0;
    for (std::size_t k = 0; k < count + ahead; ++k) {
      if (k >= ahead) sum += learnFrom(ring[k % ahead]);
      ring[k % ahead] = signals_.draw(drawn_ + k);
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

  void insert() {
    const std::uint32_t q = errors_.largest();
    std::uint32_t f = none;
    graph_.forNeighbors(q, [&](std::uint32_t n) {
      if (f == none || errors_.at(n) > errors_.at(f) || (errors_.at(n) == errors_.at(f) && n < f)) f = n;
    });
    const auto r = static_cast<std::uint32_t>(size());
    const Neuron &a = neurons_[q], &b = neurons_[f];
    const std::uint32_t winsOfQ = a.wins, winsOfF = b.wins;
    add({0.5F * (a.x + b.x), 0.5F * (a.y + b.y), 0.5F * (a.z + b.z), 0});
    grid_.insert(r, neurons_);
    graph_.disconnect(q, f);
    graph_.connect(q, r, winsOfQ);
    graph_.connect(f, r, winsOfF);
    errors_.set(f, errors_.at(f) * options_.insertionDecay);
    errors_.set(q, errors_.at(q) * options_.insertionDecay);
    errors_.set(r, errors_.at(q));
    errors_.decayAll(options_.errorDecay);
  }

  void fitGrid(double rms) { grid_.fit(neurons_, rms); }
  /// Over all points.
  double sumOfSquaredDistances() const {
    double sum = 0;
    for (std::size_t k = 0; k < signals_.points().size(); ++k)
      sum += grid_.nearestTwo(k, neurons_).squaredDistance();
    return sum;
  }

 private:
  static constexpr std::uint32_t none = 0xffffffff;

  void add(const Point4& p) {
    Neuron n;
    n.x = p.x;
    n.y = p.y;
    n.z = p.z;
    neurons_.push_back(n);
    graph_.add();
    errors_.append(0);
  }

  float learnFrom(std::size_t point) {
    const NearestTwo two = grid_.nearestTwo(point, neurons_);
    const std::uint32_t winner = two.first();
    lastWinners_[point] = winner;
    errors_.add(winner, two.squaredDistance());
    const Point4& p = grid_.point(point);
    const Vector signal{p.x, p.y, p.z, 0};
    Neuron* const neurons = neurons_.data();
    const Vector tolerance = Vector{} + grid_.tolerance();
    attract(neurons, winner, signal, options_.winnerRate, tolerance);
    const std::uint32_t wins = ++neurons[winner].wins;
    const bool connected =
        graph_.win(winner, wins, two.second(), options_.maximalAge,
                   [this, neurons, signal, tolerance, rate = options_.neighborRate](std::uint32_t n) {
                     attract(neurons, n, signal, rate, tolerance);
                     return neurons[n].wins;
                   });
    if (!connected) graph_.connect(winner, two.second(), wins + neurons[two.second()].wins);
    if (!graph_.old().empty()) cut(winner);
    return two.squaredDistance();
  }

  void attract(Neuron* neurons, std::uint32_t i, Vector signal, float rate, Vector tolerance) {
    constexpr Bits xyz{-1, -1, -1, 0};
    Neuron& n = neurons[i];
    const Vector whole = load(&n.x), home = load(&n.homeX);
    const auto place = reinterpret_cast<Vector>(reinterpret_cast<Bits>(whole) & xyz);
    const Vector moved = place + rate * (signal - place);
    const Bits next = reinterpret_cast<Bits>(moved) | (reinterpret_cast<Bits>(whole) & ~xyz);  // wins stay
    std::memcpy(&n.x, &next, sizeof next);
    const Vector away = moved - home;
    if (signs((away > tolerance) | (away < -tolerance)) != 0) grid_.rehome(i, neurons_);
  }

  /// Removes edges that are too old, and neurons that have none left.
  void cut(std::uint32_t winner) {
    std::vector<std::uint32_t> lonely;
    for (const std::uint32_t n : graph_.old()) {
      graph_.disconnect(winner, n);
      if (graph_.isolated(n)) lonely.push_back(n);
    }
    // From the highest number down, so that the last one, which takes the place, stays.
    std::sort(lonely.rbegin(), lonely.rend());
    for (const std::uint32_t i : lonely) {
      const auto last = static_cast<std::uint32_t>(size() - 1);
      grid_.erase(i, neurons_);
      if (i != last) grid_.rename(last, i, neurons_);
      graph_.remove(i);
      errors_.remove(i);
      neurons_[i] = neurons_[last];
      neurons_.pop_back();
    }
  }

  const Signals& signals_;
  const GngOptions& options_;
  std::uint64_t drawn_ = 0, first_ = 0;
  std::vector<Neuron> neurons_;
  NeuronGraph graph_;
  NeuronGrid grid_;
  NeuronErrors errors_;
  std::vector<std::uint32_t> lastWinners_;  ///< of every point: mostly its next one
};

NeuralGas withCloud(const Signals& signals, const std::vector<Neuron>& neurons) {
  NeuralGas gas;
  gas.cloud.points.reserve(neurons.size());
  for (const Neuron& n : neurons) gas.cloud.points.push_back(signals.inCloud(n.at()));
  gas.cloud.width = neurons.size();
  gas.cloud.height = 1;
  return gas;
}

/// A cloud that is its own network.
NeuralGas itself(const Signals& signals, const std::vector<Point4>& points) {
  std::vector<Neuron> neurons(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    neurons[i].x = points[i].x;
    neurons[i].y = points[i].y;
    neurons[i].z = points[i].z;
  }
  NeuralGas gas = withCloud(signals, neurons);
  gas.stop = GngStop::points;
  if (points.size() < 2) return gas;
  NeuronGrid grid(points);
  grid.fit(neurons, 1 / std::sqrt(static_cast<double>(points.size())));
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const NearestTwo nearest = grid.nearestTwo(i, neurons);
    // Itself comes first, but for distances whose squares are 0.
    const std::uint32_t n = nearest.second() == i ? nearest.first() : nearest.second();
    gas.edges.push_back({std::min(i, n), std::max(i, n)});
  }
  std::sort(gas.edges.begin(), gas.edges.end());
  gas.edges.erase(std::unique(gas.edges.begin(), gas.edges.end()), gas.edges.end());
  gas.ages.assign(gas.edges.size(), 0);
  return gas;
}

}  // namespace

NeuralGas growNeuralGas(const PointCloud& cloud, const GngOptions& options, Progress& progress) {
  requireValid(options);
  const auto start = std::chrono::steady_clock::now();
  const Signals signals(cloud, options.seed);
  const std::vector<Point4> distinct = distinctPoints(signals.points(), options.neurons + 1);
  if (distinct.size() <= options.neurons) return itself(signals, distinct);

  Network network(signals, options);
  network.begin();
  progress.begin("neural gas", options.neurons, network.size());
  const auto overdue = [&] {
    return options.seconds > 0 &&
           std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > options.seconds;
  };
  constexpr std::size_t atOnce = 20000;  // signals, before somebody is asked whether to go on
  constexpr std::size_t fewest = 24;     // with fewer neurons all are candidates
  std::size_t most = network.size(), fitted = most, idle = 0;
  GngStop stop = GngStop::neurons;
  while (network.size() < options.neurons) {
    double sum = 0;
    for (std::size_t left = options.signalsPerInsertion; left > 0 && stop == GngStop::neurons;) {
      const std::size_t count = std::min(left, atOnce);
      sum += network.learn(count);
      left -= count;
      if (interrupted()) throw Interrupted("stopped while a neural gas grew");
      if (overdue()) stop = GngStop::seconds;
    }
    const double rms = std::sqrt(sum / static_cast<double>(options.signalsPerInsertion));
    if (stop == GngStop::neurons && rms / signals.scale() < options.quantizationError)
      stop = GngStop::quantizationError;
    if (stop != GngStop::neurons) break;
    network.insert();
    if (network.size() > most) {
      progress.advance(network.size() - most);
      most = network.size();
      idle = 0;
    } else if (++idle > 1000 + most) {
      stop = GngStop::stalled;
      break;
    }
    if (most >= 2 * fitted && most >= fewest) {
      network.fitGrid(std::max(rms, 1e-6));
      fitted = most;
    }
  }
  progress.end();

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
  gas.quantizationError =
      std::sqrt(network.sumOfSquaredDistances() / static_cast<double>(signals.points().size())) /
      signals.scale();
  return gas;
}

}  // namespace estancia
