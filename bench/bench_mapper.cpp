// Mapping alone, labels given: time a frame and memory, at many nodes and over many frames.
//   bench_mapper            Google Benchmark: one frame at 100 … 10,000 nodes, per distance
//   bench_mapper drive FRAMES PLACES STAY [FILE [FILE_BUDGET [MEMORY]]]
//                           a drive through PLACES made-up places, about STAY frames at each before it
//                           goes to another: time, nodes, resident memory; budgets in megabytes, 0: none
//   bench_mapper posed ...  the same with poses, as `estancia live` maps them
//   bench_mapper robots MAPS PLACES FOLDER      maps to merge: see robots()
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "estancia/distances/distance.hpp"
#include "estancia/mapper/node_bank.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/world_mapper.hpp"

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
    node.probabilities.add(p);
    if (node.embedded) node.embedded->add(embedded);
    bank.add(std::move(node));
  }
  std::vector<std::vector<float>> frames;
  for (int i = 0; i < 32; ++i) frames.push_back(world.image(random() % nodes, random));
  std::size_t next = 0;
  for (auto _ : state) {
    embed(distance.embedding, frames[next++ % frames.size()], embedded);
    const auto query = bank.compared(embedded);
    benchmark::DoNotOptimize(bank.nearest(query, nodes));
  }
  const double bytes = static_cast<double>(nodes) * labels * sizeof(float);
  state.counters["float32 GB/s"] =
      benchmark::Counter(bytes * 1e-9, benchmark::Counter::kIsIterationInvariantRate);
}

/// One line a power of two: the interval's mean and worst time a frame.
class Table {
 public:
  Table() {
    fmt::print("{:>9} {:>7} {:>12} {:>12} {:>9} {:>9}\n", "frames", "nodes", "mean us", "worst us", "RSS MB",
               "file MB");
  }
  void add(double seconds) {
    sum_ += seconds;
    worst_ = std::max(worst_, seconds);
    ++count_;
  }
  void print(std::size_t frames, std::size_t nodes, double file) {
    fmt::print("{:>9} {:>7} {:>12.1f} {:>12.1f} {:>9.1f} {:>9.1f}\n", frames, nodes,
               sum_ / static_cast<double>(count_) * 1e6, worst_ * 1e6, residentMegabytes(), file);
    std::fflush(stdout);
    sum_ = worst_ = 0;
    count_ = 0;
  }

 private:
  double sum_ = 0, worst_ = 0;
  std::size_t count_ = 0;
};

/// With what SQLite keeps beside it.
double megabytesOf(const std::filesystem::path& file) {
  double bytes = 0;
  for (const char* ending : {"", "-wal"})
    if (const std::filesystem::path part = file.string() + ending; std::filesystem::exists(part))
      bytes += static_cast<double>(std::filesystem::file_size(part));
  return bytes / 1e6;
}

/// Somewhere in its place: they lie 4 m apart, in rows.
Pose poseIn(std::size_t place, std::mt19937& random) {
  std::uniform_real_distribution<double> within(-1, 1);
  constexpr std::size_t row = 45;
  return Pose::planar(4.0 * static_cast<double>(place % row) + within(random),
                      4.0 * static_cast<double>(place / row) + within(random), 3 * within(random));
}

void drive(std::size_t frames, std::size_t places, std::size_t stay, const char* file,
           const MapBudget& budget, bool posed) {
  using Clock = std::chrono::steady_clock;
  const World world(places);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < labels; ++i) names.push_back(fmt::format("label {}", i));
  std::optional<MappingSession> session;
  std::optional<Mapper> mapper;
  std::optional<WorldMapper> layers;
  if (file != nullptr) {
    session = MappingSession::create(file, Vocabulary(names), "synthetic", {});
    session->setBudget(budget);
    if (posed) layers.emplace(*session);
  } else {
    mapper.emplace(labels, MapperOptions{});
  }
  std::mt19937 random(1);
  std::size_t place = 0, next = 1;
  Table table;
  for (std::size_t i = 1; i <= frames; ++i) {
    // first once through all places, then anywhere
    if (random() % stay == 0) place = next < places ? next++ : random() % places;
    const auto image = world.image(place, random);
    Frame frame;
    frame.name = fmt::format("frame {}", i);
    if (posed) frame.pose = poseIn(place, random);
    const auto start = Clock::now();
    if (layers) {
      layers->add(frame, image, {}, {}, {}, {}, [](int, const auto&) {});
    } else if (session) {
      session->add(frame, image);
    } else {
      mapper->add(image);
      mapper->takeChanges();
    }
    table.add(std::chrono::duration<double>(Clock::now() - start).count());
    if (((i & (i - 1)) == 0 && i >= 1024) || i % 1'000'000 == 0 || i == frames)
      table.print(i, (session ? session->mapper() : *mapper).nodes(),
                  file == nullptr ? 0 : megabytesOf(file));
  }
  if (session) session->finish();
  if (layers) layers->finish();
}

/// Places of one building. Their appearance varies in a few ways only, like that of real scenes.
class Building {
 public:
  Building() {
    std::mt19937 random(7);
    for (auto& direction : directions_)
      for (float& value : direction) value = 1.5F * normal_(random) / std::sqrt(float{ways});
  }
  using Look = std::array<float, 64>;
  Look look(unsigned seed, float scale) {
    std::mt19937 random(seed);
    normal_.reset();
    Look look{};
    for (float& value : look) value = scale * normal_(random);
    return look;
  }
  std::vector<float> image(const Look& place, const Look& light, std::mt19937& random) {
    std::vector<float> p(labels);
    for (std::size_t way = 0; way < ways; ++way) {
      const float amount = place[way] + light[way] + 0.35F * normal_(random);
      for (std::size_t i = 0; i < labels; ++i) p[i] += amount * directions_[way][i];
    }
    float sum = 0;
    for (float& v : p) sum += v = std::exp(v + 0.5F * normal_(random));
    for (float& v : p) v /= sum;
    return p;
  }

 private:
  static constexpr std::size_t ways = 64;
  std::normal_distribution<float> normal_;
  std::array<std::array<float, labels>, ways> directions_{};
};

/// Maps to merge (estancia merge): each robot drives twice through `places` places of one building, in its
/// own light; the next one begins a tenth further on. Frames know their places as rooms (estancia evaluate).
void robots(std::size_t maps, std::size_t places, const std::filesystem::path& folder) {
  Building building;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < labels; ++i) names.push_back(fmt::format("label {}", i));
  std::filesystem::create_directories(folder);
  for (std::size_t robot = 0; robot < maps; ++robot) {
    const auto light = building.look(static_cast<unsigned>(robot), 0.25F);
    std::mt19937 random(static_cast<unsigned>(robot));
    auto session = MappingSession::create(folder / fmt::format("{:04}.estancia", robot), Vocabulary(names),
                                          "synthetic", {}, ExistingMap::replace);
    for (std::size_t step = 0; step < 2 * places; ++step) {
      const std::size_t place = robot * places / 10 + (step < places ? step : 2 * places - 1 - step);
      const auto look = building.look(static_cast<unsigned>(1'000'000 + place), 1.3F);
      for (std::size_t i = 0; i < 3; ++i) {
        Frame frame;
        frame.name = fmt::format("robot {}, image {}", robot, 3 * step + i);
        frame.room = fmt::format("place {}", place);
        session.add(frame, building.image(look, light, random));
      }
    }
    session.finish();
    fmt::print("robot {}: {} places\n", robot, session.mapper().nodes());
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string kind = argc > 1 ? argv[1] : "";
  if (argc >= 5 && (kind == "drive" || kind == "posed")) {
    const auto number = [&](int i) { return std::max<std::size_t>(1, std::strtoull(argv[i], nullptr, 10)); };
    MapBudget budget;
    const auto bound = [&](int i, std::optional<std::uint64_t>& megabytes) {
      if (const auto value = i < argc ? std::strtoull(argv[i], nullptr, 10) : 0; value > 0) megabytes = value;
    };
    bound(6, budget.file);
    bound(7, budget.memory);
    drive(number(2), number(3), number(4), argc > 5 ? argv[5] : nullptr, budget, kind == "posed");
    return 0;
  }
  if (argc == 5 && kind == "robots") {
    robots(std::strtoull(argv[2], nullptr, 10), std::strtoull(argv[3], nullptr, 10), argv[4]);
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
