// Support vector machines (linear, RBF) by libsvm: search for C and gamma, training, prediction.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <libsvm/svm.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "estancia/classify/trainers.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/memory.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/stats/products.hpp"

namespace estancia {
namespace {

constexpr double maxProbability = 1 - 1e-7;  // limit of the probability of a pair of classes, as in libsvm

/// One machine a pair of classes i < j, all over the same support vectors:
/// f_ij(x) = Σ coefficient · k(vector, x) − rho_ij, and f > 0 speaks for i (see pairIndex()).
struct KernelMachines {
  /// Where the vectors of each class start; at the end, their number.
  std::vector<std::size_t> starts;
  /// (classes − 1) a vector: against each other class, ascending.
  std::vector<double> coefficients;
  /// One a pair.
  std::vector<double> rho;

  std::size_t classes() const { return starts.size() - 1; }
  /// f of all pairs; `kernel` holds k(vector, x) of all vectors.
  std::vector<double> decisions(std::span<const float> kernel) const {
    const std::size_t k = classes();
    std::vector<double> f(rho.size()), sums((k - 1));
    for (std::size_t i = 0; i < k; ++i) {
      std::fill(sums.begin(), sums.end(), 0.0);
      for (std::size_t v = starts[i]; v < starts[i + 1]; ++v) {
        const double* coefficient = coefficients.data() + v * (k - 1);
        for (std::size_t other = 0; other + 1 < k; ++other) sums[other] += coefficient[other] * kernel[v];
      }
      for (std::size_t other = 0; other + 1 < k; ++other)
        f[other < i ? pairIndex(other, i, k) : pairIndex(i, other + 1, k)] += sums[other];
    }
    for (std::size_t p = 0; p < f.size(); ++p) f[p] -= rho[p];
    return f;
  }
};

struct TrainedMachines {
  KernelMachines machines;
  /// Classes that have samples, ascending; the machines refer to their positions.
  std::vector<int> classes;
  /// Support vectors, as samples, class by class.
  std::vector<std::size_t> vectors;
};

/// Samples in the layout that libsvm reads, shared by all machines that learn from some of them.
class SvmSamples {
 public:
  /// Samples known by their kernel matrix alone: symmetric, n × n. Takes 16 n² bytes.
  SvmSamples(std::span<const float> kernel, std::size_t n) : width_(n + 1) {
    nodes_.reserve(n * width_);
    parameter_.kernel_type = PRECOMPUTED;
    // libsvm reads k(a, b) at a.nodes[number of b, from 1]: all subsets of rows share the matrix.
    for (std::size_t i = 0; i < n; ++i) {
      nodes_.push_back({0, static_cast<double>(i + 1)});
      for (std::size_t j = 0; j < n; ++j) nodes_.push_back({static_cast<int>(j + 1), kernel[i * n + j]});
    }
  }
  /// Kernel computed by libsvm as it goes (without gamma: a · b): slower, but 16 n · columns bytes.
  SvmSamples(const DescriptorMatrix& x, std::optional<double> gamma) : width_(x.labels() + 1) {
    nodes_.reserve(x.size() * width_);
    parameter_.kernel_type = gamma ? RBF : LINEAR;
    parameter_.gamma = gamma.value_or(0);
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (int k = 0; const float value : x.row(i)) nodes_.push_back({++k, value});
      nodes_.push_back({-1, 0});
    }
  }

  /// Learns from the `rows`, whose classes are classes[row] and whose errors cost c · weights[classes[row]].
  TrainedMachines train(const std::vector<std::size_t>& rows, const std::vector<int>& classes, double c,
                        const std::vector<double>& weights) const {
    svm_set_print_string_function([](const char*) {});
    OrderedByClass order = orderByClass(rows, classes, weights);
    std::vector<svm_node*> x;
    for (const std::size_t row : order.rows)
      x.push_back(const_cast<svm_node*>(nodes_.data() + row * width_));  // only read
    svm_problem problem{static_cast<int>(x.size()), order.y.data(), x.data()};
    svm_parameter parameter = parameter_;
    parameter.svm_type = C_SVC;
    parameter.C = c;
    parameter.cache_size = 200;  // MB
    parameter.eps = 1e-3;
    parameter.shrinking = 1;
    parameter.nr_weight = static_cast<int>(order.labels.size());
    parameter.weight_label = order.labels.data();
    parameter.weight = order.weights.data();
    if (const char* wrong = svm_check_parameter(&problem, &parameter); wrong != nullptr)
      fail(ErrorCode::invalidInput, "libsvm does not train: {}", wrong);

    const std::unique_ptr<svm_model, void (*)(svm_model*)> model(
        svm_train(&problem, &parameter), [](svm_model* m) { svm_free_and_destroy_model(&m); });
    TrainedMachines trained;
    const auto k = static_cast<std::size_t>(model->nr_class);
    trained.classes.assign(model->label, model->label + k);
    KernelMachines& machines = trained.machines;
    machines.starts = {0};
    for (std::size_t i = 0; i < k; ++i)
      machines.starts.push_back(machines.starts.back() + static_cast<std::size_t>(model->nSV[i]));
    for (int v = 0; v < model->l; ++v) {
      trained.vectors.push_back(order.rows[static_cast<std::size_t>(model->sv_indices[v] - 1)]);
      for (std::size_t other = 0; other + 1 < k; ++other)
        machines.coefficients.push_back(model->sv_coef[other][v]);
    }
    machines.rho.assign(model->rho, model->rho + k * (k - 1) / 2);
    return trained;
  }

 private:
  std::vector<svm_node> nodes_;
  std::size_t width_;  ///< nodes a sample
  svm_parameter parameter_{};
};

/// k(v, x) = exp(−gamma |v − x|²) from products, in place.
void toKernel(std::span<float> products, std::span<const float> norms, float norm, double gamma) {
  for (std::size_t j = 0; j < products.size(); ++j)
    products[j] = std::exp(static_cast<float>(-gamma) * std::max(norms[j] + norm - 2 * products[j], 0.0F));
}

/// Probabilities of the classes.
std::vector<double> coupled(std::span<const double> decisions, const std::vector<Sigmoid>& sigmoids,
                            std::size_t k) {
  std::vector<double> r(k * k);
  for (std::size_t i = 0, p = 0; i < k; ++i)
    for (std::size_t j = i + 1; j < k; ++j, ++p) {
      r[i * k + j] = std::clamp(sigmoids[p](decisions[p]), 1 - maxProbability, maxProbability);
      r[j * k + i] = 1 - r[i * k + j];
    }
  return couplePairs(r, k);
}

/// Support vector machine: one kernel machine and one sigmoid (Platt scaling) a pair of classes. Life cycle:
/// the public members are set by training or reading, then prepare(), then predict(). Invariant after
/// prepare(): `packed` and `norms` follow from `vectors`.
class Svm final : public Classifier {
 public:
  std::string type() const override { return gamma ? "svm-rbf" : "svm-linear"; }
  std::size_t columns() const override { return vectors.labels(); }
  int classCount() const override { return static_cast<int>(machines.classes()); }
  std::string choice() const override { return chosen; }
  DescriptorMatrix predict(const DescriptorMatrix& x, int threads) const override {
    const std::size_t k = machines.classes();
    const std::vector<float> own = squaredNorms(x);
    std::vector<float> all(x.size() * k);
    rowProducts(x, *packed, threads, [&](std::size_t i, std::span<float> products) {
      std::vector<double> decisions;
      if (gamma) {
        toKernel(products, norms, own[i], *gamma);
        decisions = machines.decisions(products);
      } else {
        for (std::size_t p = 0; p < products.size(); ++p) decisions.push_back(products[p] - machines.rho[p]);
      }
      const std::vector<double> p = coupled(decisions, sigmoids, k);
      std::copy(p.begin(), p.end(), all.begin() + static_cast<std::ptrdiff_t>(i * k));
    });
    return matrixOf(all, k);
  }

  void write(ByteWriter& out) const override {
    out.number(gamma.value_or(0));
    out.numbers(std::vector<std::uint64_t>(machines.starts.begin(), machines.starts.end()));
    out.numbers(machines.coefficients);
    out.numbers(machines.rho);
    for (const Sigmoid& sigmoid : sigmoids) {
      out.number(sigmoid.a);
      out.number(sigmoid.b);
    }
    writeMatrix(out, vectors);
    out.text(chosen);
  }

  std::optional<double> gamma;
  KernelMachines machines;
  DescriptorMatrix vectors{0};  ///< the support vectors; linear: the weights of each pair
  std::vector<Sigmoid> sigmoids;
  std::string chosen;

  void prepare() {
    packed = std::make_unique<PackedRows>(vectors);
    norms = squaredNorms(vectors);
  }

 private:
  std::unique_ptr<PackedRows> packed;
  std::vector<float> norms;
};

// ---- training

/// Memory limit for the held-out decisions of one C: with many classes, fewer samples are searched.
constexpr std::size_t maxBytes = std::size_t{512} << 20;
constexpr std::size_t judgedAtOnce = 64;  // samples
constexpr double costs[] = {0.1, 0.3, 1, 3, 10, 30};
constexpr double gammas[] = {0.25, 0.5, 1, 2};  // in units of 1 / the samples' variance

std::vector<float> kernelOf(std::vector<float> products, std::span<const float> norms,
                            std::optional<double> gamma) {
  const std::size_t n = norms.size();
  for (std::size_t i = 0; gamma && i < n; ++i)
    toKernel(std::span(products).subspan(i * n, n), norms, norms[i], *gamma);
  return products;
}

std::size_t pairsOf(const Search& search) {
  return search.weights.size() * (search.weights.size() - 1) / 2;
}

/// Decision values of all pairs that have a machine for the samples of a fold, trained on the others.
void holdOut(const Search& search, const SvmSamples& samples, std::span<const float> kernel,
             const std::vector<int>& folds, int fold, double c, std::span<float> decisions) {
  const std::size_t n = search.size();
  const std::vector<std::size_t> rows = search.trainingRows(folds, fold);
  if (rows.empty()) return;
  const TrainedMachines trained = samples.train(rows, search.classes, c, search.weights);
  std::vector<float> values(trained.vectors.size());
  for (std::size_t i = 0; i < n; ++i) {
    if (folds[i] != fold) continue;
    for (std::size_t v = 0; v < values.size(); ++v) values[v] = kernel[i * n + trained.vectors[v]];
    const std::vector<double> f = trained.machines.decisions(values);
    for (std::size_t a = 0, p = 0; a < trained.classes.size(); ++a)
      for (std::size_t b = a + 1; b < trained.classes.size(); ++b, ++p)
        decisions[i * pairsOf(search) + pairIndex(static_cast<std::size_t>(trained.classes[a]),
                                                  static_cast<std::size_t>(trained.classes[b]),
                                                  search.weights.size())] = static_cast<float>(f[p]);
  }
}

/// `decisionsOfAll`: held out, n × pairs, one repetition after the other.
Sigmoid sigmoidOf(const Search& search, std::span<const float> decisionsOfAll, std::size_t i, std::size_t j) {
  const std::size_t pair = pairIndex(i, j, search.weights.size()), pairs = pairsOf(search);
  std::vector<double> decisions, weights;
  std::vector<char> isFirst;
  for (std::size_t s = 0; s < Search::repetitions * search.size(); ++s) {
    const auto c = static_cast<std::size_t>(search.classes[s % search.size()]);
    if (c != i && c != j) continue;
    const float f = decisionsOfAll[s * pairs + pair];
    if (std::isnan(f)) continue;
    decisions.push_back(f);
    weights.push_back(search.weights[c] / Search::repetitions);
    isFirst.push_back(c == i ? 1 : 0);
  }
  return fitSigmoid(decisions, isFirst, weights);
}

struct Parameters {
  double c = 1;
  std::optional<double> gamma;
  double score = -1;                                      ///< share of held-out samples found right
  double loss = std::numeric_limits<double>::infinity();  ///< mean −ln of the probability of what is right
  std::vector<Sigmoid> sigmoids;
};

constexpr const char* stopped = "stopped while C and gamma were sought";

/// Steps of progress that one C takes: those of holdOut(), of sigmoids (a class each) and of judge().
std::size_t stepsOf(const Search& search, const ClassifierOptions& options) {
  const std::size_t samples = Search::repetitions * search.size();
  return Search::repetitions * static_cast<std::size_t>(options.folds) + search.weights.size() +
         (samples + judgedAtOnce - 1) / judgedAtOnce;
}

/// Fits the sigmoids of a C to its decisions, and scores their probabilities.
void judge(const Search& search, std::span<const float> decisions, const ClassifierOptions& options,
           Progress& progress, Parameters& parameters) {
  const std::size_t k = search.weights.size(), pairs = pairsOf(search);
  const std::size_t samples = Search::repetitions * search.size();
  parameters.sigmoids.resize(pairs);
  inParallel(k, options.threads, progress, stopped, [&](std::size_t i) {
    for (std::size_t j = i + 1; j < k; ++j)
      parameters.sigmoids[pairIndex(i, j, k)] = sigmoidOf(search, decisions, i, j);
  });
  std::vector<double> scores(samples), losses(samples);
  inParallel(
      (samples + judgedAtOnce - 1) / judgedAtOnce, options.threads, progress, stopped, [&](std::size_t task) {
        for (std::size_t s = task * judgedAtOnce; s < std::min(samples, (task + 1) * judgedAtOnce); ++s) {
          const auto truth = static_cast<std::size_t>(search.classes[s % search.size()]);
          const std::span<const float> held = decisions.subspan(s * pairs, pairs);
          std::vector<double> f(held.begin(), held.end());
          for (double& value : f)
            if (std::isnan(value)) value = 0;  // no machine for this pair
          const std::vector<double> p = coupled(f, parameters.sigmoids, k);
          const auto best = static_cast<std::size_t>(std::max_element(p.begin(), p.end()) - p.begin());
          const double weight = search.weights[truth] / static_cast<double>(samples);
          scores[s] = best == truth ? weight : 0;
          losses[s] = -std::log(std::max(p[truth], 1e-9)) * weight;
        }
      });
  parameters.score = std::accumulate(scores.begin(), scores.end(), 0.0);
  parameters.loss = std::accumulate(losses.begin(), losses.end(), 0.0);
}

/// x xᵀ of what is searched, and its diagonal.
struct Products {
  std::vector<float> products, norms;
};

/// The best C of a kernel, if its held-out log-loss (finer than accuracy's steps) is below that of `best`.
void tryKernel(const Search& search, const Products& products, std::optional<double> gamma,
               std::span<const double> cs, const ClassifierOptions& options, Progress& progress,
               Parameters& best) {
  const std::vector<float> kernel = kernelOf(products.products, products.norms, gamma);
  const SvmSamples samples(kernel, search.size());
  const std::size_t folds = static_cast<std::size_t>(options.folds), size = search.size() * pairsOf(search);
  const std::size_t each = Search::repetitions * size;  // decisions of one C
  const std::size_t atOnce = std::clamp(maxBytes / (each * sizeof(float)), std::size_t{1}, cs.size());
  std::vector<float> decisions(atOnce * each);
  for (std::size_t first = 0; first < cs.size(); first += atOnce) {
    const std::span<const double> some = cs.subspan(first, std::min(atOnce, cs.size() - first));
    std::fill(decisions.begin(), decisions.end(), std::nanf(""));
    inParallel(some.size() * Search::repetitions * folds, options.threads, progress, stopped,
               [&](std::size_t task) {
                 const std::size_t c = task % some.size(), r = task / some.size() % Search::repetitions;
                 const auto fold = static_cast<int>(task / some.size() / Search::repetitions);
                 holdOut(search, samples, kernel, search.folds[r], fold, some[c],
                         std::span(decisions).subspan(c * each + r * size, size));
               });
    for (std::size_t c = 0; c < some.size(); ++c) {
      Parameters parameters{some[c], gamma, 0, 0, {}};
      judge(search, std::span(decisions).subspan(c * each, each), options, progress, parameters);
      if (parameters.loss < best.loss - 1e-9) best = std::move(parameters);
    }
  }
}

Parameters choose(const Search& search, const ClassifierOptions& options, bool rbf, Progress& progress) {
  // Their variance is the natural unit of squared distances.
  const double n = static_cast<double>(search.size());
  const Products products{productsOf(search.x, options.threads), squaredNorms(search.x)};
  const double mean = std::accumulate(products.products.begin(), products.products.end(), 0.0) / n / n;
  const double variance = std::accumulate(products.norms.begin(), products.norms.end(), 0.0) / n - mean;
  std::vector<std::optional<double>> kernels;
  if (!rbf)
    kernels.emplace_back();
  else if (options.gamma)
    kernels.emplace_back(*options.gamma);
  else
    for (const double gamma : gammas) kernels.emplace_back(gamma / (variance > 1e-12 ? variance : 1));
  const std::vector<double> cs =
      options.c ? std::vector<double>{*options.c} : std::vector<double>(std::begin(costs), std::end(costs));
  Parameters best;
  progress.begin("choosing C and gamma", kernels.size() * cs.size() * stepsOf(search, options));
  for (const auto& gamma : kernels) tryKernel(search, products, gamma, cs, options, progress, best);
  progress.end();
  // Large costs are slow for overlapping classes: they are tried only while they help.
  for (double c = cs.back(); !options.c && best.c == c && c < 800;) {
    progress.begin("trying a larger C", stepsOf(search, options));
    tryKernel(search, products, best.gamma, std::vector<double>{c *= 3}, options, progress, best);
    progress.end();
  }
  return best;
}

std::size_t maxSearched(const Samples& samples) {
  const auto k = static_cast<std::size_t>(samples.classCount);
  const std::size_t ofOne = Search::repetitions * (k * (k - 1) / 2) * sizeof(float);
  return std::clamp(maxBytes / ofOne, std::size_t{1}, Search::maxSamples);
}

/// Weights of each pair instead of its support vectors, as a linear kernel is a product.
DescriptorMatrix weightsOf(const KernelMachines& machines, const DescriptorMatrix& vectors) {
  const std::size_t k = machines.classes();
  std::vector<std::vector<double>> sums(machines.rho.size(), std::vector<double>(vectors.labels()));
  for (std::size_t i = 0; i < k; ++i)
    for (std::size_t v = machines.starts[i]; v < machines.starts[i + 1]; ++v)
      for (std::size_t other = 0; other + 1 < k; ++other) {
        auto& sum = sums[other < i ? pairIndex(other, i, k) : pairIndex(i, other + 1, k)];
        const double coefficient = machines.coefficients[v * (k - 1) + other];
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += coefficient * vectors.row(v)[c];
      }
  DescriptorMatrix weights(vectors.labels());
  for (const auto& sum : sums) weights.append(std::vector<float>(sum.begin(), sum.end()));
  return weights;
}

TrainedMachines trainOnAll(const Samples& samples, const Parameters& parameters,
                           const ClassifierOptions& options) {
  std::vector<std::size_t> rows(samples.x.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  const std::vector<double> weights = classWeights(samples, options.balanced);
  if (rows.size() * rows.size() * 24 < availableMemory() / 2) {
    const std::vector<float> kernel =
        kernelOf(productsOf(samples.x, options.threads), squaredNorms(samples.x), parameters.gamma);
    return SvmSamples(kernel, rows.size()).train(rows, samples.classes, parameters.c, weights);
  }
  return SvmSamples(samples.x, parameters.gamma).train(rows, samples.classes, parameters.c, weights);
}

/// ln(1 + exp x) without overflow.
double softplus(double x) {
  return x > 0 ? x + std::log1p(std::exp(-x)) : std::log1p(std::exp(x));
}

}  // namespace

std::unique_ptr<Classifier> trainSvm(const Samples& samples, const ClassifierOptions& options,
                                     Progress& progress) {
  const bool rbf = options.type == "svm-rbf";
  const Parameters parameters =
      choose(searchOf(samples, options, maxSearched(samples)), options, rbf, progress);
  TrainedMachines trained =
      learnFromAll(samples, progress, [&] { return trainOnAll(samples, parameters, options); });
  auto svm = std::make_unique<Svm>();
  svm->gamma = parameters.gamma;
  svm->machines = std::move(trained.machines);
  svm->vectors = rowsOf(samples.x, trained.vectors);
  svm->sigmoids = parameters.sigmoids;
  svm->chosen =
      fmt::format("C {:.4g}{}: {}", parameters.c, rbf ? fmt::format(", gamma {:.4g}", *parameters.gamma) : "",
                  heldOutText(parameters.score, options));
  if (!rbf) {
    svm->vectors = weightsOf(svm->machines, svm->vectors);
    svm->machines.coefficients.clear();
    std::fill(svm->machines.starts.begin(), svm->machines.starts.end(), std::size_t{0});
  }
  svm->prepare();
  return svm;
}

std::unique_ptr<Classifier> readSvm(ByteReader& in) {
  auto svm = std::make_unique<Svm>();
  if (const auto gamma = in.number<double>(); gamma != 0) svm->gamma = gamma;
  if (svm->gamma && !(*svm->gamma > 0 && std::isfinite(*svm->gamma))) in.fail("it is damaged (gamma)");
  KernelMachines& machines = svm->machines;
  const auto starts = in.numbers<std::uint64_t>();
  machines.starts.assign(starts.begin(), starts.end());
  machines.coefficients = in.numbers<double>();
  machines.rho = in.numbers<double>();
  const std::size_t k = starts.size() - 1, pairs = machines.rho.size();
  if (starts.size() < 3 || k > 1U << 16 || pairs != k * (k - 1) / 2)
    in.fail("it is damaged (classes and pairs of them do not match)");
  for (std::size_t p = 0; p < pairs; ++p) {
    const double a = in.number<double>(), b = in.number<double>();
    if (!std::isfinite(a) || !std::isfinite(b) || !std::isfinite(machines.rho[p]))
      in.fail("it is damaged (a value is not finite)");
    svm->sigmoids.push_back({a, b});
  }
  svm->vectors = readMatrix(in);
  const std::size_t m = svm->vectors.size();
  if (!std::is_sorted(starts.begin(), starts.end()) || starts.front() != 0)
    in.fail("it is damaged (support vectors without order)");
  if (svm->gamma ? starts.back() != m || machines.coefficients.size() / (k - 1) != m ||
                       machines.coefficients.size() % (k - 1) != 0
                 : starts.back() != 0 || !machines.coefficients.empty() || m != pairs)
    in.fail("it is damaged (support vectors and their coefficients do not match)");
  if (!std::all_of(machines.coefficients.begin(), machines.coefficients.end(),
                   [](double c) { return std::isfinite(c); }))
    in.fail("it is damaged (a value is not finite)");
  svm->chosen = in.text();
  svm->prepare();
  return svm;
}

double Sigmoid::operator()(double decision) const {
  const double x = a * decision + b;
  return x >= 0 ? std::exp(-x) / (1 + std::exp(-x)) : 1 / (1 + std::exp(x));
}

Sigmoid fitSigmoid(std::span<const double> decisions, std::span<const char> isFirst,
                   std::span<const double> weights) {
  double first = 0, second = 0;
  std::size_t firsts = 0;
  for (std::size_t i = 0; i < decisions.size(); ++i) {
    (isFirst[i] != 0 ? first : second) += weights[i];
    firsts += isFirst[i] != 0 ? 1 : 0;
  }
  const std::size_t seconds = decisions.size() - firsts;
  if (firsts == 0 || seconds == 0 || !(first > 0) || !(second > 0)) return {};
  const double high = (static_cast<double>(firsts) + 1) / (static_cast<double>(firsts) + 2);
  const double low = 1 / (static_cast<double>(seconds) + 2);
  const auto target = [&](std::size_t i) { return isFirst[i] != 0 ? high : low; };
  const auto loss = [&](const Sigmoid& s) {
    double sum = 0;
    for (std::size_t i = 0; i < decisions.size(); ++i) {
      const double x = s.a * decisions[i] + s.b;
      sum += weights[i] * (softplus(x) - (1 - target(i)) * x);
    }
    return sum;
  };

  Sigmoid sigmoid{0, std::log((second + 1) / (first + 1))};
  double value = loss(sigmoid);
  for (int iteration = 0; iteration < 100; ++iteration) {
    // Newton's method; the ridge keeps the Hessian positive definite.
    double h11 = 1e-12, h22 = 1e-12, h21 = 0, g1 = 0, g2 = 0;
    for (std::size_t i = 0; i < decisions.size(); ++i) {
      const double p = sigmoid(decisions[i]), q = 1 - p, d2 = weights[i] * p * q,
                   d1 = weights[i] * (target(i) - p);
      h11 += decisions[i] * decisions[i] * d2;
      h22 += d2;
      h21 += decisions[i] * d2;
      g1 += decisions[i] * d1;
      g2 += d1;
    }
    if (std::fabs(g1) < 1e-5 && std::fabs(g2) < 1e-5) break;
    const double determinant = h11 * h22 - h21 * h21;
    const double stepA = -(h22 * g1 - h21 * g2) / determinant, stepB = -(h11 * g2 - h21 * g1) / determinant;
    const double slope = g1 * stepA + g2 * stepB;
    double step = 1;
    for (; step >= 1e-10; step /= 2) {
      const Sigmoid next{sigmoid.a + step * stepA, sigmoid.b + step * stepB};
      const double nextValue = loss(next);
      if (nextValue < value + 1e-4 * step * slope) {
        sigmoid = next;
        value = nextValue;
        break;
      }
    }
    if (step < 1e-10) break;
  }
  // Held-out decisions of a few samples may be anti-correlated; a falling sigmoid would then invert every
  // answer. Only the shares of the classes are known then, and that the sign of a decision is right.
  if (sigmoid.a > 0) return {-1, std::log((second + 1) / (first + 1))};
  return sigmoid;
}

std::vector<double> couplePairs(std::span<const double> r, std::size_t k) {
  std::vector<double> q(k * k), p(k, 1 / static_cast<double>(k)), qp(k);
  for (std::size_t t = 0; t < k; ++t)
    for (std::size_t j = 0; j < k; ++j) {
      if (j == t) continue;
      q[t * k + t] += r[j * k + t] * r[j * k + t];
      q[t * k + j] = -r[j * k + t] * r[t * k + j];
    }
  const double epsilon = 0.001 / static_cast<double>(k);
  const int iterations = std::max<int>(100, static_cast<int>(k));
  for (int iteration = 0; iteration < iterations; ++iteration) {
    double pqp = 0;
    for (std::size_t t = 0; t < k; ++t) {
      qp[t] = 0;
      for (std::size_t j = 0; j < k; ++j) qp[t] += q[t * k + j] * p[j];
      pqp += p[t] * qp[t];
    }
    double error = 0;
    for (std::size_t t = 0; t < k; ++t) error = std::max(error, std::fabs(qp[t] - pqp));
    if (error < epsilon) break;
    for (std::size_t t = 0; t < k; ++t) {
      if (!(q[t * k + t] > 0)) continue;
      const double difference = (-qp[t] + pqp) / q[t * k + t];
      p[t] += difference;
      pqp =
          (pqp + difference * (difference * q[t * k + t] + 2 * qp[t])) / (1 + difference) / (1 + difference);
      for (std::size_t j = 0; j < k; ++j) {
        qp[j] = (qp[j] + difference * q[t * k + j]) / (1 + difference);
        p[j] /= 1 + difference;
      }
    }
  }
  double sum = 0;
  for (double& value : p) sum += value = std::max(value, 0.0);
  for (double& value : p) value /= sum;
  return p;
}

}  // namespace estancia
