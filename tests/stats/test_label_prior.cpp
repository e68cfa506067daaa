// Label priors: the builtin ones, what labels they are found by, and files that are none.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/label_prior.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "estancia/stats/label_scale.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::caught;
using test::FailsWith;

NamedLabelPrior builtin(const std::string& name) {
  return parseLabelPrior(test::readFile(std::string(ESTANCIA_SOURCE_DIR) + "/models/priors/" + name), name);
}

/// A prior file of these labels.
std::string fileOf(const std::string& labels) {
  std::string text = "estancia-label-prior 1\n# of a test\nimages 10\ndistances";
  for (int i = 0; i <= 100; ++i) text += " " + std::to_string(0.5 + 0.01 * i);
  return text + "\ndimensions 20\n" + labels;
}

TEST(LabelPrior, IsFoundByTheFirstSynonymsOfLabels) {
  const NamedLabelPrior imagenet = builtin("imagenet.prior");
  ASSERT_EQ(imagenet.labels.size(), 1001U);
  std::vector<std::string> labels = imagenet.labels;
  labels.erase(labels.begin());  // Caffe's list has no background …
  for (std::string& label : labels) label[0] = static_cast<char>(std::toupper(label[0]));
  labels[0] += ", Tinca tinca";  // … and synonyms
  std::ranges::reverse(labels);
  const LabelPrior found = labelPriorOf(Vocabulary(labels));
  ASSERT_EQ(found.center.size(), 1000U);
  EXPECT_EQ(found.center[999], imagenet.prior.center[1]);
  EXPECT_EQ(found.variance[0], imagenet.prior.variance[1000]);
  EXPECT_EQ(found.distances, imagenet.prior.distances);
  EXPECT_NEAR(found.distanceAt(0.03), 0.71, 0.01) << "the third quantile";
  EXPECT_DOUBLE_EQ(found.distanceAt(0.035), (found.distances[3] + found.distances[4]) / 2);
  EXPECT_DOUBLE_EQ(found.distanceAt(1), found.distances[100]);
}

TEST(LabelPrior, OfSeveralModelsAddsUp) {
  const NamedLabelPrior coco = builtin("coco.prior");
  const std::size_t n = coco.labels.size();
  std::vector<std::string> twice = coco.labels;
  twice.insert(twice.end(), coco.labels.begin(), coco.labels.end());
  const LabelPrior both = labelPriorOf(Vocabulary(twice, {{n, 1}, {n, 1}}));
  ASSERT_EQ(both.center.size(), 2 * n);
  EXPECT_EQ(both.center[n + 1], coco.prior.center[1]);
  // The mean of two deviations with a correlation of 0.4 has a variance of (1 + 0.4)/2.
  EXPECT_NEAR(both.dimensions, coco.prior.dimensions / 0.7, 1e-9);
  EXPECT_NEAR(1 - both.distanceAt(0.1), (1 - coco.prior.distanceAt(0.1)) * std::sqrt(0.7), 1e-9);
}

TEST(LabelPrior, GivesWayToTheRun) {
  const NamedLabelPrior file = parseLabelPrior(fileOf("1.00\t0.50\tbed\n-1.00\t2.00\tsofa\n"), "x");
  const Distance distance = getDistance("standardized-clr");
  LabelScale scale(distance, 2, file.prior);
  const std::vector<float> before = scale.standardization().center;
  EXPECT_TRUE(before.empty()) << "no frame yet";
  const std::vector<std::vector<float>> images{{0.9F, 0.1F}, {0.2F, 0.8F}, {0.6F, 0.4F}};
  const auto add = [&](int times) {
    for (int i = 0; i < times; ++i) {
      const auto& p = images[static_cast<std::size_t>(i) % 3];
      std::vector<float> embedded(2);
      embed(distance.embedding, p, embedded);
      scale.add(p, embedded);
    }
  };
  add(1);
  EXPECT_GT(scale.standardization().center[0], 0.9F) << "nearly the prior's";
  add(600);
  EXPECT_NEAR(scale.standardization().center[0], scale.moments().mean()[0], 0.04);
}

TEST(LabelPrior, IsKeptAsBytes) {
  const LabelPrior prior = builtin("coco.prior").prior;
  const std::string bytes = prior.toBytes();
  const LabelPrior back = LabelPrior::fromBytes(bytes, prior.center.size());
  EXPECT_EQ(back.center, prior.center);
  EXPECT_EQ(back.variance, prior.variance);
  EXPECT_EQ(back.distances, prior.distances);
  EXPECT_EQ(back.dimensions, prior.dimensions);
  EXPECT_THAT(caught([&] { LabelPrior::fromBytes(bytes, 3); }), FailsWith(ErrorCode::corruptFile));
  for (std::size_t length = 0; length < bytes.size(); length += 5)
    EXPECT_ANY_THROW(LabelPrior::fromBytes(bytes.substr(0, length), prior.center.size())) << length;
}

TEST(LabelPrior, RefusesOtherFiles) {
  EXPECT_NO_THROW(parseLabelPrior(fileOf("1.00\t0.50\tbed\n"), "x"));
  const auto refused = [](const std::string& text) {
    return caught([&] { parseLabelPrior(text, "x.prior"); });
  };
  EXPECT_THAT(refused(""), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refused("estancia-label-prior 2\n"), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(refused(fileOf("")), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refused(fileOf("1.00\tbed\n")), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refused(fileOf("1.00\t-1\tbed\n")), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refused(fileOf("1.00\t1.00\t\n")), FailsWith(ErrorCode::malformedFile));
  std::string text = fileOf("1.00\t0.50\tbed\n");
  EXPECT_THAT(refused(text.replace(text.find("0.5"), 3, "9.5")), FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia
