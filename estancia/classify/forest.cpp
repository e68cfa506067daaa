// Random forest (Breiman 2001), grown by OpenCV.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <opencv2/ml.hpp>
#include <random>
#include <utility>

#include "estancia/classify/trainers.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/seeded_generator.hpp"

namespace estancia {
namespace {

constexpr int batch = 10;     // trees that share a random generator; batches share the threads
constexpr int maxDepth = 25;  // OpenCV's maximum
constexpr std::size_t rowsAtOnce = 64;

/// x[column] ≤ threshold leads to `below`, else to `above`; a leaf has column −1 and its class in `below`.
struct Branch {
  std::int32_t column = -1, below = 0, above = 0;
  float threshold = 0;
};

struct Trees {
  std::vector<Branch> branches;
  std::vector<std::uint32_t> roots;
};

class Forest final : public Classifier {
 public:
  Forest(Trees all, std::size_t width, int count, std::string how)
      : trees(std::move(all)), columnCount(width), classes(count), chosen(std::move(how)) {}
  std::string type() const override { return "forest"; }
  std::size_t columns() const override { return columnCount; }
  int classCount() const override { return classes; }
  std::string choice() const override { return chosen; }

  DescriptorMatrix predict(const DescriptorMatrix& x, int threads) const override {
    const auto k = static_cast<std::size_t>(classes);
    std::vector<float> all(x.size() * k);
    inParallel((x.size() + rowsAtOnce - 1) / rowsAtOnce, threads, Progress::none(),
               "stopped while rooms were predicted", [&](std::size_t task) {
                 const std::size_t end = std::min(x.size(), (task + 1) * rowsAtOnce);
                 for (const std::uint32_t root : trees.roots)
                   for (std::size_t i = task * rowsAtOnce; i < end; ++i)
                     all[i * k + classOf(root, x.row(i))] += 1.0F / static_cast<float>(trees.roots.size());
               });
    return matrixOf(all, k);
  }

  void write(ByteWriter& out) const override {
    out.number(static_cast<std::uint64_t>(columnCount));
    out.number(static_cast<std::int32_t>(classes));
    out.number(static_cast<std::uint64_t>(trees.branches.size()));
    for (const Branch& b : trees.branches) {
      for (const std::int32_t value : {b.column, b.below, b.above}) out.number(value);
      out.number(b.threshold);
    }
    out.numbers(trees.roots);
    out.text(chosen);
  }

 private:
  std::size_t classOf(std::uint32_t root, DescriptorView x) const {
    const Branch* branch = &trees.branches[root];
    while (branch->column >= 0)
      branch = &trees.branches[static_cast<std::size_t>(
          x[static_cast<std::size_t>(branch->column)] <= branch->threshold ? branch->below : branch->above)];
    return static_cast<std::size_t>(branch->below);
  }

  Trees trees;
  std::size_t columnCount;
  int classes;
  std::string chosen;
};

/// Draws as many samples of each class as the smallest class has (Chen, Liaw & Breiman, "Using random forest
/// to learn imbalanced data", 2004; weights do not help pure leaves), and a minimum: tiny classes repeat.
std::vector<std::size_t> balancedDraw(const Samples& samples, std::uint64_t seed) {
  std::vector<std::vector<std::size_t>> ofClass(static_cast<std::size_t>(samples.classCount));
  for (std::size_t i = 0; i < samples.classes.size(); ++i)
    ofClass[static_cast<std::size_t>(samples.classes[i])].push_back(i);
  std::size_t count = samples.classes.size();
  for (const auto& members : ofClass) count = std::min(count, members.size());
  count = std::max(count, samples.classes.size() / (4 * ofClass.size()));
  std::mt19937_64 random(seed);
  std::vector<std::size_t> rows;
  for (auto& members : ofClass)
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t place = i % members.size();
      if (i < members.size()) std::swap(members[place], members[place + random() % (members.size() - place)]);
      rows.push_back(members[place]);
    }
  return rows;
}

/// The stored trees: children after their parents, so that every walk ends.
void append(const cv::ml::RTrees& grown, Trees& trees) {
  const auto& nodes = grown.getNodes();
  const auto& splits = grown.getSplits();
  for (const int root : grown.getRoots()) {
    trees.roots.push_back(static_cast<std::uint32_t>(trees.branches.size()));
    std::vector<std::pair<int, std::size_t>> waiting{{root, trees.branches.size()}};
    trees.branches.emplace_back();
    while (!waiting.empty()) {
      const auto [index, place] = waiting.back();
      waiting.pop_back();
      const auto& node = nodes[static_cast<std::size_t>(index)];
      if (node.split < 0) {
        trees.branches[place] = {-1, node.classIdx, 0, 0};
        continue;
      }
      const auto& split = splits[static_cast<std::size_t>(node.split)];
      const auto below = static_cast<std::int32_t>(trees.branches.size());
      trees.branches.resize(trees.branches.size() + 2);
      trees.branches[place] = {split.varIdx, below, below + 1, split.c};
      waiting.emplace_back(split.inversed ? node.right : node.left, below);
      waiting.emplace_back(split.inversed ? node.left : node.right, below + 1);
    }
  }
}

}  // namespace

std::unique_ptr<Classifier> trainForest(const Samples& samples, const ClassifierOptions& options,
                                        Progress& progress) {
  const auto batches = static_cast<std::size_t>((options.trees + batch - 1) / batch);
  std::vector<cv::Ptr<cv::ml::RTrees>> grown(batches);
  progress.begin("growing trees", batches);
  inParallel(batches, options.threads, progress, "stopped while trees grew", [&](std::size_t b) {
    const std::uint64_t seed = options.seed * 1000003 + b;
    DescriptorMatrix drawn(0);
    std::vector<int> classes;
    if (options.balanced) {
      const std::vector<std::size_t> rows = balancedDraw(samples, seed);
      drawn = rowsOf(samples.x, rows);
      for (const std::size_t row : rows) classes.push_back(samples.classes[row]);
    } else {
      classes = samples.classes;
    }
    const DescriptorMatrix& values = options.balanced ? drawn : samples.x;
    const cv::Mat x(static_cast<int>(values.size()), static_cast<int>(values.labels()), CV_32F,
                    const_cast<float*>(values.values().data()));  // only read
    const auto data = cv::ml::TrainData::create(x, cv::ml::ROW_SAMPLE, cv::Mat(classes, true));
    const auto forest = cv::ml::RTrees::create();
    forest->setMaxDepth(maxDepth);
    forest->setMinSampleCount(2);
    forest->setActiveVarCount(0);  // √columns at each split
    forest->setCVFolds(0);
    forest->setUseSurrogates(false);
    forest->setTruncatePrunedTree(false);
    const int count = std::min(batch, options.trees - static_cast<int>(b) * batch);
    forest->setTermCriteria({cv::TermCriteria::COUNT, count, 0});
    const SeededGenerator generator(seed);
    forest->train(data);
    grown[b] = forest;
  });
  progress.end();
  Trees all;
  for (const auto& forest : grown) append(*forest, all);
  return std::make_unique<Forest>(std::move(all), samples.x.labels(), samples.classCount,
                                  fmt::format("{} trees", options.trees));
}

std::unique_ptr<Classifier> readForest(ByteReader& in) {
  const auto columns = in.number<std::uint64_t>();
  const auto classes = in.number<std::int32_t>();
  Trees trees;
  trees.branches.resize(in.count(sizeof(Branch)));
  const auto size = static_cast<std::int64_t>(trees.branches.size());
  for (std::int64_t i = 0; i < size; ++i) {
    Branch& b = trees.branches[static_cast<std::size_t>(i)];
    for (std::int32_t* value : {&b.column, &b.below, &b.above}) *value = in.number<std::int32_t>();
    b.threshold = in.number<float>();
    const bool sound = b.column < 0 ? b.below >= 0 && b.below < classes
                                    : static_cast<std::uint64_t>(b.column) < columns && b.below > i &&
                                          b.below < size && b.above > i && b.above < size;
    if (!sound) in.fail("it is damaged (a branch of a tree leads out of it)");
  }
  trees.roots = in.numbers<std::uint32_t>();
  for (const std::uint32_t root : trees.roots)
    if (root >= trees.branches.size()) in.fail("it is damaged (a tree without root)");
  if (trees.roots.empty() || classes < 2) in.fail("it is damaged (it has no trees)");
  std::string chosen = in.text();
  return std::make_unique<Forest>(std::move(trees), columns, classes, std::move(chosen));
}

}  // namespace estancia
