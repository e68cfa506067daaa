// Growing neural gas beside a textbook's, on one core, in one run; both learn from the same signals and must
// end in the same graph. docs/measured/gng.md holds what it showed.
//   bench_gng CLOUD.pcd [neurons] [delta] [textbook's neurons]
// The textbook runs whole unless the last number is smaller than the first: then it stops at so many.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include "estancia/cloud/growing_neural_gas.hpp"
#include "estancia/files/pcd.hpp"
#include "tests/cloud/textbook_neural_gas.hpp"

namespace {

using namespace estancia;

/// Processor time, which other load of the machine does not affect.
double seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Looks at the clock whenever the network has reached one of these sizes.
class Laps final : public Progress {
 public:
  explicit Laps(const std::vector<std::size_t>& sizes) {
    for (const std::size_t n : sizes) laps_[n] = 0;
  }
  void begin(const std::string&, std::size_t, std::size_t done) override { size_ = done; }
  void advance(std::size_t count) override {
    size_ += count;
    const auto lap = laps_.find(size_);
    if (lap != laps_.end()) lap->second = seconds();
  }
  /// Nanoseconds a signal while the network grew from one size to another.
  double cost(std::size_t from, std::size_t to, std::size_t delta) const {
    return (laps_.at(to) - laps_.at(from)) * 1e9 / static_cast<double>((to - from) * delta);
  }

 private:
  std::map<std::size_t, double> laps_;
  std::size_t size_ = 0;
};

void compare(const PointCloud& cloud, const GngOptions& options, std::size_t textbooks) {
  std::vector<std::size_t> ends;
  for (const std::size_t n : {500, 1000, 2000, 5000, 10000, 15000, 20000, 50000, 100000})
    if (n <= options.neurons) ends.push_back(n);
  std::vector<std::size_t> laps;
  for (const std::size_t n : ends) {
    laps.push_back(n * 9 / 10);
    laps.push_back(n);
  }
  Laps ours(laps), theirs(laps);
  const double start = seconds();
  const NeuralGas gas = growNeuralGas(cloud, options, ours);
  const double own = seconds() - start;

  const Signals signals(cloud, options.seed);
  GngOptions short_ = options;
  short_.neurons = std::min(options.neurons, textbooks);
  TextbookNeuralGas textbook(signals, short_);
  const double second = seconds();
  textbook.grow(theirs);
  const double other = seconds() - second;

  fmt::print(
      "{} points, {} finite; {} signals\n\n| neurons | ours, ns a signal | textbook's | ratio "
      "|\n|---|---|---|---|\n",
      cloud.points.size(), signals.points().size(), gas.signals);
  for (const std::size_t n : ends) {
    const double mine = ours.cost(n * 9 / 10, n, options.signalsPerInsertion);
    fmt::print("| {} | {:.1f} |", n, mine);
    if (n <= textbooks) {
      const double its = theirs.cost(n * 9 / 10, n, options.signalsPerInsertion);
      fmt::print(" {:.1f} | {:.1f} |\n", its, its / mine);
    } else {
      fmt::print(" | |\n");
    }
  }
  fmt::print("\nours: {:.2f} s, quantization error {:.9g}\n", own, gas.quantizationError);
  if (textbooks < options.neurons) return;
  double sum = 0;
  for (const Point4& p : signals.points()) sum += textbook.nearestTwo(p).second;
  fmt::print("textbook: {:.2f} s, quantization error {:.9g}; ratio {:.1f}\n", other,
             std::sqrt(sum / static_cast<double>(signals.points().size())) / signals.scale(), other / own);
  bool same = gas.cloud.points.size() == textbook.size();
  for (std::size_t i = 0; same && i < textbook.size(); ++i)
    same = gas.cloud.points[i] == signals.inCloud(textbook.at(i));
  const auto edges = textbook.edges();
  same = same && edges.size() == gas.edges.size();
  for (std::size_t i = 0; same && i < edges.size(); ++i)
    same = gas.edges[i] == edges[i].first && gas.ages[i] == edges[i].second;
  fmt::print("neurons, edges and ages the same: {}\n", same ? "yes" : "NO");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 5) {
    std::fputs("usage: bench_gng CLOUD.pcd [neurons] [delta] [textbook's neurons]\n", stderr);
    return 2;
  }
  try {
    GngOptions options;
    if (argc > 2) options.neurons = std::strtoull(argv[2], nullptr, 10);
    if (argc > 3) options.signalsPerInsertion = std::strtoull(argv[3], nullptr, 10);
    compare(readPcd(argv[1]), options, argc > 4 ? std::strtoull(argv[4], nullptr, 10) : options.neurons);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 1;
  }
}
