// Mapping alone, labels given: time a frame and memory, at many nodes and over many frames.
//   bench_mapper            Google Benchmark: one frame at 100 … 10,000 nodes, per distance
//   bench_mapper --frames N a drive of N synthetic frames: time, nodes and resident memory as it goes
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "estancia/topology/mapper.hpp"

namespace {

using namespace estancia;

constexpr std::size_t labels = 1001;

/// Synthetic places: each has its own handful of likely labels; every image of it varies.
class World {
 public:
  explicit World(std::size_t places) {
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    for (std::size_t p = 0; p < places; ++p) {
      std::vector<float> logits(labels);
      for (float& l : logits) l = 1.5F * normal(random);
      logits_.push_back(std::move(logits));
    }
  }
  std::vector<float> image(std::size_t place, std::mt19937& random) const {
    std::normal_distribution<float> normal;
    std::vector<float> p(labels);
    float sum = 0;
    for (std::size_t i = 0; i < labels; ++i)
      sum += p[i] = std::exp(logits_[place][i] + 0.5F * normal(random));
    for (float& v : p) v /= sum;
    return p;
  }
  std::size_t places() const { return logits_.size(); }

 private:
  std::vector<std::vector<float>> logits_;
};

double residentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0;
  statm >> total >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// A bank of `nodes` places and frames that look for their node among all of them: the costliest frame there
/// is.
void searchAllNodes(benchmark::State& state, const std::string& name) {
  const auto nodes = static_cast<std::size_t>(state.range(0));
  const World world(nodes);
  std::mt19937 random(1);
  const Distance distance = getDistance(name);
  NodeBank bank(distance, labels);
  std::vector<float> embedded(labels);
  for (std::size_t place = 0; place < nodes; ++place) {
    NodeMemory node = bank.makeNode(static_cast<int>(place));
    const auto p = world.image(place, random);
    embed(distance.embedding, p, embedded);
    node.frames = 1;
    node.words.add(p);
    if (node.embedded) node.embedded->add(embedded);
    bank.add(std::move(node));
  }
  std::vector<std::vector<float>> frames;
  for (int i = 0; i < 32; ++i) frames.push_back(world.image(random() % nodes, random));
  std::size_t next = 0;
  for (auto _ : state) {
    embed(distance.embedding, frames[next++ % frames.size()], embedded);
    const auto query = bank.makeQuery(embedded);
    benchmark::DoNotOptimize(bank.nearest(query, nodes));
  }
  const double bytes = static_cast<double>(nodes) * labels * sizeof(float);
  state.counters["float32 GB/s"] =
      benchmark::Counter(bytes * 1e-9, benchmark::Counter::kIsIterationInvariantRate);
}

void drive(std::size_t frames) {
  using Clock = std::chrono::steady_clock;
  const World world(2000);
  Mapper mapper(labels, {});
  std::mt19937 random(1);
  auto start = Clock::now();
  double mapping = 0, worst = 0;
  std::size_t place = 0;
  fmt::print("{:>9} {:>7} {:>12} {:>12} {:>9}\n", "frames", "nodes", "mean us", "worst us", "RSS MB");
  for (std::size_t i = 1; i <= frames; ++i) {
    if (random() % 20 == 0) place = random() % world.places();
    const auto image = world.image(place, random);
    start = Clock::now();
    mapper.add(image);
    mapper.takeNews();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    mapping += seconds;
    worst = std::max(worst, seconds);
    if ((i & (i - 1)) == 0 && i >= 1024)
      fmt::print("{:>9} {:>7} {:>12.1f} {:>12.1f} {:>9.1f}\n", i, mapper.bank().size(),
                 mapping / static_cast<double>(i) * 1e6, worst * 1e6, residentMegabytes());
  }
  fmt::print("{:>9} {:>7} {:>12.1f} {:>12.1f} {:>9.1f}\n", frames, mapper.bank().size(),
             mapping / static_cast<double>(frames) * 1e6, worst * 1e6, residentMegabytes());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == "--frames") {
    drive(std::strtoull(argv[2], nullptr, 10));
    return 0;
  }
  for (const std::string name : {"standardized-clr", "hellinger", "l1", "weighted-root"})
    benchmark::RegisterBenchmark(("search/" + name).c_str(), searchAllNodes, name)
        ->Arg(100)
        ->Arg(1000)
        ->Arg(10000)
        ->Unit(benchmark::kMicrosecond);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
