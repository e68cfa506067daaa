// Made-up samples, and classifiers taken apart.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/bytes.hpp"
#include "estancia/describe/features.hpp"

namespace estancia::test {

/// Normal clouds, one a class, each group of a class somewhat apart; `spread` of 0.5 hardly overlaps.
inline Samples clouds(int classes, int perClass, std::size_t columns, double spread, unsigned seed) {
  std::mt19937 places(11), random(seed);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> centers(static_cast<std::size_t>(classes), std::vector<double>(columns));
  for (auto& center : centers)
    for (double& v : center) v = normal(places);
  Samples samples{DescriptorMatrix(columns), {}, {}, classes};
  for (int c = 0; c < classes; ++c)
    for (int i = 0; i < perClass; ++i) {
      std::vector<float> row;
      for (std::size_t k = 0; k < columns; ++k)
        row.push_back(static_cast<float>(centers[static_cast<std::size_t>(c)][k] + spread * normal(random)));
      samples.x.append(row);
      samples.classes.push_back(c);
      samples.groups.push_back(c * perClass + i / 4);
    }
  return samples;
}

/// The samples moved and scaled.
inline Samples changed(const Samples& samples, float added, float factor) {
  Samples result = samples;
  result.x = DescriptorMatrix(samples.x.labels());
  for (std::size_t i = 0; i < samples.x.size(); ++i) {
    std::vector<float> row(samples.x.row(i).begin(), samples.x.row(i).end());
    for (float& value : row) value = value * factor + added;
    result.x.append(row);
  }
  return result;
}

inline std::unique_ptr<Classifier> trained(const Samples& samples, ClassifierOptions options) {
  return trainClassifier(samples, options);
}

/// The share of samples whose most probable class is theirs.
inline double accuracy(const Classifier& classifier, const Samples& samples) {
  const DescriptorMatrix p = classifier.predict(samples.x);
  double right = 0;
  for (std::size_t i = 0; i < p.size(); ++i)
    right +=
        std::max_element(p.row(i).begin(), p.row(i).end()) - p.row(i).begin() == samples.classes[i] ? 1 : 0;
  return right / static_cast<double>(p.size());
}

inline ClassifierOptions typed(const std::string& type) {
  ClassifierOptions options;
  options.type = type;
  options.trees = 50;
  return options;
}

inline std::string bytesOf(const Classifier& classifier) {
  ByteWriter out;
  classifier.write(out);
  return out.bytes();
}

/// Past what all kinds write first: name, classes.
inline ByteReader afterHead(const std::string& bytes) {
  ByteReader in(bytes, "bytes", "look again");
  in.text();
  in.number<std::int32_t>();
  in.numbers<std::int32_t>();
  return in;
}

/// Frames of made-up rooms described by two parts: words (a softmax) and a histogram.
inline Features madeUpRooms(int rooms, int perRoom, unsigned seed, std::size_t words = 12,
                            std::size_t bins = 6) {
  std::mt19937 places(5), random(seed);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> logits(static_cast<std::size_t>(rooms), std::vector<double>(words));
  for (auto& room : logits)
    for (double& l : room) l = 2 * normal(places);
  Features features{
      {{"words", PartKind::probabilities, {}, "words 1"}, {"bins", PartKind::histogram, {}, "bins 1"}},
      {},
      DescriptorMatrix(words + bins)};
  for (std::size_t w = 0; w < words; ++w) features.parts[0].columns.push_back("word " + std::to_string(w));
  for (std::size_t b = 0; b < bins; ++b) features.parts[1].columns.push_back("bin " + std::to_string(b));
  for (int r = 0; r < rooms; ++r)
    for (int i = 0; i < perRoom; ++i) {
      std::vector<float> row;
      float sum = 0;
      for (const double l : logits[static_cast<std::size_t>(r)]) {
        row.push_back(static_cast<float>(std::exp(l + normal(random))));
        sum += row.back();
      }
      for (float& v : row) v /= sum;
      for (std::size_t b = 0; b < bins; ++b)
        row.push_back(static_cast<float>(std::fabs(normal(random)) + (static_cast<int>(b) == r ? 1 : 0)));
      features.values.append(row);
      Frame frame;
      frame.name = "frame " + std::to_string(1000 * r + i + (i / 5) * 50);
      frame.room = "room " + std::to_string(r);
      features.frames.push_back(frame);
    }
  return features;
}

}  // namespace estancia::test
