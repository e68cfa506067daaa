// A whole frame of `estancia objects predict`, stage by stage: clusters, patches, shapes, classifier, belief;
// and the network apart. docs/measured/benchmarks.md holds what it showed.
//   bench_objects SEQ [THREADS [FRAMES [LABELER]]]     a sequence with depth, e.g. 7-Scenes RedKitchen (640 ×
//   480)
//
// The model is learned from the objects of every tenth frame by names drawn at random, the worst case: nearly
// every sample becomes a support vector.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/objects/training.hpp"
#include "estancia/readers/open_sequence.hpp"

namespace {

using namespace estancia;

std::vector<std::size_t> everyNth(const Sequence& sequence, std::size_t n, std::size_t most) {
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < sequence.size() && frames.size() < most; i += n) frames.push_back(i);
  return frames;
}

ClusteredFrame clustered(const Sequence& sequence, std::size_t i, const ClusterOptions& options) {
  const ImageAndDepth frame = readImageAndDepth(sequence, i);
  return clusteredFrame(frame.image, frame.depth, *sequence.intrinsics(), options);
}

ObjectModel learned(const Sequence& sequence, int threads) {
  ObjectTraining training{
      targetClassesOf({"mug", "bottle", "chair", "monitor", "carton"}), {}, noShapes({}), {}, {}, "", {}};
  std::mt19937 random(1);
  for (const std::size_t i : everyNth(sequence, 10, 100)) {
    const ClusteredFrame frame = clustered(sequence, i, {.threads = threads});
    for (std::size_t k = 0; k < frame.clusters.clusters.size(); ++k) {
      training.shapes.values.append(describeShape(cloudOf(frame, k), {}));
      training.shapes.frames.emplace_back();
      training.instances.push_back(static_cast<int>(training.instances.size()));
      training.classes.push_back(static_cast<int>(random() % training.targets.classes.size()));
    }
  }
  ClassifierOptions options;
  options.c = 10;
  options.gamma = 1;
  return trainObjectModel(training, options);
}

double processorSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Stage {
  std::string name;
  std::vector<double> milliseconds = {};

  double at(double share) {
    std::ranges::sort(milliseconds);
    return milliseconds[static_cast<std::size_t>(share * static_cast<double>(milliseconds.size() - 1))];
  }
};

void measure(const Sequence& sequence, int threads, std::size_t most, Labeler* labeler) {
  const ObjectModel model = learned(sequence, threads);
  const auto frames = everyNth(sequence, 2, most);
  std::vector<Stage> stages{{"clusters"},
                            {"patches"},
                            {"shapes"},
                            {"classifier, belief"},
                            {"all but the network"},
                            {"processor time of that"},
                            {"network"}};
  std::size_t objects = 0;
  ObjectPredictor predictor(model, labeler, {.threads = threads});
  for (const std::size_t i : frames) {
    const ImageAndDepth read = readImageAndDepth(sequence, i);
    const double before = processorSeconds();
    const auto begin = std::chrono::steady_clock::now();
    const ClusteredFrame frame =
        clusteredFrame(read.image, read.depth, *sequence.intrinsics(), {.threads = threads});
    const std::chrono::duration<double> clusters = std::chrono::steady_clock::now() - begin;
    PredictSeconds s;
    objects += predictor.predict(frame, sequence.frame(i).pose, &s).size();
    const double processor = labeler == nullptr ? processorSeconds() - before : 0;
    const double seconds[] = {clusters.count(),
                              s.crops,
                              s.shapes,
                              s.classifier,
                              clusters.count() + s.crops + s.shapes + s.classifier,
                              processor,
                              s.labeler};
    for (std::size_t k = 0; k < stages.size(); ++k) stages[k].milliseconds.push_back(1000 * seconds[k]);
  }
  fmt::print("{} frames of {}, {:.1f} objects each, {} threads; milliseconds\n\n", frames.size(),
             sequence.name(), static_cast<double>(objects) / static_cast<double>(frames.size()), threads);
  fmt::print("| stage | median | 95 % of the frames below | worst |\n|---|---|---|---|\n");
  for (Stage& stage : stages)
    if (labeler != nullptr ? stage.name != "processor time of that" : stage.name != "network")
      fmt::print("| {} | {:.1f} | {:.1f} | {:.1f} |\n", stage.name, stage.at(0.5), stage.at(0.95),
                 stage.at(1));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) return std::fputs("usage: bench_objects SEQ [THREADS [FRAMES [LABELER]]]\n", stderr), 2;
  const auto sequence = openSequence(argv[1]);
  requireClusterable(*sequence);
  const int threads = argc > 2 ? std::atoi(argv[2]) : 2;
  LabelerOptions how;
  how.threads = threads;
  const auto labeler = argc > 4 ? loadModel(argv[4], how) : nullptr;
  const int frames = argc > 3 ? std::atoi(argv[3]) : 100;
  if (threads < 1 || frames < 1)
    throw Error(ErrorCode::invalidInput, "give at least one thread and one frame");
  measure(*sequence, threads, static_cast<std::size_t>(frames), labeler.get());
  return 0;
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
