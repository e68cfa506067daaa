#include "estancia/classify/svm_training.hpp"

#include <fmt/format.h>
#include <libsvm/svm.h>

#include <algorithm>

#include "estancia/classify/pairwise_coupling.hpp"
#include "estancia/core/error.hpp"

namespace estancia {

struct SvmSamples::Nodes {
  std::vector<svm_node> nodes;
  std::size_t width = 0;  ///< nodes a sample
  svm_parameter parameter{};
};

SvmSamples::SvmSamples(std::span<const float> kernel, std::size_t n) : nodes_(std::make_unique<Nodes>()) {
  nodes_->width = n + 1;
  nodes_->nodes.reserve(n * nodes_->width);
  nodes_->parameter.kernel_type = PRECOMPUTED;
  // libsvm reads k(a, b) at a.nodes[number of b], with numbers from 1: all subsets of rows share the matrix.
  for (std::size_t i = 0; i < n; ++i) {
    nodes_->nodes.push_back({0, static_cast<double>(i + 1)});
    for (std::size_t j = 0; j < n; ++j) nodes_->nodes.push_back({static_cast<int>(j + 1), kernel[i * n + j]});
  }
}

SvmSamples::SvmSamples(const DescriptorMatrix& x, std::optional<double> gamma)
    : nodes_(std::make_unique<Nodes>()) {
  nodes_->width = x.labels() + 1;
  nodes_->nodes.reserve(x.size() * nodes_->width);
  nodes_->parameter.kernel_type = gamma ? RBF : LINEAR;
  nodes_->parameter.gamma = gamma.value_or(0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (int k = 0; const float value : x.row(i)) nodes_->nodes.push_back({++k, value});
    nodes_->nodes.push_back({-1, 0});
  }
}

SvmSamples::~SvmSamples() = default;

TrainedMachines SvmSamples::train(const std::vector<std::size_t>& rows, const std::vector<int>& classes,
                                  double c, const std::vector<double>& weights) const {
  svm_set_print_string_function([](const char*) {});
  // libsvm counts classes in the order in which they appear.
  std::vector<std::size_t> order = rows;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return classes[a] < classes[b]; });
  std::vector<svm_node*> x;
  std::vector<double> y;
  for (const std::size_t row : order) {
    x.push_back(nodes_->nodes.data() + row * nodes_->width);
    y.push_back(classes[row]);
  }
  svm_problem problem{static_cast<int>(x.size()), y.data(), x.data()};
  std::vector<int> labels;
  std::vector<double> costs;
  for (const std::size_t row : order) {
    if (!labels.empty() && labels.back() == classes[row]) continue;
    labels.push_back(classes[row]);
    costs.push_back(weights[static_cast<std::size_t>(classes[row])]);
  }
  svm_parameter parameter = nodes_->parameter;
  parameter.svm_type = C_SVC;
  parameter.C = c;
  parameter.cache_size = 200;  // MB
  parameter.eps = 1e-3;
  parameter.shrinking = 1;
  parameter.nr_weight = static_cast<int>(labels.size());
  parameter.weight_label = labels.data();
  parameter.weight = costs.data();
  if (const char* wrong = svm_check_parameter(&problem, &parameter); wrong != nullptr)
    throw Error(ErrorCode::invalidInput, fmt::format("libsvm does not train: {}", wrong));

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
    trained.vectors.push_back(order[static_cast<std::size_t>(model->sv_indices[v] - 1)]);
    for (std::size_t other = 0; other + 1 < k; ++other)
      machines.coefficients.push_back(model->sv_coef[other][v]);
  }
  machines.rho.assign(model->rho, model->rho + k * (k - 1) / 2);
  return trained;
}

std::vector<double> KernelMachines::decisions(std::span<const float> kernel) const {
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

}  // namespace estancia
