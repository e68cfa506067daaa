// Comparison with scikit-learn: sklearn_classify.py wrote its answers, and the samples are made anew here.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "estancia/classify/label_selection.hpp"
#include "estancia/classify/predict_rooms.hpp"
#include "samples.hpp"
#include "stats/scipy_random.hpp"

namespace estancia {
namespace {

using Json = nlohmann::json;
constexpr int classCount = 4;
constexpr std::size_t columns = 6;

using test::Random;

Samples samplesOf(std::uint64_t seed, int count) {
  Random random(seed), center(99);
  std::vector<std::vector<double>> centers(classCount, std::vector<double>(columns));
  for (auto& of : centers)
    for (double& v : of) v = center.uniform();
  Samples samples{DescriptorMatrix(columns), {}, {}, classCount};
  for (int i = 0; i < count; ++i) {
    const int c = std::min(i * i % 7, 3);
    std::vector<float> row;
    for (const double v : centers[static_cast<std::size_t>(c)])
      row.push_back(static_cast<float>(v + random.uniform()));
    samples.x.append(row);
    samples.classes.push_back(c);
    samples.groups.push_back(i);
  }
  return samples;
}

const Json& expected() {
  static const Json json =
      Json::parse(std::ifstream(std::string(ESTANCIA_SOURCE_DIR) + "/tests/classify/sklearn_classify.json"));
  return json;
}

/// Decision values by plain loops over what the classifier writes to its file.
std::vector<double> decisions(const Classifier& classifier, DescriptorView x) {
  const std::string bytes = test::bytesOf(classifier);
  ByteReader in = test::afterHead(bytes);
  const auto gamma = in.number<double>();
  const auto starts = in.numbers<std::uint64_t>();
  const auto coefficients = in.numbers<double>();
  const auto rho = in.numbers<double>();
  in.raw(rho.size() * 2 * sizeof(double));
  const auto width = in.number<std::uint64_t>();
  const auto vectors = in.numbers<float>();
  const std::size_t k = starts.size() - 1;
  std::vector<double> f;
  for (std::size_t i = 0, p = 0; i < k; ++i)
    for (std::size_t j = i + 1; j < k; ++j, ++p) {
      double sum = -rho[p];
      const auto add = [&](std::size_t v, double coefficient) {
        double dot = 0, square = 0;
        for (std::size_t c = 0; c < width; ++c) {
          const double a = vectors[v * width + c];
          dot += a * x[c];
          square += (a - x[c]) * (a - x[c]);
        }
        sum += coefficient * (gamma > 0 ? std::exp(-gamma * square) : dot);
      };
      if (gamma == 0) {
        add(p, 1);
      } else {
        for (std::size_t v = starts[i]; v < starts[i + 1]; ++v) add(v, coefficients[v * (k - 1) + j - 1]);
        for (std::size_t v = starts[j]; v < starts[j + 1]; ++v) add(v, coefficients[v * (k - 1) + i]);
      }
      f.push_back(sum);
    }
  return f;
}

void expectDecisions(const char* key, const ClassifierOptions& options) {
  const auto classifier = test::trained(samplesOf(1, 160), options);
  const Samples queries = samplesOf(2, 40);
  for (std::size_t i = 0; i < queries.x.size(); ++i) {
    const std::vector<double> f = decisions(*classifier, queries.x.row(i));
    ASSERT_EQ(f.size(), 6U);
    // The solver stops within 1e-3 of the optimum.
    for (std::size_t p = 0; p < f.size(); ++p) EXPECT_NEAR(f[p], expected()[key][i][p].get<double>(), 5e-3);
  }
}

TEST(Sklearn, SvmDecisionsAreTheSame) {
  ClassifierOptions options = test::typed("svm-rbf");
  options.c = 3;
  options.gamma = 0.7;
  expectDecisions("svm", options);
  options.balanced = true;
  expectDecisions("svm_balanced", options);
  ClassifierOptions linear = test::typed("svm-linear");
  linear.c = 3;
  expectDecisions("linear_svm", linear);
}

void expectProbabilities(const char* key, const ClassifierOptions& options, double tolerance) {
  const DescriptorMatrix p = test::trained(samplesOf(1, 160), options)->predict(samplesOf(2, 40).x);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t c = 0; c < classCount; ++c)
      EXPECT_NEAR(p.row(i)[c], expected()[key][i][c].get<double>(), tolerance) << "sample " << i;
}

TEST(Sklearn, LogisticProbabilitiesAndVotesOfNeighborsAreTheSame) {
  ClassifierOptions options = test::typed("linear");
  options.c = 10;
  expectProbabilities("logistic", options, 0.02);
  ClassifierOptions votes = test::typed("knn");
  votes.neighbors = 7;
  votes.metric = "euclidean";
  expectProbabilities("knn", votes, 1e-5);
}

Features featuresOf(const Samples& samples, double step) {
  Features features{{{"words", PartKind::probabilities, {}, "words"}}, {}, DescriptorMatrix(columns)};
  for (std::size_t c = 0; c < columns; ++c) features.parts[0].columns.push_back(std::to_string(c));
  for (std::size_t i = 0; i < samples.x.size(); ++i) {
    Frame frame;
    frame.name = std::to_string(i);
    frame.room = std::to_string(samples.classes[i]);
    features.frames.push_back(frame);
    std::vector<float> row(samples.x.row(i).begin(), samples.x.row(i).end());
    for (float& v : row)
      if (step > 0) v = static_cast<float>(std::floor(v / step) * step);
    features.values.append(row);
  }
  return features;
}

TEST(Sklearn, SelectionScoresAreTheSame) {
  const Samples samples = samplesOf(1, 160);
  const std::vector<double> chi2 = columnScores(featuresOf(samples, 0), "chi2");
  const std::vector<double> information = columnScores(featuresOf(samples, 0.25), "mutual-information");
  for (std::size_t c = 0; c < columns; ++c) {
    EXPECT_NEAR(chi2[c], expected()["chi2"][c].get<double>(), 1e-5);
    EXPECT_NEAR(information[c], expected()["mutual_information"][c].get<double>(), 1e-8);
  }
}

TEST(Sklearn, BalancedAccuracyIsTheSame) {
  std::vector<std::string> truth, guesses;
  const Samples samples = samplesOf(2, 40);
  for (int i = 0; i < 40; ++i) {
    const int c = samples.classes[static_cast<std::size_t>(i)];
    truth.push_back(std::to_string(c));
    guesses.push_back(std::to_string((c + (i % 3 == 0 ? 1 : 0)) % classCount));
  }
  EXPECT_NEAR(confusionOf(truth, guesses).balancedAccuracy(), expected()["balanced_accuracy"].get<double>(),
              1e-12);
}

}  // namespace
}  // namespace estancia
