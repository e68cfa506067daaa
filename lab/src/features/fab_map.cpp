// SPDX-License-Identifier: Apache-2.0
#include "features/fab_map.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia::experiments {
namespace {

/// p(z_a = s, z_b = t) at 2 s + t, from numbers of images.
std::array<double, 4> jointOf(double a, double b, double both, double images) {
  std::array<double, 4> cases{images - a - b + both, b - both, a - both, both};
  for (double& count : cases) count = (count + 0.5) / (images + 2);
  return cases;
}

double mutualInformation(const std::array<double, 4>& joint) {
  double sum = 0;
  for (std::size_t s = 0; s < 2; ++s)
    for (std::size_t t = 0; t < 2; ++t) {
      const double p = joint[2 * s + t];
      sum += p * std::log(p / ((joint[2 * s] + joint[2 * s + 1]) * (joint[t] + joint[2 + t])));
    }
  return sum;
}

/// How many images show both words of each pair, and on the diagonal one word.
cv::Mat countsTogether(const DescriptorMatrix& images) {
  const cv::Mat rows(static_cast<int>(images.size()), static_cast<int>(images.labels()), CV_32F,
                     const_cast<float*>(images.values().data()));
  return rows.t() * rows;  // exact: whole numbers below 2^24
}

std::size_t isShown(float value) {
  return value > 0.5F ? 1 : 0;
}

/// ln of the sum of exponentials.
double logSum(const std::vector<double>& logs) {
  const double largest = *std::ranges::max_element(logs);
  double sum = 0;
  for (const double log : logs) sum += std::exp(log - largest);
  return largest + std::log(sum);
}

std::size_t largestOf(const std::vector<double>& values, std::size_t count) {
  return static_cast<std::size_t>(
      std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count)) - values.begin());
}

/// The prior of the next image, from the posterior of the last one (the new place stands behind all places).
/// A robot that would leave the drive at one of its ends stays there.
std::vector<double> predicted(const std::vector<double>& posterior, double newPlace) {
  const std::size_t places = posterior.size() - 1;
  std::vector<double> next(posterior.size(), posterior[places] / static_cast<double>(places));
  for (std::size_t i = 0; i < places; ++i)
    for (const std::size_t to : {i == 0 ? i : i - 1, i, std::min(i + 1, places - 1)})
      next[to] += posterior[i] / 3;
  for (double& value : next) value *= 1 - newPlace;
  next[places] = newPlace;
  return next;
}

}  // namespace

ChowLiuTree learnChowLiuTree(const DescriptorMatrix& images) {
  const std::size_t words = images.labels();
  if (words == 0 || images.size() == 0)
    fail(ErrorCode::insufficientData, "words that come together are learned from images; give some");
  const cv::Mat counts = countsTogether(images);
  const auto joint = [&](std::size_t a, std::size_t b) {
    const auto at = [&](std::size_t r, std::size_t c) -> double {
      return counts.at<float>(static_cast<int>(r), static_cast<int>(c));
    };
    return jointOf(at(a, a), at(b, b), at(a, b), static_cast<double>(images.size()));
  };
  ChowLiuTree tree{std::vector<std::size_t>(words), {}, std::vector<std::array<double, 2>>(words)};
  for (std::size_t w = 0; w < words; ++w) {
    const auto own = static_cast<double>(counts.at<float>(static_cast<int>(w), static_cast<int>(w)));
    tree.shown.push_back((own + 1) / (static_cast<double>(images.size()) + 2));  // the sum of two joint cases
  }
  tree.shownGivenParent[0] = {tree.shown[0], tree.shown[0]};
  std::vector<double> gain(words, -1);  // to the nearest word of the tree; Prim's algorithm
  std::vector<bool> inside(words);
  for (std::size_t added = 0, next = 0; added < words; ++added) {
    inside[next] = true;
    if (const std::size_t parent = tree.parent[next]; next != 0) {
      const auto p = joint(next, parent);
      tree.shownGivenParent[next] = {p[2] / (p[0] + p[2]), p[3] / (p[1] + p[3])};
    }
    const std::size_t from = next;
    for (std::size_t w = 0; w < words; ++w) {
      if (inside[w]) continue;
      if (const double information = mutualInformation(joint(w, from)); information > gain[w]) {
        gain[w] = information;
        tree.parent[w] = from;
      }
      if (inside[next] || gain[w] > gain[next]) next = w;
    }
  }
  return tree;
}

FabMap::FabMap(DescriptorMatrix learned, const FabMapOptions& options)
    : learned_(std::move(learned)), options_(options), tree_(learnChowLiuTree(learned_)) {
  const auto detector = [&](std::size_t z, std::size_t e) {
    const double one = e == 1 ? options_.hit : options_.falseAlarm;
    return z == 1 ? one : 1 - one;
  };
  for (std::size_t w = 0; w < tree_.parent.size(); ++w) {
    const auto marginal = [&](std::size_t z) { return z == 1 ? tree_.shown[w] : 1 - tree_.shown[w]; };
    const auto given = [&](std::size_t z, std::size_t t) {
      return z == 1 ? tree_.shownGivenParent[w][t] : 1 - tree_.shownGivenParent[w][t];
    };
    auto& terms = terms_.emplace_back();
    for (std::size_t i = 0; i < terms.size(); ++i) {
      const std::size_t s = i / 4, t = i / 2 % 2, b = i % 2;
      double sum = 0;
      for (std::size_t e = 0; e < 2; ++e) {
        // p(e | the place's image); its prior is p(z), as in the paper
        const double there =
            detector(b, e) * marginal(e) / (detector(b, 0) * marginal(0) + detector(b, 1) * marginal(1));
        // p(z = s | e, z of the parent = t) = β / (α + β): e and the parent's z are independent given z
        const double alpha = marginal(s) * detector(1 - s, e) * given(1 - s, t);
        const double beta = marginal(1 - s) * detector(s, e) * given(s, t);
        sum += there * beta / (alpha + beta);
      }
      terms[i] = std::log(sum);
    }
  }
}

std::vector<double> FabMap::logLikelihoods(DescriptorView image, const DescriptorMatrix& places) const {
  const std::size_t words = terms_.size();
  if (image.size() != words || places.labels() != words)
    fail(ErrorCode::mismatch, "an image of {} words, places of {} and a model of {}; take one vocabulary",
         image.size(), places.labels(), words);
  std::vector<std::array<double, 2>> ofPlace;  // a word's term by whether the place's image shows it
  for (std::size_t w = 0; w < words; ++w) {
    const std::size_t at = 4 * isShown(image[w]) + 2 * isShown(image[tree_.parent[w]]);
    ofPlace.push_back({terms_[w][at], terms_[w][at + 1]});
  }
  std::vector<double> logs(places.size());
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t w = 0; w < words; ++w) logs[i] += ofPlace[w][isShown(places.row(i)[w])];
  return logs;
}

double FabMap::logLikelihoodOfNew(DescriptorView image) const {
  return logSum(logLikelihoods(image, learned_)) - std::log(static_cast<double>(learned_.size()));
}

std::vector<FabMap::Answer> FabMap::recognize(const DescriptorMatrix& images,
                                              const DescriptorMatrix& places) const {
  if (places.size() == 0) fail(ErrorCode::insufficientData, "there are no places to recognize; give some");
  const std::size_t count = places.size();
  std::vector<double> posterior(count + 1, 0);
  posterior[count] = 1;
  std::vector<Answer> answers;
  for (std::size_t i = 0; i < images.size(); ++i) {
    std::vector<double> logs = logLikelihoods(images.row(i), places);
    Answer answer{largestOf(logs, count)};
    logs.push_back(logLikelihoodOfNew(images.row(i)));
    const std::vector<double> prior = predicted(posterior, options_.newPlace);
    for (std::size_t p = 0; p <= count; ++p) logs[p] += std::log(prior[p]);
    const double all = logSum(logs);
    for (std::size_t p = 0; p <= count; ++p)
      posterior[p] = options_.smoothing * std::exp(logs[p] - all) +
                     (1 - options_.smoothing) / static_cast<double>(count + 1);
    answer.byAll = largestOf(posterior, count);
    answer.unknown = posterior[count];
    answers.push_back(answer);
  }
  return answers;
}

}  // namespace estancia::experiments
