// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/ml.hpp>
#include <set>

#include "estancia/classify/classifier.hpp"
#include "estancia/classify/trainers.hpp"
#include "estancia/core/error.hpp"
#include "samples.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::clouds;
using test::FailsWith;
using test::trained;
using test::typed;

std::vector<std::string> types() {
  std::vector<std::string> names;
  for (const auto& [name, explanation] : classifierTypes()) names.push_back(name);
  return names;
}

class EachType : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Classifiers, EachType, testing::ValuesIn(types()), [](const auto& type) {
  std::string name = type.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST_P(EachType, LearnsCloudsThatHardlyOverlap) {
  const auto classifier = trained(clouds(4, 40, 10, 0.6, 1), typed(GetParam()));
  EXPECT_GT(test::accuracy(*classifier, clouds(4, 40, 10, 0.6, 2)), 0.95);
  const DescriptorMatrix p = classifier->predict(clouds(5, 20, 10, 5, 2).x);
  for (std::size_t i = 0; i < p.size(); ++i) {
    double sum = 0;
    for (const float value : p.row(i)) {
      EXPECT_GE(value, 0);
      sum += value;
    }
    EXPECT_NEAR(sum, 1, 1e-5);
  }
}

TEST_P(EachType, LearnsTheSameWithAnyNumberOfThreads) {
  const Samples samples = clouds(3, 41, 9, 1.5, 1), queries = clouds(3, 67, 9, 1.5, 2);
  ClassifierOptions one = typed(GetParam()), three = one;
  one.threads = 1;
  three.threads = 3;
  const auto a = trained(samples, one), b = trained(samples, three);
  EXPECT_EQ(test::bytesOf(*a), test::bytesOf(*b));
  EXPECT_EQ(a->predict(queries.x, 1).values(), b->predict(queries.x, 3).values());
}

TEST_P(EachType, AClassWithoutSamplesGetsNoProbability) {
  Samples samples = clouds(2, 12, 5, 0.5, 1);
  for (int& c : samples.classes) c = c == 0 ? 1 : 3;
  samples.classCount = 5;
  const auto classifier = trained(samples, typed(GetParam()));
  EXPECT_EQ(classifier->classCount(), 5);
  const DescriptorMatrix p = classifier->predict(samples.x);
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_EQ(p.row(i)[0] + p.row(i)[2] + p.row(i)[4], 0);
    EXPECT_GT(p.row(i)[static_cast<std::size_t>(samples.classes[i])], 0.5F);
  }
  const std::string bytes = test::bytesOf(*classifier);
  ByteReader in(bytes, "bytes", "look again");
  EXPECT_EQ(readClassifier(in)->predict(samples.x).values(), p.values());
}

TEST_P(EachType, BadInputIsRefused) {
  const Samples good = clouds(2, 10, 4, 1, 1);
  const auto trainOn = [&](const Samples& samples) {
    return test::caught([&] { trained(samples, typed(GetParam())); });
  };
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Samples samples = good;
    DescriptorMatrix x(4);
    for (std::size_t i = 0; i < good.x.size(); ++i) {
      std::vector<float> row(good.x.row(i).begin(), good.x.row(i).end());
      if (i == 7) row[2] = bad;
      x.append(row);
    }
    samples.x = x;
    EXPECT_THAT(trainOn(samples), FailsWith(ErrorCode::invalidInput));
    const auto classifier = trained(good, typed(GetParam()));
    EXPECT_THAT([&] { classifier->predict(x); }, FailsWith(ErrorCode::invalidInput));
    EXPECT_THAT([&] { classifier->predict(DescriptorMatrix(3)); }, FailsWith(ErrorCode::mismatch));
    EXPECT_EQ(classifier->predict(DescriptorMatrix(4)).size(), 0U);
  }
  Samples one = good;
  std::fill(one.classes.begin(), one.classes.end(), 1);
  EXPECT_THAT(trainOn(one), FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(trainOn({DescriptorMatrix(4), {}, {}, 2}), FailsWith(ErrorCode::insufficientData));
  Samples uneven = good;
  uneven.groups.pop_back();
  EXPECT_THAT(trainOn(uneven), FailsWith(ErrorCode::mismatch));
  Samples unknown = good;
  unknown.classes[3] = 2;
  EXPECT_THAT(trainOn(unknown), FailsWith(ErrorCode::invalidInput));
}

TEST(Classifier, OptionsOutOfRangeAreRefused) {
  const Samples samples = clouds(2, 5, 2, 1, 1);
  const std::pair<const char*, const char*> wrong[] = {{"c", "0"},     {"gamma", "0"}, {"neighbors", "0"},
                                                       {"trees", "0"}, {"folds", "0"}, {"gamma", "-1"},
                                                       {"folds", "1"}};
  for (const auto& option : wrong) {
    ClassifierOptions options;
    EXPECT_THAT([&] { declare(options).set(option.first, option.second); },
                FailsWith(ErrorCode::invalidOption))
        << option.first;
  }
  EXPECT_THAT([&] { trained(samples, {.c = 0}); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { trained(samples, {.metric = "taxi"}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { trained(samples, typed("net")); },
              FailsWith(ErrorCode::unknownName, "net", "svm-linear, svm-rbf, linear, forest, knn"));
}

TEST(Classifier, BalancingHelpsTheRareClass) {
  // Two clouds that overlap, one of them rare.
  Samples samples = clouds(2, 200, 3, 2.5, 1);
  DescriptorMatrix x(3);
  for (std::size_t i = 0; i < 220; ++i) x.append(samples.x.row(i));
  samples.x = x;
  samples.classes.resize(220);
  samples.groups.resize(220);
  const Samples queries = clouds(2, 200, 3, 2.5, 2);
  for (const std::string& type : types()) {
    ClassifierOptions plain = typed(type);
    plain.c = 1;
    plain.gamma = 0.1;
    plain.neighbors = 15;
    ClassifierOptions balanced = plain;
    balanced.balanced = true;
    const auto rare = [&](const ClassifierOptions& options) {
      const DescriptorMatrix p = trained(samples, options)->predict(queries.x);
      double sum = 0;
      for (std::size_t i = 200; i < 400; ++i) sum += p.row(i)[1];
      return sum / 200;
    };
    EXPECT_GT(rare(balanced), rare(plain) + 0.1) << type;
  }
}

/// The class probabilities of two normal clouds are known.
TEST(Classifier, ProbabilitiesAreCalibrated) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  const auto draw = [&](int count) {
    Samples samples{DescriptorMatrix(2), {}, {}, 2};
    for (int i = 0; i < count; ++i) {
      const int c = i % 2;
      samples.x.append(std::vector<float>{static_cast<float>(normal(random) + 1.5 * c),
                                          static_cast<float>(normal(random))});
      samples.classes.push_back(c);
      samples.groups.push_back(i / 10);
    }
    return samples;
  };
  const Samples samples = draw(600), queries = draw(400);
  for (const char* type : {"svm-linear", "svm-rbf", "linear"}) {
    const DescriptorMatrix p = trained(samples, typed(type))->predict(queries.x);
    double error = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double x = queries.x.row(i)[0];
      error += std::fabs(p.row(i)[1] - 1 / (1 + std::exp(-1.5 * (x - 0.75))));
    }
    EXPECT_LT(error / static_cast<double>(p.size()), 0.07) << type;  // 0.3 for a coin
  }
}

TEST(Linear, CGrowsWhileItHelps) {
  // Numbers so small that no weight is large enough before C is.
  const Samples samples = test::changed(clouds(4, 40, 10, 1.5, 1), 0, 0.01F);
  const std::string choice = trained(samples, typed("linear"))->choice();
  EXPECT_GT(std::stod(choice.substr(2)), 30) << choice;
}

/// A forest of one batch is OpenCV's own with that seed.
TEST(Forest, VotesAreThoseOfOpenCv) {
  const Samples samples = clouds(3, 30, 8, 2, 1), queries = clouds(3, 30, 8, 2, 2);
  ClassifierOptions options = typed("forest");
  options.trees = 10;
  const DescriptorMatrix p = trained(samples, options)->predict(queries.x);
  const auto toMat = [](const Samples& s) {
    return cv::Mat(static_cast<int>(s.x.size()), 8, CV_32F, const_cast<float*>(s.x.values().data())).clone();
  };
  const auto forest = cv::ml::RTrees::create();
  forest->setMaxDepth(25);
  forest->setMinSampleCount(2);
  forest->setTermCriteria({cv::TermCriteria::COUNT, 10, 0});
  cv::theRNG() = cv::RNG(options.seed * 1000003);
  forest->train(toMat(samples), cv::ml::ROW_SAMPLE, cv::Mat(samples.classes, true));
  cv::Mat votes;
  forest->getVotes(toMat(queries), votes, 0);
  for (int i = 0; i < 90; ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(p.row(static_cast<std::size_t>(i))[static_cast<std::size_t>(c)],
                  votes.at<int>(i + 1, c) / 10.0, 1e-6);
}

// ---- probabilities out of decisions

TEST(Coupling, SigmoidIsFoundAgain) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-4, 4), chance(0, 1);
  std::vector<double> f, weights;
  std::vector<char> first;
  for (int i = 0; i < 20000; ++i) {
    f.push_back(uniform(random));
    weights.push_back(1);
    first.push_back(chance(random) < 1 / (1 + std::exp(-1.7 * f.back() + 0.4)) ? 1 : 0);
  }
  const Sigmoid sigmoid = fitSigmoid(f, first, weights);
  EXPECT_NEAR(sigmoid.a, -1.7, 0.06);
  EXPECT_NEAR(sigmoid.b, 0.4, 0.06);
  EXPECT_EQ(sigmoid(-1e9), 0);
  EXPECT_EQ(sigmoid(1e9), 1);
}

/// The optimum of Wu, Lin & Weng's second method solves Q p = b, Σ p = 1 (their Eq. 21).
TEST(Coupling, PairsAreCoupledAsTheLinearSystemSays) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(0.05, 0.95);
  for (const std::size_t k : {2U, 3U, 7U}) {
    std::vector<double> r(k * k);
    for (std::size_t i = 0; i < k; ++i)
      for (std::size_t j = i + 1; j < k; ++j) r[j * k + i] = 1 - (r[i * k + j] = uniform(random));
    const auto size = static_cast<int>(k) + 1;
    cv::Mat_<double> a = cv::Mat_<double>::zeros(size, size), b = cv::Mat_<double>::zeros(size, 1), expected;
    for (int i = 0; i + 1 < size; ++i) {
      for (int j = 0; j + 1 < size; ++j) {
        if (i == j) continue;
        const double ofI = r[static_cast<std::size_t>(i) * k + static_cast<std::size_t>(j)],
                     ofJ = r[static_cast<std::size_t>(j) * k + static_cast<std::size_t>(i)];
        a(i, i) += ofJ * ofJ;
        a(i, j) = -ofJ * ofI;
      }
      a(i, size - 1) = a(size - 1, i) = 1;
    }
    b(size - 1) = 1;
    ASSERT_TRUE(cv::solve(a, b, expected));
    const std::vector<double> p = couplePairs(r, k);
    for (std::size_t i = 0; i < k; ++i) EXPECT_NEAR(p[i], expected(static_cast<int>(i)), 5e-3);
  }
}

// ---- folds

TEST(Folds, NeverPartAGroup) {
  std::mt19937 random(5);
  std::vector<int> classes, groups;
  for (int g = 0; g < 60; ++g)
    for (unsigned i = 0, n = 1 + random() % 9; i < n; ++i) {
      classes.push_back(g % 4);
      groups.push_back(g);
    }
  const std::vector<int> folds = groupedFolds(classes, groups, 5, 1);
  std::map<int, std::set<int>> ofGroup;
  std::map<std::pair<int, int>, double> counts;
  std::map<int, double> totals;
  for (std::size_t i = 0; i < folds.size(); ++i) {
    ofGroup[groups[i]].insert(folds[i]);
    ++counts[{folds[i], classes[i]}];
    ++totals[classes[i]];
  }
  for (const auto& [group, of] : ofGroup) EXPECT_EQ(of.size(), 1U);
  for (int f = 0; f < 5; ++f)
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(counts[std::pair(f, c)] / totals[c], 0.2, 0.1);
  EXPECT_EQ(folds, groupedFolds(classes, groups, 5, 1));
  EXPECT_NE(folds, groupedFolds(classes, groups, 5, 2));
}

TEST(Folds, ThingsStayWholeWhereTheirClassHasOthers) {
  // Class 0: things 7 and 3, with a sample misnamed; class 1: thing 5 alone.
  const std::vector<int> classes{0, 0, 1, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1},
      things{7, 7, 3, 3, 3, 5, 5, 5, 5, 5, 5, 5, 5};
  EXPECT_EQ(instanceGroups(classes, things, 2), (std::vector<int>{3, 3, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2}));
  EXPECT_EQ(instanceGroups(classes, things, 5), instanceGroups(classes, things, 2)) << "too short pieces";
  EXPECT_EQ(instanceGroups({0, 1}, {4, 4}, 5), (std::vector<int>{0, 0}));
  EXPECT_EQ(instanceGroups({}, {}, 5), std::vector<int>());
}

TEST(Folds, RunsEndWhereRoomsChangeAndNumbersJump) {
  std::vector<Frame> frames;
  for (const auto& [number, room] :
       {std::pair{1, "a"}, {2, "a"}, {3, "a"}, {40, "a"}, {41, "b"}, {42, "b"}, {43, "a"}})
    frames.push_back({std::to_string(1000 + number) + ".jpg", {}, {}, room});
  EXPECT_EQ(segmentGroups(frames, 1), (std::vector<int>{0, 0, 0, 1, 3, 3, 2}));
}

TEST(Knn, IsWhatBruteForceFinds) {
  const Samples samples = clouds(4, 57, 33, 2, 1), queries = clouds(4, 50, 33, 2, 2);
  for (const int k : {1, 9, 500}) {
    ClassifierOptions options = typed("knn");
    options.neighbors = k;
    options.metric = "euclidean";
    const DescriptorMatrix p = trained(samples, options)->predict(queries.x);
    for (std::size_t i = 0; i < queries.x.size(); ++i) {
      std::vector<std::pair<double, std::size_t>> all;
      for (std::size_t j = 0; j < samples.x.size(); ++j) {
        double sum = 0;
        for (std::size_t c = 0; c < 33; ++c) {
          const double d = static_cast<double>(queries.x.row(i)[c]) - samples.x.row(j)[c];
          sum += d * d;
        }
        all.emplace_back(std::sqrt(sum), j);
      }
      std::sort(all.begin(), all.end());
      std::vector<double> votes(4);
      double sum = 0;
      for (std::size_t n = 0; n < std::min<std::size_t>(static_cast<std::size_t>(k), all.size()); ++n) {
        votes[static_cast<std::size_t>(samples.classes[all[n].second])] += 1 / all[n].first;
        sum += 1 / all[n].first;
      }
      for (std::size_t c = 0; c < 4; ++c) ASSERT_NEAR(p.row(i)[c], votes[c] / sum, 1e-5) << k << " " << i;
    }
  }
}

TEST(Knn, TheCosineIgnoresLengths) {
  const Samples samples = clouds(3, 20, 5, 1, 1);
  ClassifierOptions options = typed("knn");
  options.neighbors = 5;
  options.metric = "cosine";
  Samples longer = samples;
  longer.x = DescriptorMatrix(5);
  for (std::size_t i = 0; i < samples.x.size(); ++i) {
    std::vector<float> row(samples.x.row(i).begin(), samples.x.row(i).end());
    for (float& value : row) value *= static_cast<float>(1U << (i % 5));  // exact in float32
    longer.x.append(row);
  }
  EXPECT_EQ(trained(longer, options)->predict(samples.x).values(),
            trained(samples, options)->predict(longer.x).values());
}

TEST(Knn, NumbersTooLargeForDistancesAreRefused) {
  const Samples good = clouds(2, 10, 4, 1, 1), huge = test::changed(good, 0, 1e20F);
  for (const char* metric : {"euclidean", "cosine"}) {
    ClassifierOptions options = typed("knn");
    options.metric = metric;
    const auto classifier = trained(good, options);
    EXPECT_THAT([&] { trained(huge, options); }, FailsWith(ErrorCode::invalidInput));
    EXPECT_THAT([&] { classifier->predict(huge.x); }, FailsWith(ErrorCode::invalidInput));
  }
}

}  // namespace
}  // namespace estancia
