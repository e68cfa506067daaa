// FAB-MAP beside sums over everything that may be, on four words and three places.
// SPDX-License-Identifier: Apache-2.0
#include "features/fab_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <functional>
#include <random>

#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using Words = std::bitset<4>;

LexicalDescriptor rowOfWords(Words words) {
  return {words[0] ? 1.0F : 0, words[1] ? 1.0F : 0, words[2] ? 1.0F : 0, words[3] ? 1.0F : 0};
}

DescriptorMatrix matrixOf(const std::vector<Words>& images) {
  DescriptorMatrix matrix(4);
  for (const Words image : images) matrix.append(rowOfWords(image));
  return matrix;
}

/// Word 3 mostly comes with word 0, word 1 with word 3, word 2 seldom with word 1.
std::vector<Words> imagesOfElsewhere() {
  std::mt19937 random(5);
  const auto chance = [&](double p) { return static_cast<double>(random()) < p * std::mt19937::max(); };
  std::vector<Words> images;
  for (int i = 0; i < 200; ++i) {
    Words image;
    image[0] = chance(0.5);
    image[3] = chance(image[0] ? 0.9 : 0.2);
    image[1] = chance(image[3] ? 0.8 : 0.2);
    image[2] = chance(image[1] ? 0.05 : 0.8);
    images.push_back(image);
  }
  return images;
}

/// The share of images with z_a = s and z_b = t, each of the four cases half an image more.
double share(const std::vector<Words>& images, std::size_t a, bool s, std::size_t b, bool t) {
  double count = 0.5;
  for (const Words image : images) count += image[a] == s && image[b] == t ? 1 : 0;
  return count / (static_cast<double>(images.size()) + 2);
}

double marginal(const std::vector<Words>& images, std::size_t word, bool s) {
  const std::size_t other = (word + 1) % 4;
  return share(images, word, s, other, false) + share(images, word, s, other, true);
}

/// Mean of ln p of an image whose words depend on their parents.
double logProbability(const std::vector<Words>& images, const std::vector<std::size_t>& parent) {
  double sum = 0;
  for (std::size_t w = 1; w < 4; ++w)
    for (const bool s : {false, true})
      for (const bool t : {false, true}) {
        const double together = share(images, w, s, parent[w], t);
        sum += together * std::log(together / marginal(images, parent[w], t));
      }
  return sum;
}

bool reachesRoot(const std::vector<std::size_t>& parent, std::size_t word) {
  for (int step = 0; step < 4; ++step) word = parent[word];
  return word == 0;
}

TEST(ChowLiuTree, MakesTheImagesMoreProbableThanAnyOtherTree) {
  const auto images = imagesOfElsewhere();
  const ChowLiuTree learned = learnChowLiuTree(matrixOf(images));
  int trees = 0;
  std::vector<std::size_t> best;
  for (std::size_t code = 0; code < 64; ++code) {
    const std::vector<std::size_t> parent{0, code % 4, code / 4 % 4, code / 16};
    if (!reachesRoot(parent, 1) || !reachesRoot(parent, 2) || !reachesRoot(parent, 3)) continue;
    ++trees;
    if (best.empty() || logProbability(images, parent) > logProbability(images, best)) best = parent;
  }
  EXPECT_EQ(trees, 16) << "Cayley's formula";
  EXPECT_EQ(learned.parent, best);
  EXPECT_THAT(learned.parent, testing::ElementsAre(0, 3, 1, 0)) << "as the images were made";
  for (std::size_t w = 0; w < 4; ++w) {
    EXPECT_NEAR(learned.shown[w], marginal(images, w, true), 1e-9);
    for (const bool t : {false, true})
      EXPECT_NEAR(learned.shownGivenParent[w][t ? 1 : 0],
                  w == 0 ? marginal(images, 0, true)
                         : share(images, w, true, best[w], t) / marginal(images, best[w], t),
                  1e-9);
  }
}

/// p(image | place) as a sum over which words are there, e; each e given by the place's image through the
/// detector, each z by e and by its parent: p(z | e, z_parent) ∝ p(z | e) p(z | z_parent) / p(z).
double likelihood(Words image, Words place, const std::vector<Words>& elsewhere,
                  const FabMapOptions& options) {
  const std::vector<std::size_t> parent{0, 3, 1, 0};
  const auto detect = [&](bool z, bool e) {
    const double one = e ? options.hit : options.falseAlarm;
    return z ? one : 1 - one;
  };
  double sum = 0;
  for (unsigned long there = 0; there < 16; ++there) {
    const Words e(there);
    double product = 1;
    for (std::size_t w = 0; w < 4; ++w) {
      const auto prior = [&](bool is) { return detect(place[w], is) * marginal(elsewhere, w, is); };
      product *= prior(e[w]) / (prior(false) + prior(true));
      const auto seen = [&](bool z) {
        if (w == 0) return detect(z, e[w]);
        const bool t = image[parent[w]];
        return detect(z, e[w]) * share(elsewhere, w, z, parent[w], t) / marginal(elsewhere, parent[w], t) /
               marginal(elsewhere, w, z);
      };
      product *= seen(image[w]) / (seen(false) + seen(true));
    }
    sum += product;
  }
  return sum;
}

TEST(FabMap, LikelihoodsAreTheSumOverAllWordsThatMayBeThere) {
  const auto elsewhere = imagesOfElsewhere();
  for (const FabMapOptions& options : {FabMapOptions{}, FabMapOptions{0.7, 0.1, 0.9, 0.99}}) {
    const FabMap model(matrixOf(elsewhere), options);
    std::vector<Words> all;
    for (unsigned long z = 0; z < 16; ++z) all.emplace_back(z);
    std::vector<double> totals(16);
    for (const Words image : all) {
      const auto found = model.logLikelihoods(rowOfWords(image), matrixOf(all));
      std::vector<double> expected;
      for (const Words place : all) {
        expected.push_back(likelihood(image, place, elsewhere, options));
        EXPECT_NEAR(std::exp(found[place.to_ulong()]), expected.back(), 1e-9);
        totals[place.to_ulong()] += expected.back();
      }
      double mean = 0;
      for (const Words one : elsewhere)
        mean += expected[one.to_ulong()] / static_cast<double>(elsewhere.size());
      EXPECT_NEAR(std::exp(model.logLikelihoodOfNew(rowOfWords(image))), mean, 1e-9);
    }
    EXPECT_THAT(totals, testing::Each(testing::DoubleNear(1, 1e-9))) << "of all images at a place";
  }
}

TEST(FabMap, BelievesWhatAllWaysThroughThePlacesSay) {
  const auto elsewhere = imagesOfElsewhere();
  const FabMapOptions options{0.39, 0, 0.4, 1};
  const FabMap model(matrixOf(elsewhere), options);
  const std::vector<Words> places{Words(9), Words(11), Words(4)}, images{Words(11), Words(4), Words(9)};
  const auto from = [&](std::size_t last, std::size_t next) {  // 3: somewhere new
    if (next == 3) return options.newPlace;
    if (last == 3) return (1 - options.newPlace) / 3;
    const double ways[3][3] = {{2, 1, 0}, {1, 1, 1}, {0, 1, 2}};
    return (1 - options.newPlace) * ways[last][next] / 3;
  };
  std::vector<std::vector<double>> seen(3);  // by image and place
  for (std::size_t i = 0; i < 3; ++i) {
    for (const Words place : places) seen[i].push_back(likelihood(images[i], place, elsewhere, options));
    seen[i].push_back(std::exp(model.logLikelihoodOfNew(rowOfWords(images[i]))));
  }
  const auto answers = model.recognize(matrixOf(images), matrixOf(places));
  ASSERT_EQ(answers.size(), 3U);
  for (std::size_t length = 1; length <= 3; ++length) {
    std::vector<double> ends(4);
    const std::function<void(std::size_t, std::size_t, double)> go = [&](std::size_t i, std::size_t last,
                                                                         double p) {
      if (i == length) {
        ends[last] += p;
        return;
      }
      for (std::size_t next = 0; next < 4; ++next) go(i + 1, next, p * from(last, next) * seen[i][next]);
    };
    go(0, 3, 1);
    const FabMap::Answer& answer = answers[length - 1];
    EXPECT_NEAR(answer.unknown, ends[3] / (ends[0] + ends[1] + ends[2] + ends[3]), 1e-9);
    EXPECT_EQ(answer.byAll,
              static_cast<std::size_t>(std::max_element(ends.begin(), ends.end() - 1) - ends.begin()));
  }
  EXPECT_EQ(answers[0].byImage, 1U);
  EXPECT_EQ(answers[1].byImage, 2U);
  EXPECT_EQ(answers[2].byImage, 0U);
}

TEST(FabMap, StaysInDoubtAsItsSmoothingSays) {
  const FabMap model(matrixOf(imagesOfElsewhere()), {0.39, 0, 0.5, 0});
  const auto answers = model.recognize(matrixOf({Words(9)}), matrixOf({Words(9), Words(6)}));
  EXPECT_NEAR(answers[0].unknown, 1.0 / 3, 1e-12) << "no weight on what was seen: all alike";
}

TEST(FabMap, RefusesToLearnFromNothingAndOtherWords) {
  EXPECT_THAT([] { learnChowLiuTree(DescriptorMatrix(4)); }, FailsWith(ErrorCode::insufficientData));
  const FabMap model(matrixOf(imagesOfElsewhere()));
  EXPECT_THAT([&] { model.recognize(matrixOf({Words(1)}), DescriptorMatrix(4)); },
              FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { model.logLikelihoods(LexicalDescriptor(3), matrixOf({Words(1)})); },
              FailsWith(ErrorCode::mismatch));
}

}  // namespace
}  // namespace estancia::experiments
