// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/classifier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <string_view>

#include "estancia/classify/trainers.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/temporal_segments.hpp"
#include "estancia/stats/products.hpp"

namespace estancia {
namespace {

struct Kind {
  std::string_view name;
  const char* explanation;
  std::unique_ptr<Classifier> (*train)(const Samples&, const ClassifierOptions&, Progress&);
  std::unique_ptr<Classifier> (*read)(ByteReader&);
};

constexpr Kind kinds[] = {
    {"svm-linear", "linear support vector machines, one a pair of classes", trainSvm, readSvm},
    {"svm-rbf", "support vector machines with Gaussian kernels: class boundaries may be curved", trainSvm,
     readSvm},
    {"linear", "logistic regression, one class against the others", trainLinear, readLinear},
    {"forest", "random forest: votes of trees grown on random subsets of samples and columns", trainForest,
     readForest},
    {"knn", "votes of the nearest training images", trainKnn, readKnn},
};

void requireFinite(const DescriptorMatrix& x) {
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t c = 0; c < x.labels(); ++c)
      if (!std::isfinite(x.row(i)[c]))
        fail(ErrorCode::invalidInput, "sample {}, column {} is {}; describe its frame again or leave it out",
             i, c, x.row(i)[c]);
}

void requireValid(const Samples& samples) {
  if (samples.x.labels() == 0 || samples.x.size() == 0)
    throw Error(ErrorCode::insufficientData, "there are no samples to learn from; give some of two classes");
  if (samples.classes.size() != samples.x.size() || samples.groups.size() != samples.x.size())
    fail(ErrorCode::mismatch, "{} samples have {} classes and {} groups; give one of each a sample",
         samples.x.size(), samples.classes.size(), samples.groups.size());
  for (const int c : samples.classes)
    if (c < 0 || c >= samples.classCount)
      fail(ErrorCode::invalidInput, "a sample has class {}; give 0 to {}", c, samples.classCount - 1);
  requireFinite(samples.x);
}

/// Common to all types: checks the input, and gives classes without samples probability 0.
class Checked final : public Classifier {
 public:
  /// `classes` are those of `inner`, of `count` in all.
  Checked(std::unique_ptr<Classifier> inner, std::vector<std::int32_t> classes, int count)
      : inner_(std::move(inner)), classes_(std::move(classes)), count_(count) {}
  std::string type() const override { return inner_->type(); }
  std::size_t columns() const override { return inner_->columns(); }
  int classCount() const override { return count_; }
  std::string choice() const override { return inner_->choice(); }

  DescriptorMatrix predict(const DescriptorMatrix& x, int threads) const override {
    if (x.labels() != columns())
      fail(ErrorCode::mismatch,
           "this classifier was trained on {} columns, not on {}; describe the images alike", columns(),
           x.labels());
    requireFinite(x);
    DescriptorMatrix inner = inner_->predict(x, threads);
    if (static_cast<int>(classes_.size()) == count_) return inner;
    DescriptorMatrix result(static_cast<std::size_t>(count_));
    result.reserve(x.size());
    std::vector<float> row(static_cast<std::size_t>(count_));
    for (std::size_t i = 0; i < inner.size(); ++i) {
      for (std::size_t k = 0; k < classes_.size(); ++k)
        row[static_cast<std::size_t>(classes_[k])] = inner.row(i)[k];
      result.append(row);
    }
    return result;
  }

  void write(ByteWriter& out) const override {
    out.text(type());
    out.number(static_cast<std::int32_t>(count_));
    out.numbers(classes_);
    inner_->write(out);
  }

 private:
  std::unique_ptr<Classifier> inner_;
  std::vector<std::int32_t> classes_;
  int count_;
};

std::vector<std::size_t> searched(const Samples& samples, std::size_t maxSamples) {
  std::vector<std::vector<std::size_t>> ofClass(static_cast<std::size_t>(samples.classCount));
  for (std::size_t i = 0; i < samples.classes.size(); ++i)
    ofClass[static_cast<std::size_t>(samples.classes[i])].push_back(i);
  const double step =
      std::max(1.0, static_cast<double>(samples.classes.size()) / static_cast<double>(maxSamples));
  std::vector<std::size_t> rows;
  for (const auto& members : ofClass)
    for (double at = 0; at < static_cast<double>(members.size()); at += step)
      rows.push_back(members[static_cast<std::size_t>(at)]);
  std::sort(rows.begin(), rows.end());
  return rows;
}

/// Frames of a piece of a cut segment: neighbors are near-copies: single ones would give each other away.
constexpr std::size_t minPiece = 3;

/// Cuts segments into equal pieces, the longest first, until there are `minCount` or all are short.
std::vector<TemporalSegment> cut(const std::vector<TemporalSegment>& segments, std::size_t minCount) {
  std::vector<std::size_t> pieces(segments.size(), 1);
  const auto sizeIfCut = [&](std::size_t r) { return segments[r].size / (pieces[r] + 1); };
  for (std::size_t count = segments.size(); count < minCount; ++count) {
    std::size_t longest = 0;
    for (std::size_t r = 1; r < segments.size(); ++r)
      if (sizeIfCut(r) > sizeIfCut(longest)) longest = r;
    if (sizeIfCut(longest) < minPiece) break;
    ++pieces[longest];
  }
  std::vector<TemporalSegment> cut;
  for (std::size_t r = 0; r < segments.size(); ++r)
    for (std::size_t p = 0; p < pieces[r]; ++p) {
      const std::size_t begin = segments[r].size * p / pieces[r],
                        end = segments[r].size * (p + 1) / pieces[r];
      cut.push_back({segments[r].first + begin, end - begin});
    }
  return cut;
}

}  // namespace

OptionGroup declare(ClassifierOptions& options) {
  constexpr double finite = std::numeric_limits<double>::max();
  OptionGroup group("classifier", "Training of a classifier.");
  group.add("type", &options.type, "Type of classifier.").choices(classifierTypes());
  group.add("balanced", &options.balanced, "Give each class the same weight, whatever its number of samples.")
      .why("where accuracy on rare classes matters as much as on frequent ones");
  group.add("folds", &options.folds, "Folds of the cross-validation that finds parameters.")
      .range(2, 1'000'000);
  group.add("seed", &options.seed, "Seed of the folds and of random forests.");
  group.add("threads", &options.threads, "Threads; 0: one a usable core. Results do not depend on it.")
      .range(0);
  group.add("c", &options.c, "svm-linear, svm-rbf, linear: cost of an error.")
      .above(0, finite)
      .automatic("found by cross-validation")
      .why("larger values fit the training data more closely");
  group.add("gamma", &options.gamma, "svm-rbf: gamma of the kernel exp(-gamma |a - b|^2).")
      .above(0, finite)
      .automatic("found by cross-validation");
  group.add("neighbors", &options.neighbors, "knn: neighbors that vote.")
      .range(1)
      .automatic("found by cross-validation");
  group.add("metric", &options.metric, "knn: distance of samples.")
      .choices({{"euclidean", "Euclidean distance"}, {"cosine", "angle"}, {"", "the better one"}})
      .automatic("found by cross-validation");
  group.add("trees", &options.trees, "forest: number of trees.").range(1);
  return group;
}

Choices classifierTypes() {
  Choices types;
  for (const Kind& kind : kinds) types.push_back({std::string(kind.name), kind.explanation});
  return types;
}

std::unique_ptr<Classifier> trainClassifier(const Samples& samples, const ClassifierOptions& options,
                                            Progress& progress) {
  validate(options);
  const Kind& kind = *std::ranges::find(kinds, options.type, &Kind::name);
  requireValid(samples);
  std::vector<std::int32_t> present = samples.classes;
  std::sort(present.begin(), present.end());
  present.erase(std::unique(present.begin(), present.end()), present.end());
  if (present.size() < 2)
    throw Error(ErrorCode::insufficientData, "all samples are of one class; give samples of two or more");
  Samples dense = samples;
  dense.classCount = static_cast<int>(present.size());
  for (int& c : dense.classes)
    c = static_cast<int>(std::lower_bound(present.begin(), present.end(), c) - present.begin());
  return std::make_unique<Checked>(kind.train(dense, options, progress), std::move(present),
                                   samples.classCount);
}

std::unique_ptr<Classifier> readClassifier(ByteReader& in) {
  const std::string type = in.text();
  const auto* const found = std::ranges::find(kinds, type, &Kind::name);
  if (found == std::end(kinds)) in.fail("it is damaged (its classifier is of an unknown type)");
  const Kind& kind = *found;
  const auto count = in.number<std::int32_t>();
  std::vector<std::int32_t> present = in.numbers<std::int32_t>();
  if (count < 2 || count > 1 << 16 || present.size() < 2 || present.front() < 0 || present.back() >= count ||
      std::adjacent_find(present.begin(), present.end(), std::greater_equal<>()) != present.end())
    in.fail("it is damaged (its classes are not in order)");
  std::unique_ptr<Classifier> inner = kind.read(in);
  if (inner->type() != kind.name || inner->classCount() != static_cast<int>(present.size()))
    in.fail("it is damaged (its classifier is of another type or class count)");
  return std::make_unique<Checked>(std::move(inner), std::move(present), count);
}

// ---- what the kinds share (trainers.hpp)

std::vector<double> classWeights(const Samples& samples, bool balanced) {
  std::vector<double> weights(static_cast<std::size_t>(samples.classCount), 1);
  if (!balanced) return weights;
  std::vector<double> counts(weights.size());
  for (const int c : samples.classes) ++counts[static_cast<std::size_t>(c)];
  for (std::size_t c = 0; c < weights.size(); ++c)
    weights[c] =
        static_cast<double>(samples.classes.size()) / (static_cast<double>(weights.size()) * counts[c]);
  return weights;
}

OrderedByClass orderByClass(std::vector<std::size_t> rows, const std::vector<int>& classes,
                            const std::vector<double>& weights) {
  OrderedByClass order{std::move(rows), {}, {}, {}};
  std::ranges::stable_sort(order.rows, {}, [&](std::size_t row) { return classes[row]; });
  for (const std::size_t row : order.rows) {
    order.y.push_back(classes[row]);
    if (!order.labels.empty() && order.labels.back() == classes[row]) continue;
    order.labels.push_back(classes[row]);
    order.weights.push_back(weights[static_cast<std::size_t>(classes[row])]);
  }
  return order;
}

DescriptorMatrix rowsOf(const DescriptorMatrix& matrix, const std::vector<std::size_t>& rows) {
  DescriptorMatrix result(matrix.labels());
  result.reserve(rows.size());
  for (const std::size_t row : rows) result.append(matrix.row(row));
  return result;
}

DescriptorMatrix matrixOf(std::span<const float> values, std::size_t columns) {
  DescriptorMatrix matrix(columns);
  matrix.reserve(values.size() / columns);
  for (std::size_t i = 0; i < values.size(); i += columns) matrix.append(values.subspan(i, columns));
  return matrix;
}

void writeMatrix(ByteWriter& out, const DescriptorMatrix& matrix) {
  out.number(static_cast<std::uint64_t>(matrix.labels()));
  out.numbers(matrix.values());
}

DescriptorMatrix readMatrix(ByteReader& in) {
  const auto columns = in.number<std::uint64_t>();
  const std::vector<float> values = in.numbers<float>();
  if (columns == 0 || values.size() % columns != 0) in.fail("it is damaged (a matrix of uneven rows)");
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }))
    in.fail("it is damaged (a value is not finite)");
  return matrixOf(values, columns);
}

std::vector<float> productsOf(const DescriptorMatrix& x, int threads) {
  const std::size_t n = x.size();
  std::vector<float> products(n * n);
  rowProducts(x, PackedRows(x), threads, [&](std::size_t i, std::span<float> row) {
    std::copy(row.begin(), row.end(), products.begin() + static_cast<std::ptrdiff_t>(i * n));
  });
  return products;
}

std::vector<std::size_t> Search::trainingRows(const std::vector<int>& foldOf, int fold) const {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < size(); ++i)
    if (foldOf[i] != fold) rows.push_back(i);
  const auto isAlike = [&](std::size_t row) { return classes[row] == classes[rows.front()]; };
  return std::ranges::all_of(rows, isAlike) ? std::vector<std::size_t>() : rows;
}

Search searchOf(const Samples& samples, const ClassifierOptions& options, std::size_t maxSamples) {
  Search search;
  std::vector<int> groups;
  const std::vector<std::size_t> rows = searched(samples, maxSamples);
  search.x = rowsOf(samples.x, rows);
  for (const std::size_t row : rows) {
    search.classes.push_back(samples.classes[row]);
    groups.push_back(samples.groups[row]);
  }
  for (std::size_t r = 0; r < Search::repetitions; ++r)
    search.folds.push_back(groupedFolds(search.classes, groups, options.folds, options.seed + r));
  search.weights = classWeights(samples, options.balanced);
  return search;
}

std::string heldOutText(double share, const ClassifierOptions& options) {
  return fmt::format("{:.1f} % of held-out samples{}", 100 * share,
                     options.balanced ? ", with equal weights of the classes" : "");
}

std::vector<int> segmentGroups(const std::vector<Frame>& frames, int minSegments) {
  std::vector<std::string> rooms;
  for (const Frame& frame : frames) rooms.push_back(frame.room);
  std::map<std::string, std::vector<TemporalSegment>> segments;
  for (const TemporalSegment& segment : temporalSegments(frames, rooms))
    segments[rooms[segment.first]].push_back(segment);
  std::vector<int> groups(frames.size());
  int group = 0;
  for (const auto& [room, ofRoom] : segments) {
    for (const TemporalSegment& segment : cut(ofRoom, static_cast<std::size_t>(std::max(minSegments, 1)))) {
      const auto first = groups.begin() + static_cast<std::ptrdiff_t>(segment.first);
      std::fill(first, first + static_cast<std::ptrdiff_t>(segment.size), group++);
    }
  }
  return groups;
}

std::vector<int> instanceGroups(const std::vector<int>& classes, const std::vector<int>& instances,
                                int pieces) {
  std::map<int, std::vector<std::size_t>> members;  // samples of each instance
  for (std::size_t i = 0; i < instances.size(); ++i) members[instances[i]].push_back(i);
  std::map<int, int> mainClass, instancesOf;
  for (const auto& [instance, samples] : members) {
    std::map<int, int> counts;
    for (const std::size_t i : samples) ++counts[classes[i]];
    mainClass[instance] = std::ranges::max_element(counts, {}, [](const auto& c) { return c.second; })->first;
    ++instancesOf[mainClass[instance]];
  }
  std::vector<int> groups(instances.size());
  int group = 0;
  for (const auto& [instance, samples] : members) {
    const std::size_t minPieces = instancesOf[mainClass[instance]] > 1 ? 1 : std::max(pieces, 1);
    for (const TemporalSegment& piece : cut({{0, samples.size()}}, minPieces)) {
      for (std::size_t i = 0; i < piece.size; ++i) groups[samples[piece.first + i]] = group;
      ++group;
    }
  }
  return groups;
}

std::vector<int> groupedFolds(const std::vector<int>& classes, const std::vector<int>& groups, int folds,
                              std::uint64_t seed) {
  std::map<int, std::map<int, double>> counts;  // counts of the classes in each group
  std::map<int, double> totals;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    ++counts[groups[i]][classes[i]];
    ++totals[classes[i]];
  }
  std::vector<int> order;
  for (const auto& [group, of] : counts) order.push_back(group);
  std::mt19937_64 random(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  const auto size = [&](int group) {
    double sum = 0;
    for (const auto& [c, count] : counts[group]) sum += count;
    return sum;
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size(a) > size(b); });

  // A class counts by its shares: `part` of it in a fold that holds `share` adds to the sum of squares.
  std::vector<std::map<int, double>> shares(static_cast<std::size_t>(folds));
  std::vector<double> sizes(shares.size());
  std::map<int, int> foldOf;
  for (const int group : order) {
    std::size_t best = 0;
    double minCost = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < shares.size(); ++f) {
      double cost = 0;
      for (const auto& [c, count] : counts[group]) {
        const double part = count / totals[c];
        cost += part * (part + 2 * shares[f][c]);
      }
      cost += 1e-9 * sizes[f];  // among equals the emptiest
      if (cost < minCost) {
        minCost = cost;
        best = f;
      }
    }
    for (const auto& [c, count] : counts[group]) shares[best][c] += count / totals[c];
    sizes[best] += size(group);
    foldOf[group] = static_cast<int>(best);
  }
  std::vector<int> result(groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i) result[i] = foldOf[groups[i]];
  return result;
}

}  // namespace estancia
