// SVM training by libsvm: machines for all pairs of classes, from a kernel matrix computed once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libsvm/svm.h>

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia {

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
  std::vector<double> decisions(std::span<const float> kernel) const;
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
  SvmSamples(std::span<const float> kernel, std::size_t n);
  /// Samples whose kernel libsvm computes as it goes (without gamma: a · b): slower, but 16 n · columns
  /// bytes.
  SvmSamples(const DescriptorMatrix& x, std::optional<double> gamma);

  /// Learns from the `rows`, whose classes are classes[row] and whose errors cost c · weights[classes[row]].
  TrainedMachines train(const std::vector<std::size_t>& rows, const std::vector<int>& classes, double c,
                        const std::vector<double>& weights) const;

 private:
  std::vector<svm_node> nodes_;
  std::size_t width_;  ///< nodes a sample
  svm_parameter parameter_{};
};

}  // namespace estancia
