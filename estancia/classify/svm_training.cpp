// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/svm_training.hpp"

#include <algorithm>
#include <memory>

#include "estancia/classify/pairwise_coupling.hpp"
#include "estancia/classify/trainers.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {

SvmSamples::SvmSamples(std::span<const float> kernel, std::size_t n) : width_(n + 1) {
  nodes_.reserve(n * width_);
  parameter_.kernel_type = PRECOMPUTED;
  // libsvm reads k(a, b) at a.nodes[number of b], with numbers from 1: all subsets of rows share the matrix.
  for (std::size_t i = 0; i < n; ++i) {
    nodes_.push_back({0, static_cast<double>(i + 1)});
    for (std::size_t j = 0; j < n; ++j) nodes_.push_back({static_cast<int>(j + 1), kernel[i * n + j]});
  }
}

SvmSamples::SvmSamples(const DescriptorMatrix& x, std::optional<double> gamma) : width_(x.labels() + 1) {
  nodes_.reserve(x.size() * width_);
  parameter_.kernel_type = gamma ? RBF : LINEAR;
  parameter_.gamma = gamma.value_or(0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (int k = 0; const float value : x.row(i)) nodes_.push_back({++k, value});
    nodes_.push_back({-1, 0});
  }
}

TrainedMachines SvmSamples::train(const std::vector<std::size_t>& rows, const std::vector<int>& classes,
                                  double c, const std::vector<double>& weights) const {
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
