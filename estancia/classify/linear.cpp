// Logistic regression, one class against the others, by liblinear.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <linear.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "estancia/classify/trainers.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/stats/products.hpp"

namespace estancia {
namespace {

constexpr double costs[] = {0.3, 1, 3, 10, 30};
constexpr double highestCost = 800;

/// Weights of the columns and the bias, one row a class.
using Weights = std::vector<std::vector<double>>;

/// P(c) ∝ 1 / (1 + exp(−f_c)), as liblinear does it.
std::vector<double> shares(std::vector<double> f) {
  double sum = 0;
  for (double& value : f) sum += value = 1 / (1 + std::exp(-std::clamp(value, -700.0, 700.0)));
  for (double& value : f) value /= sum;
  return f;
}

class Linear final : public Classifier {
 public:
  Linear(const DescriptorMatrix& rows, std::vector<double> added, std::string how)
      : weights(rows), bias(std::move(added)), chosen(std::move(how)), packed(weights) {}
  std::string type() const override { return "linear"; }
  std::size_t columns() const override { return weights.labels(); }
  int classCount() const override { return static_cast<int>(bias.size()); }
  std::string choice() const override { return chosen; }
  DescriptorMatrix predict(const DescriptorMatrix& x, int threads) const override {
    const std::size_t k = bias.size();
    std::vector<float> all(x.size() * k);
    rowProducts(x, packed, threads, [&](std::size_t i, std::span<float> products) {
      std::vector<double> f(k);
      for (std::size_t c = 0; c < k; ++c) f[c] = products[c] + bias[c];
      const std::vector<double> p = shares(std::move(f));
      std::copy(p.begin(), p.end(), all.begin() + static_cast<std::ptrdiff_t>(i * k));
    });
    return matrixOf(all, k);
  }
  void write(ByteWriter& out) const override {
    writeMatrix(out, weights);
    out.numbers(bias);
    out.text(chosen);
  }

 private:
  DescriptorMatrix weights;
  std::vector<double> bias;
  std::string chosen;
  PackedRows packed;
};

/// Samples in the layout that liblinear reads.
class LinearSamples {
 public:
  explicit LinearSamples(const DescriptorMatrix& x) : width_(x.labels() + 2) {
    nodes_.reserve(x.size() * width_);
    for (std::size_t i = 0; i < x.size(); ++i) {
      int k = 0;
      for (const float value : x.row(i)) nodes_.push_back({++k, value});
      nodes_.push_back({++k, 1});
      nodes_.push_back({-1, 0});
    }
  }

  /// One row of weights for each of the classes 0 … weights.size() − 1; empty for those without samples.
  /// `from` is where the search starts (the weights for a smaller C), or empty.
  Weights train(const std::vector<std::size_t>& rows, const std::vector<int>& classes, double c,
                const std::vector<double>& classWeight, const Weights& from) const {
    set_print_string_function([](const char*) {});
    OrderedByClass order = orderByClass(rows, classes, classWeight);
    std::vector<feature_node*> x;
    for (const std::size_t row : order.rows)
      x.push_back(const_cast<feature_node*>(nodes_.data() + row * width_));  // only read
    const std::size_t n = width_ - 1;
    const problem all{static_cast<int>(x.size()), static_cast<int>(n), order.y.data(), x.data(), -1};
    std::vector<double> start;
    parameter how{};
    how.solver_type = L2R_LR;  // the primal one: a trust region, no random order
    how.eps = 0.01;
    how.C = c;
    how.nr_weight = static_cast<int>(order.labels.size());
    how.weight_label = order.labels.data();
    how.weight = order.weights.data();
    std::vector<const std::vector<double>*> known;
    for (const auto& row : from)
      if (!row.empty()) known.push_back(&row);
    if (known.size() == 2) known.pop_back();  // with two classes only the first has weights
    for (std::size_t w = 0; !known.empty() && w < n; ++w)
      for (const auto* row : known) start.push_back((*row)[w]);
    how.init_sol = start.empty() ? nullptr : start.data();
    if (const char* wrong = check_parameter(&all, &how); wrong != nullptr)
      fail(ErrorCode::invalidInput, "liblinear does not train: {}", wrong);
    const std::unique_ptr<model, void (*)(model*)> trained(::train(&all, &how),
                                                           [](model* m) { free_and_destroy_model(&m); });
    Weights result(classWeight.size());
    const auto count = static_cast<std::size_t>(trained->nr_class), stride = count == 2 ? 1 : count;
    for (std::size_t c0 = 0; c0 < count; ++c0) {
      auto& row = result[static_cast<std::size_t>(trained->label[c0])];
      for (std::size_t w = 0; w < n; ++w)
        row.push_back(count == 2 && c0 == 1 ? -trained->w[w] : trained->w[w * stride + c0]);
    }
    return result;
  }

 private:
  std::size_t width_;
  std::vector<feature_node> nodes_;
};

int mostProbable(const Weights& weights, DescriptorView x) {
  int best = -1;
  double largest = 0;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    if (weights[c].empty()) continue;
    const double f = std::inner_product(x.begin(), x.end(), weights[c].begin(), weights[c].back());
    if (best < 0 || f > largest) {
      best = static_cast<int>(c);
      largest = f;
    }
  }
  return best;
}

/// Cross-validation, one task per fold and repetition; each C starts from the weights of the last.
class HeldOut {
 public:
  HeldOut(const Search& search, const ClassifierOptions& options)
      : search_(search),
        options_(options),
        samples_(search.x),
        weights_(Search::repetitions * static_cast<std::size_t>(options.folds)) {}

  /// The summed weights of the held-out samples that each C (ascending) classifies correctly.
  std::vector<double> right(const std::vector<double>& cs, Progress& progress) {
    std::vector<std::vector<double>> right(weights_.size(), std::vector<double>(cs.size()));
    progress.begin("choosing C", right.size());
    inParallel(right.size(), options_.threads, progress, "stopped while C was sought",
               [&](std::size_t task) { learn(task, cs, right[task]); });
    progress.end();
    std::vector<double> sums(cs.size());
    for (const auto& task : right)
      for (std::size_t c = 0; c < cs.size(); ++c) sums[c] += task[c];
    return sums;
  }

 private:
  void learn(std::size_t task, const std::vector<double>& cs, std::vector<double>& right) {
    const auto folds = static_cast<std::size_t>(options_.folds);
    const std::vector<int>& foldOf = search_.folds[task / folds];
    const auto fold = static_cast<int>(task % folds);
    const std::vector<std::size_t> rows = search_.trainingRows(foldOf, fold);
    if (rows.empty()) return;
    Weights& weights = weights_[task];
    for (std::size_t c = 0; c < cs.size() && !interrupted(); ++c) {
      weights = samples_.train(rows, search_.classes, cs[c], search_.weights, weights);
      for (std::size_t i = 0; i < search_.size(); ++i)
        if (foldOf[i] == fold && mostProbable(weights, search_.x.row(i)) == search_.classes[i])
          right[c] += search_.weights[static_cast<std::size_t>(search_.classes[i])];
    }
  }

  const Search& search_;
  const ClassifierOptions& options_;
  LinearSamples samples_;
  std::vector<Weights> weights_;
};

}  // namespace

std::unique_ptr<Classifier> trainLinear(const Samples& samples, const ClassifierOptions& options,
                                        Progress& progress) {
  const Search search = searchOf(samples, options);
  const std::vector<double> cs =
      options.c ? std::vector<double>{*options.c} : std::vector<double>(std::begin(costs), std::end(costs));
  HeldOut heldOutSamples(search, options);
  double best = 0, largest = -1;
  const auto tryCosts = [&](const std::vector<double>& some) {
    const std::vector<double> right = heldOutSamples.right(some, progress);
    for (std::size_t i = 0; i < some.size(); ++i) {
      if (right[i] <= largest) continue;
      largest = right[i];
      best = some[i];
    }
  };
  tryCosts(cs);
  for (double c = cs.back(); !options.c && best == c && c < highestCost;) tryCosts({c *= 3});

  std::vector<std::size_t> rows(samples.x.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  const Weights weights = learnFromAll(samples, progress, [&] {
    return LinearSamples(samples.x).train(rows, samples.classes, best, search.weights, {});
  });
  DescriptorMatrix matrix(samples.x.labels());
  std::vector<double> bias;
  for (const auto& row : weights) {
    matrix.append(std::vector<float>(row.begin(), row.end() - 1));
    bias.push_back(row.back());
  }
  return std::make_unique<Linear>(
      matrix, std::move(bias),
      fmt::format("C {:.4g}: {}", best,
                  heldOutText(largest / static_cast<double>(search.size() * Search::repetitions), options)));
}

std::unique_ptr<Classifier> readLinear(ByteReader& in) {
  const DescriptorMatrix weights = readMatrix(in);
  std::vector<double> bias = in.numbers<double>();
  if (bias.size() != weights.size() || !std::ranges::all_of(bias, [](double b) { return std::isfinite(b); }))
    in.fail("it is damaged (its weights are invalid)");
  std::string chosen = in.text();
  return std::make_unique<Linear>(weights, std::move(bias), std::move(chosen));
}

}  // namespace estancia
