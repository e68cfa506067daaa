// Made-up places: each has its own likely labels, each image of it varies. Seeded, no network needed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <random>
#include <vector>

namespace estancia::test {

class SyntheticPlaces {
 public:
  SyntheticPlaces(std::size_t places, std::size_t labels, double variation = 0.5, unsigned seed = 7)
      : variation_(variation), random_(seed) {
    for (std::size_t p = 0; p < places; ++p) {
      std::vector<double> logits(labels);
      for (double& l : logits) l = 1.5 * normal_(random_);
      logits_.push_back(std::move(logits));
    }
  }

  std::vector<float> image(std::size_t place) {
    std::vector<float> p(logits_[place].size());
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
      sum += p[i] = static_cast<float>(std::exp(logits_[place][i] + variation_ * normal_(random_)));
    for (float& v : p) v = static_cast<float>(v / sum);
    return p;
  }

  /// `stay` images at each of the places, in the order given.
  std::vector<std::vector<float>> drive(const std::vector<std::size_t>& places, std::size_t stay) {
    std::vector<std::vector<float>> images;
    for (const std::size_t place : places)
      for (std::size_t i = 0; i < stay; ++i) images.push_back(image(place));
    return images;
  }

 private:
  double variation_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::vector<std::vector<double>> logits_;
};

}  // namespace estancia::test
