// Made-up things: shapes as histograms, and a labeler that is mostly right about them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/objects/class_probabilities.hpp"

namespace estancia::test {

inline TargetClasses madeUpStudy(int words) {
  std::vector<std::string> names;
  names.reserve(static_cast<std::size_t>(words));
  for (int w = 0; w < words; ++w) names.push_back(fmt::format("word {}", w));
  return targetClassesOf(names);
}

/// Views of things whose words are known.
struct MadeUpThings {
  Features shapes{{{"esf", PartKind::histogram, {}, "esf 1"}}, {}, DescriptorMatrix(0)};
  std::vector<int> classes, instances;  ///< one a view
};

struct Manner {
  std::size_t columns = 24;
  double apart = 0.3;   ///< how far the things of a word are from each other, in units of words' distance
  double spread = 0.5;  ///< and the views of a thing
};

/// `things` of each word, `views` of each; those of the same seed have the same words, but other `draw`s give
/// other views.
inline MadeUpThings madeUpThings(int words, int things, int views, unsigned draw, const Manner& manner = {}) {
  std::mt19937 places(3), random(draw);
  std::normal_distribution<double> normal;
  MadeUpThings all;
  for (std::size_t c = 0; c < manner.columns; ++c)
    all.shapes.parts[0].columns.push_back(fmt::format("bin {}", c));
  all.shapes.values = DescriptorMatrix(manner.columns);
  const auto moved = [&](std::vector<double> from, double by, std::mt19937& engine) {
    for (double& v : from) v += by * normal(engine);
    return from;
  };
  for (int w = 0; w < words; ++w) {
    const auto word = moved(std::vector<double>(manner.columns), 1, places);
    for (int t = 0; t < things; ++t) {
      const auto thing = moved(word, manner.apart, places);
      for (int v = 0; v < views; ++v) {
        std::vector<float> row;
        float sum = 0;
        for (const double number : moved(thing, manner.spread, random)) {
          row.push_back(static_cast<float>(std::exp(number)));
          sum += row.back();
        }
        for (float& value : row) value /= sum;
        all.shapes.values.append(row);
        all.shapes.frames.emplace_back().name = fmt::format("{}-{}-{}", w, t, v);
        all.classes.push_back(w);
        all.instances.push_back(w * things + t);
      }
    }
  }
  return all;
}

/// Shares of one word each, 0.6, and of the others alike.
inline ClassProbabilities saying(const std::vector<int>& words, std::size_t count) {
  ClassProbabilities said{DescriptorMatrix(count), std::vector<float>(words.size(), 0.5F)};
  for (const int word : words) {
    std::vector<float> row(count, 0.4F / static_cast<float>(count - 1));
    row[static_cast<std::size_t>(word)] = 0.6F;
    said.probabilities.append(row);
  }
  return said;
}

inline DescriptorMatrix rows(const std::vector<std::vector<float>>& values) {
  DescriptorMatrix matrix(values.empty() ? 0 : values.front().size());
  for (const auto& row : values) matrix.append(row);
  return matrix;
}

inline int best(DescriptorView row) {
  return static_cast<int>(std::ranges::max_element(row) - row.begin());
}

inline double shareRight(const DescriptorMatrix& probabilities, const std::vector<int>& truth) {
  double right = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) right += best(probabilities.row(i)) == truth[i] ? 1 : 0;
  return right / static_cast<double>(truth.size());
}

}  // namespace estancia::test
