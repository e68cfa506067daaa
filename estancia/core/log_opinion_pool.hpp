// What several opinions about one thing say together.
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia {

/// The mean of the logarithms of probabilities, scaled to add up to 1 (the logarithmic opinion pool; Genest
/// and Zidek 1986, Combining probability distributions). Images of one place or thing are taken one after the
/// other and err together: a plain product would count the same evidence again and again and be sure of
/// whatever it says; the mean does not change when images repeat. None counts as below 0.001: a forest's or a
/// neighborhood's 0 is no proof.
class LogOpinionPool {
 public:
  /// Of opinions about so many answers.
  explicit LogOpinionPool(std::size_t answers) : sums_(answers, 0) {}

  /// One that is all 0 is none. Throws Error when it is about another number of answers.
  void add(DescriptorView opinion);

  std::size_t size() const { return size_; }

  /// Empty where there is no opinion.
  std::vector<double> pooled() const;

 private:
  std::vector<double> sums_;  ///< of logarithms
  std::size_t size_ = 0;
};

}  // namespace estancia
