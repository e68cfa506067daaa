// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/confident_learning.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// Samples that can be judged, and their labels.
struct Judged {
  std::vector<std::size_t> rows, labels;
};

Judged judgedOf(const std::vector<int>& labels, const DescriptorMatrix& heldOut) {
  Judged judged;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (std::ranges::any_of(heldOut.row(i), [](float p) { return p > 0; })) {
      judged.rows.push_back(i);
      judged.labels.push_back(static_cast<std::size_t>(labels[i]));
    }
  return judged;
}

/// Mean self-confidence of each class; infinity for classes without samples.
std::vector<double> thresholdsOf(const Judged& judged, const DescriptorMatrix& heldOut) {
  std::vector<double> sums(heldOut.labels(), 0), counts(heldOut.labels(), 0);
  for (std::size_t s = 0; s < judged.rows.size(); ++s) {
    sums[judged.labels[s]] += heldOut.row(judged.rows[s])[judged.labels[s]];
    ++counts[judged.labels[s]];
  }
  for (std::size_t w = 0; w < sums.size(); ++w)
    sums[w] = counts[w] > 0 ? sums[w] / counts[w] : std::numeric_limits<double>::infinity();
  return sums;
}

/// Confident joint: of the samples of each label that count for some class, the share of each: [label · K +
/// class].
std::vector<double> confidentJoint(const Judged& judged, const DescriptorMatrix& heldOut) {
  const std::size_t k = heldOut.labels();
  const std::vector<double> thresholds = thresholdsOf(judged, heldOut);
  std::vector<double> joint(k * k, 0), sums(k, 0);
  for (std::size_t s = 0; s < judged.rows.size(); ++s) {
    const DescriptorView p = heldOut.row(judged.rows[s]);
    std::size_t best = k;
    for (std::size_t w = 0; w < k; ++w)
      if (p[w] >= thresholds[w] && (best == k || p[w] > p[best])) best = w;
    if (best == k) continue;
    ++joint[judged.labels[s] * k + best];
    ++sums[judged.labels[s]];
  }
  for (std::size_t i = 0; i < joint.size(); ++i)
    if (sums[i / k] > 0) joint[i] /= sums[i / k];
  return joint;
}

}  // namespace

std::vector<std::size_t> likelyMislabeled(const std::vector<int>& labels, const DescriptorMatrix& heldOut) {
  if (labels.size() != heldOut.size())
    fail(ErrorCode::mismatch, "{} labels have {} held-out answers; give one each", labels.size(),
         heldOut.size());
  const std::size_t k = heldOut.labels();
  const Judged judged = judgedOf(labels, heldOut);
  const std::vector<double> joint = confidentJoint(judged, heldOut);
  std::vector<std::size_t> mislabeled;
  for (std::size_t label = 0; label < k; ++label)
    for (std::size_t other = 0; other < k; ++other) {
      if (other == label) continue;
      const auto all = static_cast<double>(std::ranges::count(judged.labels, label));
      std::vector<std::pair<float, std::size_t>> against;  // margins of the label over the other class
      for (std::size_t s = 0; s < judged.rows.size(); ++s)
        if (const DescriptorView p = heldOut.row(judged.rows[s]);
            judged.labels[s] == label && p[other] > p[label])
          against.emplace_back(p[label] - p[other], judged.rows[s]);
      std::ranges::sort(against);
      const auto wrong = static_cast<std::size_t>(std::lround(all * joint[label * k + other]));
      for (std::size_t n = 0; n < std::min(wrong, against.size()); ++n)
        mislabeled.push_back(against[n].second);
    }
  std::ranges::sort(mislabeled);  // a sample may have several more probable classes
  mislabeled.erase(std::unique(mislabeled.begin(), mislabeled.end()), mislabeled.end());
  return mislabeled;
}

}  // namespace estancia
