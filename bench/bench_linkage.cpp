// Semantic zones: the distances of all pairs and their linkage, exact. docs/measured/benchmarks.md holds what
// it showed.
//   bench_linkage scipy [LABELS.npy]   ours beside SciPy's pdist(chebyshev) + linkage(average), in one run;
//                                      without labels 4,579 × 1,001 made-up ones
//   bench_linkage curve N…             time and memory for N images of 205 labels, as clr-cosine with each
//   linkage
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "estancia/core/cores.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/memory.hpp"
#include "estancia/files/npy.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/label_scale.hpp"
#include "estancia/stats/linkage.hpp"

namespace {

using namespace estancia;
namespace fs = std::filesystem;
/// Seconds by the wall clock, and of the processor: those do not see what else the machine does.
struct Seconds {
  double wall = 0, cpu = 0;
};

class Stopwatch {
 public:
  Seconds seconds() const {
    return {std::chrono::duration<double>(Clock::now() - wall_).count(),
            static_cast<double>(std::clock() - cpu_) / CLOCKS_PER_SEC};
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point wall_ = Clock::now();
  std::clock_t cpu_ = std::clock();
};

/// Most that the process ever held [GiB].
double peakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / (1 << 20);
}

/// A drive through made-up places, twenty images at each: softmax of a place's own logits and noise.
DescriptorMatrix madeUp(std::size_t images, std::size_t labels, std::size_t places) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  std::vector<std::vector<float>> logits(places, std::vector<float>(labels));
  for (auto& place : logits)
    for (float& l : place) l = 2.5F * normal(random);
  DescriptorMatrix matrix(labels);
  matrix.reserve(images);
  std::vector<float> p(labels);
  for (std::size_t i = 0; i < images; ++i) {
    float sum = 0;
    for (std::size_t k = 0; k < labels; ++k)
      sum += p[k] = std::exp(logits[i / 20 % places][k] + normal(random));
    for (float& v : p) v /= sum;
    matrix.append(p);
  }
  return matrix;
}

DescriptorMatrix readLabels(const fs::path& path) {
  io::NpyFile file(path);
  DescriptorMatrix matrix(file.columns());
  for (std::size_t i = 0; i < file.rows(); ++i) {
    const std::vector<double>& row = file.next();
    matrix.append(std::vector<float>(row.begin(), row.end()));
  }
  return matrix;
}

struct Timing {
  Seconds distances, linkage;
  Seconds both() const { return {distances.wall + linkage.wall, distances.cpu + linkage.cpu}; }
};

Dendrogram cluster(const DescriptorMatrix& rows, Comparison comparison, Linkage linkage, int threads,
                   Timing& timing) {
  const Stopwatch first;
  CondensedDistances distances = pairwiseDistances(rows, comparison, threads);
  timing.distances = first.seconds();
  const Stopwatch second;
  Dendrogram dendrogram = link(std::move(distances), linkage);
  timing.linkage = second.seconds();
  return dendrogram;
}

constexpr const char* timingColumns = " distances: wall, processor | linkage | both |";

void printTiming(const std::string& who, const Timing& timing) {
  fmt::print("| {} |", who);
  for (const Seconds& s : {timing.distances, timing.linkage, timing.both()})
    fmt::print(" {:.2f}, {:.2f} s |", s.wall, s.cpu);
  fmt::print("\n");
  std::fflush(stdout);
}

/// Runs SciPy on the same rows; returns its clusters, a row a cut.
std::vector<std::vector<int>> scipy(const DescriptorMatrix& rows, const std::vector<double>& cuts,
                                    Timing& timing) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("bench_linkage.{}", getpid());
  fs::create_directory(folder);
  const auto bytes = io::npyBytes(rows);
  std::ofstream(folder / "rows.npy", std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const std::string command = fmt::format(
      "/usr/bin/python3 '{}/bench/scipy_linkage.py' '{}' chebyshev average '{}' {}", ESTANCIA_SOURCE_DIR,
      (folder / "rows.npy").string(), (folder / "clusters.npy").string(), fmt::join(cuts, " "));
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  if (!pipe || std::fscanf(pipe.get(), "%lf %lf %lf %lf", &timing.distances.wall, &timing.linkage.wall,
                           &timing.distances.cpu, &timing.linkage.cpu) != 4)
    throw Error(ErrorCode::invalidInput, "SciPy gave no answer; install python3-scipy");
  io::NpyFile file(folder / "clusters.npy");
  std::vector<std::vector<int>> clusters;
  for (std::size_t i = 0; i < file.rows(); ++i) {
    const std::vector<double>& row = file.next();
    clusters.emplace_back(row.begin(), row.end());
  }
  fs::remove_all(folder);
  return clusters;
}

void besideSciPy(const DescriptorMatrix& rows) {
  const std::vector<double> cuts{0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8};
  fmt::print(
      "{} x {}, ks (Eq. 5.1), average linkage\n\n| who | distances | linkage | both | processor "
      "|\n|---|---|---|---|---|\n",
      rows.size(), rows.labels());
  Timing one, all, theirs;
  cluster(rows, Comparison::chebyshev, Linkage::average, 1, one);
  printTiming("Estancia, 1 thread", one);
  const Dendrogram dendrogram = cluster(rows, Comparison::chebyshev, Linkage::average, 0, all);
  printTiming(fmt::format("Estancia, {} threads", usableCores()), all);
  const auto expected = scipy(rows, cuts, theirs);
  printTiming("SciPy", theirs);
  fmt::print(
      "\ntimes as fast as SciPy: {:.1f} with 1 thread, {:.1f} with {}; by the processor's time {:.1f}\n\n",
      theirs.both().wall / one.both().wall, theirs.both().wall / all.both().wall, usableCores(),
      theirs.both().cpu / one.both().cpu);
  fmt::print("| cut | zones | adjusted Rand index with SciPy's | same partition |\n|---|---|---|---|\n");
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const std::vector<int> ours = dendrogram.cutAt(cuts[i]);
    const double agreement = measureAgreement(expected[i], ours).adjustedRandIndex;
    fmt::print("| {} | {} | {:.6f} | {} |\n", cuts[i], *std::max_element(ours.begin(), ours.end()) + 1,
               agreement, agreement == 1 ? "yes" : "no");
  }
}

/// Each linkage's time and memory; the largest sizes with average linkage alone.
void curve(const std::vector<std::size_t>& sizes) {
  constexpr std::size_t labels = 205;
  constexpr double gibibyte = 1 << 30;
  const Distance distance = getDistance("clr-cosine");
  fmt::print("| images | linkage | peak memory |{}\n|---|---|---|---|---|---|\n", timingColumns);
  for (const std::size_t n : sizes) {
    fmt::print(stderr, "{} images need {:.2f} GiB; {:.1f} GiB are available\n", n,
               static_cast<double>(clusteringMemory(n, labels)) / gibibyte,
               static_cast<double>(availableMemory()) / gibibyte);
    requireClusteringMemory(n, labels);
    const DescriptorMatrix images = madeUp(n, labels, 100);
    const DescriptorMatrix rows = comparedVectors(images, images, distance);
    for (const Choice& named : linkages()) {
      const Linkage linkage = getLinkage(named.name);
      if (n > 10000 && linkage != Linkage::average && linkage != Linkage::single) continue;
      Timing timing;
      cluster(rows, comparisonFor(distance, linkage), linkage, 0, timing);
      printTiming(fmt::format("{} | {} | {:.2f} GiB", n, named.name, peakMemory()), timing);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  try {
    if (what == "scipy" && argc <= 3) {
      besideSciPy(argc == 3 ? readLabels(argv[2]) : madeUp(4579, 1001, 60));
      return 0;
    }
    if (what == "curve" && argc > 2) {
      std::vector<std::size_t> sizes;
      for (int i = 2; i < argc; ++i) sizes.push_back(std::strtoull(argv[i], nullptr, 10));
      curve(sizes);
      return 0;
    }
    std::fputs("usage: bench_linkage scipy [LABELS.npy] | curve N...\n", stderr);
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
  }
  return 2;
}
