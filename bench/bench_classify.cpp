// Prediction of rooms beside scikit-learn: nearest neighbors and Gaussian support vector machines, the same
// data, parameters and answers. docs/measured/benchmarks.md holds what it showed.
//   bench_classify [THREADS]     2,389 made-up descriptors of 1,001 words to learn from, as many to predict
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/error.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/files/npy.hpp"

namespace {

using namespace estancia;
namespace fs = std::filesystem;

constexpr std::size_t images = 2389, labels = 1001;
constexpr int rooms = 10, places = 60, neighbors = 9;
constexpr double c = 3, gamma = 1;

struct Seconds {
  double wall = 1e300, cpu = 1e300;
};

template <class Work>
Seconds bestOfThree(Work work) {
  Seconds best;
  for (int i = 0; i < 3; ++i) {
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    work();
    best.wall =
        std::min(best.wall, std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count());
    best.cpu = std::min(best.cpu, static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
  }
  return best;
}

/// Drives through rooms of several places, a softmax of the place's logits and noise an image; log-ratios
/// whose mean squared norm is about 1, as classifiers get them.
Samples madeUp(unsigned seed) {
  std::mt19937 ofPlaces(7), random(seed);
  std::normal_distribution<float> normal;
  std::vector<std::vector<float>> logits(places, std::vector<float>(labels));
  for (auto& place : logits)
    for (float& l : place) l = 1.2F * normal(ofPlaces);
  Samples samples{DescriptorMatrix(labels), {}, {}, rooms};
  std::vector<float> p(labels);
  for (std::size_t i = 0; i < images; ++i) {
    const std::size_t place = random() % places;
    float sum = 0;
    for (std::size_t k = 0; k < labels; ++k) sum += p[k] = std::exp(logits[place][k] + 2 * normal(random));
    for (float& v : p) v /= sum;
    embed(Embedding::centeredLogRatio, p, p);
    for (float& v : p) v /= 2.3F * std::sqrt(static_cast<float>(labels));
    samples.x.append(p);
    samples.classes.push_back(static_cast<int>(random() % 20 == 0 ? random() % rooms : place % rooms));
    samples.groups.push_back(static_cast<int>(i));
  }
  return samples;
}

void write(const fs::path& file, const DescriptorMatrix& matrix) {
  const auto bytes = io::npyBytes(matrix);
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

struct Peer {
  Seconds seconds;
  std::size_t vectors = 0;
  std::string blas;
  std::vector<int> classes;
};

Peer scikitLearn(const fs::path& folder, const std::string& kind, const std::string& parameters) {
  const auto file = [&](const char* name) { return (folder / name).string(); };
  const std::string command = fmt::format(
      "/usr/bin/python3 '{}/bench/sklearn_classify.py' {} '{}' '{}' '{}' {} '{}'", ESTANCIA_SOURCE_DIR, kind,
      file("train.npy"), file("classes.npy"), file("test.npy"), parameters, file("answer.npy"));
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  Peer peer;
  char blas[200] = "";
  if (!pipe || std::fscanf(pipe.get(), "%lf %lf %zu %199s", &peer.seconds.wall, &peer.seconds.cpu,
                           &peer.vectors, blas) != 4)
    throw Error(ErrorCode::invalidInput, "scikit-learn gave no answer; install python3-sklearn");
  peer.blas = blas;
  io::NpyFile answer(folder / "answer.npy");
  for (std::size_t i = 0; i < answer.rows(); ++i) peer.classes.push_back(static_cast<int>(answer.next()[0]));
  return peer;
}

void compareWith(const fs::path& folder, const Samples& train, const DescriptorMatrix& test,
                 const std::string& type, int threads) {
  Progress silent;
  ClassifierOptions options{.type = type, .balanced = false};
  options.c = c;
  options.gamma = gamma;
  options.neighbors = neighbors;
  options.metric = "euclidean";
  const auto classifier = trainClassifier(train, options, silent);
  DescriptorMatrix answer(0);
  const Seconds ours = bestOfThree([&] { answer = classifier->predict(test, threads); });
  const Peer peer = type == "knn" ? scikitLearn(folder, "knn", fmt::format("{}", neighbors))
                                  : scikitLearn(folder, "svm", fmt::format("{},{}", c, gamma));
  std::size_t same = 0;
  for (std::size_t i = 0; i < answer.size(); ++i) {
    const DescriptorView row = answer.row(i);
    same += std::max_element(row.begin(), row.end()) - row.begin() == peer.classes[i] ? 1 : 0;
  }
  const double floor = 2e-9 * static_cast<double>(images * peer.vectors * labels);
  fmt::print(
      "| {} | {} | {} | {:.3f}, {:.3f} s | {:.3f}, {:.3f} s ({}) | {:.1f}, {:.1f} | {:.1f} GFLOP, {:.0f} a "
      "second | {:.2f} % |\n",
      type, peer.vectors, threads, ours.wall, ours.cpu, peer.seconds.wall, peer.seconds.cpu, peer.blas,
      peer.seconds.wall / ours.wall, peer.seconds.cpu / ours.cpu, floor, floor / ours.cpu,
      100.0 * static_cast<double>(same) / static_cast<double>(answer.size()));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
  const fs::path folder = fs::temp_directory_path() / fmt::format("bench_classify.{}", getpid());
  try {
    const Samples train = madeUp(1), test = madeUp(2);
    fs::create_directory(folder);
    write(folder / "train.npy", train.x);
    write(folder / "test.npy", test.x);
    DescriptorMatrix classes(1);
    for (const int k : train.classes) classes.append(std::vector<float>{static_cast<float>(k)});
    write(folder / "classes.npy", classes);
    fmt::print(
        "{} x {}, {} rooms; wall, processor\n\n| classifier | vectors | threads | Estancia | scikit-learn | "
        "times as "
        "fast | floor | same answers |\n|---|---|---|---|---|---|---|---|\n",
        images, labels, rooms);
    for (const char* type : {"knn", "svm-rbf"}) compareWith(folder, train, test.x, type, threads);
    fs::remove_all(folder);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    fs::remove_all(folder);
    return 2;
  }
}
