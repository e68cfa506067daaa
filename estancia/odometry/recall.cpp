#include "estancia/odometry/recall.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/stats/distance.hpp"

namespace estancia::odometry {

std::vector<float> Recall::embed(const LexicalDescriptor& descriptor) const {
  std::vector<float> embedded(descriptor.size());
  if (!descriptor.empty()) estancia::embed(Embedding::centredLogRatio, descriptor, embedded, parts_);
  return embedded;
}

void Recall::add(const LexicalDescriptor& descriptor) {
  if (!descriptor.empty()) {
    if (labels_ == 0) {
      labels_ = descriptor.size();
      sum_.assign(labels_, 0);
      squares_.assign(labels_, 0);
    }
    if (descriptor.size() != labels_)
      throw Error("the number of labels changed on the way; label the sequence first (estancia label)");
  }
  embedded_.push_back(embed(descriptor));
  if (descriptor.empty()) return;
  ++described_;
  for (std::size_t l = 0; l < labels_; ++l) {
    sum_[l] += embedded_.back()[l];
    squares_[l] += static_cast<double>(embedded_.back()[l]) * embedded_.back()[l];
  }
}

std::vector<std::size_t> Recall::nearest(const LexicalDescriptor& descriptor, std::size_t most,
                                         const std::function<bool(std::size_t)>& eligible) const {
  return nearestEmbedded(embed(descriptor), most, eligible);
}

std::vector<std::size_t> Recall::nearest(std::size_t picture, std::size_t most,
                                         const std::function<bool(std::size_t)>& eligible) const {
  return nearestEmbedded(embedded_[picture], most, eligible);
}

std::vector<std::size_t> Recall::nearestEmbedded(const std::vector<float>& query, std::size_t most,
                                                 const std::function<bool(std::size_t)>& eligible) const {
  if (query.size() != labels_ || described_ == 0) return {};
  const auto count = static_cast<double>(described_);
  std::vector<float> mean(labels_), weight(labels_);
  for (std::size_t l = 0; l < labels_; ++l) {
    const double m = sum_[l] / count, variance = squares_[l] / count - m * m;
    mean[l] = static_cast<float>(m);
    weight[l] = variance > 1e-9 ? static_cast<float>(1 / std::sqrt(variance)) : 0;
  }
  const auto standardized = [&](const std::vector<float>& embedded) {
    std::vector<float> values(labels_);
    for (std::size_t l = 0; l < labels_; ++l) values[l] = (embedded[l] - mean[l]) * weight[l];
    return values;
  };
  const std::vector<float> sought = standardized(query);
  std::vector<std::pair<double, std::size_t>> found;
  for (std::size_t i = 0; i < embedded_.size(); ++i)
    if (!embedded_[i].empty() && eligible(i))
      found.emplace_back(compare(Comparison::cosine, sought, standardized(embedded_[i])), i);
  most = std::min(most, found.size());
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(most), found.end());
  std::vector<std::size_t> pictures;
  for (std::size_t k = 0; k < most; ++k) pictures.push_back(found[k].second);
  return pictures;
}

}  // namespace estancia::odometry
