#include "estancia/classify/classifier.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>

#include "estancia/classify/trainers.hpp"
#include "estancia/core/error.hpp"

namespace estancia {
namespace {

struct Kind {
  const char *name, *explanation;
  std::unique_ptr<Classifier> (*train)(const Samples&, const ClassifierOptions&, Progress&);
  std::unique_ptr<Classifier> (*read)(ByteReader&);
};

constexpr Kind kinds[] = {
    {"svm-linear", "support vector machines, one a pair of classes", trainSvm, readSvm},
    {"svm-rbf", "the same with Gaussian kernels: borders may be curved", trainSvm, readSvm},
    {"linear", "logistic regression, one class against the others", trainLinear, readLinear},
    {"forest", "random forest: trees grown on random draws of samples and columns vote", trainForest,
     readForest},
    {"knn", "the nearest training images vote", trainKnn, readKnn},
};

const Kind& getKind(const std::string& name) {
  std::vector<std::string> known;
  for (const Kind& kind : kinds) {
    if (name == kind.name) return kind;
    known.emplace_back(kind.name);
  }
  throw Error(fmt::format("no classifier is called \"{}\"; there are {}", name, fmt::join(known, ", ")));
}

void requireFinite(const DescriptorMatrix& x) {
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t c = 0; c < x.labels(); ++c)
      if (!std::isfinite(x.row(i)[c]))
        throw Error(
            fmt::format("sample {}, column {} is {}, which nothing can be learned from; describe its "
                        "frame again or leave it out",
                        i, c, x.row(i)[c]));
}

void requirePositive(const std::optional<double>& value, const char* name) {
  if (value && !(*value > 0 && std::isfinite(*value)))
    throw Error(fmt::format("{} must be above 0, not {}", name, *value));
}

void check(const Samples& samples, const ClassifierOptions& options) {
  if (samples.x.labels() == 0 || samples.x.size() == 0)
    throw Error("a classifier needs samples to learn from, and there are none");
  if (samples.classes.size() != samples.x.size() || samples.groups.size() != samples.x.size())
    throw Error(fmt::format("{} samples have {} classes and {} groups; give one of each a sample",
                            samples.x.size(), samples.classes.size(), samples.groups.size()));
  for (const int c : samples.classes)
    if (c < 0 || c >= samples.classCount)
      throw Error(fmt::format("class {} is none of 0 … {}", c, samples.classCount - 1));
  requireFinite(samples.x);
  requirePositive(options.c, "C");
  requirePositive(options.gamma, "gamma");
  if (options.folds < 2) throw Error(fmt::format("cross-validation needs 2 folds, not {}", options.folds));
  if (options.neighbors && *options.neighbors < 1)
    throw Error(fmt::format("at least 1 neighbor must vote, not {}", *options.neighbors));
  if (!options.metric.empty() && options.metric != "euclidean" && options.metric != "cosine")
    throw Error(
        fmt::format("nearest neighbors cannot be \"{}\"; there are euclidean, cosine", options.metric));
  if (options.trees < 1) throw Error(fmt::format("a forest needs at least 1 tree, not {}", options.trees));
}

/// What all kinds have in common: input is checked, and classes that had no samples get probability 0.
class Checked final : public Classifier {
 public:
  /// `classes` are those that `inner` knows, out of `count`.
  Checked(std::unique_ptr<Classifier> inner, std::vector<std::int32_t> classes, int count)
      : inner_(std::move(inner)), classes_(std::move(classes)), count_(count) {}
  std::string type() const override { return inner_->type(); }
  std::size_t columns() const override { return inner_->columns(); }
  int classCount() const override { return count_; }
  std::string choice() const override { return inner_->choice(); }

  DescriptorMatrix predict(const DescriptorMatrix& x, int threads) const override {
    if (x.labels() != columns())
      throw Error(fmt::format("this classifier has learned from {} columns and cannot read {}", columns(),
                              x.labels()));
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

}  // namespace

std::vector<std::pair<std::string, std::string>> classifierTypes() {
  std::vector<std::pair<std::string, std::string>> types;
  for (const Kind& kind : kinds) types.emplace_back(kind.name, kind.explanation);
  return types;
}

std::unique_ptr<Classifier> trainClassifier(const Samples& samples, const ClassifierOptions& options,
                                            Progress& progress) {
  const Kind& kind = getKind(options.type);
  check(samples, options);
  std::vector<std::int32_t> present = samples.classes;
  std::sort(present.begin(), present.end());
  present.erase(std::unique(present.begin(), present.end()), present.end());
  if (present.size() < 2)
    throw Error("all samples are of one class; a classifier needs two or more to tell apart");
  Samples dense = samples;
  dense.classCount = static_cast<int>(present.size());
  for (int& c : dense.classes)
    c = static_cast<int>(std::lower_bound(present.begin(), present.end(), c) - present.begin());
  return std::make_unique<Checked>(kind.train(dense, options, progress), std::move(present),
                                   samples.classCount);
}

std::unique_ptr<Classifier> readClassifier(ByteReader& in) {
  const Kind& kind = getKind(in.text());
  const auto count = in.number<std::int32_t>();
  std::vector<std::int32_t> present = in.numbers<std::int32_t>();
  if (count < 2 || count > 1 << 16 || present.size() < 2 || present.front() < 0 || present.back() >= count ||
      std::adjacent_find(present.begin(), present.end(), std::greater_equal<>()) != present.end())
    in.fail("it is damaged (its classes are not in order)");
  std::unique_ptr<Classifier> inner = kind.read(in);
  if (inner->type() != kind.name || inner->classCount() != static_cast<int>(present.size()))
    in.fail("it is damaged (it does not hold what it says)");
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

}  // namespace estancia
