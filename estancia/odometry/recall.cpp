// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/recall.hpp"

#include <algorithm>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/stats/compared_vectors.hpp"

namespace estancia::odometry {

std::vector<float> Recall::embed(const LexicalDescriptor& descriptor) const {
  std::vector<float> embedded(descriptor.size());
  if (!descriptor.empty()) estancia::embed(distance_.embedding, descriptor, embedded, distance_.parts);
  return embedded;
}

void Recall::add(std::vector<float> embedded) {
  if (!embedded.empty()) {
    if (!moments_) moments_.emplace(embedded.size(), true);
    if (embedded.size() != moments_->mean().size())
      throw Error(ErrorCode::mismatch,
                  "the number of labels changed between frames; label the sequence first (estancia label)");
    moments_->add(embedded);
  }
  embedded_.push_back(std::move(embedded));
}

void Recall::removeLast() {
  embedded_.pop_back();
  moments_.reset();  // summed up anew, so that they do not depend on what is gone
  std::vector<std::vector<float>> rest = std::exchange(embedded_, {});
  for (std::vector<float>& embedded : rest) add(std::move(embedded));
}

std::vector<std::size_t> Recall::nearest(const std::vector<float>& query, std::size_t max,
                                         const std::function<bool(std::size_t)>& eligible) const {
  if (!moments_ || query.size() != moments_->mean().size()) return {};
  const Standardization run = standardizationBy(*moments_);
  const std::vector<float> sought = comparedVector(distance_, run, query);
  std::vector<std::pair<double, std::size_t>> found;
  for (std::size_t i = 0; i < embedded_.size(); ++i)
    if (!embedded_[i].empty() && eligible(i))
      found.emplace_back(compare(distance_.comparison, sought, comparedVector(distance_, run, embedded_[i])),
                         i);
  max = std::min(max, found.size());
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(max), found.end());
  std::vector<std::size_t> images;
  for (std::size_t k = 0; k < max; ++k) images.push_back(found[k].second);
  return images;
}

}  // namespace estancia::odometry
