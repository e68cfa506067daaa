// Labels in another order: what cumulated distances make of it, and all others do not.
// SPDX-License-Identifier: Apache-2.0
#include "zones/label_order.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "estancia/stats/linkage.hpp"
#include "estancia/zones/image_tree.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using testing::ElementsAre;

/// Two images of four labels: of one model, or of two models with two labels each.
DescriptorSequence twoImages(std::vector<LabelPart> parts = {}) {
  DescriptorSequence sequence{Vocabulary({"wolf", "dog", "tench", "stove"}, std::move(parts)), "made up",
                              std::vector<Frame>(2), DescriptorMatrix(4)};
  sequence.descriptors.append(LexicalDescriptor{0.5F, 0, 0.5F, 0});
  sequence.descriptors.append(LexicalDescriptor{0, 0.5F, 0, 0.5F});
  return sequence;
}

double distanceOf(const DescriptorSequence& sequence, const std::string& name) {
  ZoneOptions options;
  options.distance = name;
  options.linkage = "average";
  return compareImages(sequence, options, Progress::none())(0, 1);
}

TEST(LabelOrder, ByNameIsTheAlphabets) {
  const DescriptorSequence ordered = inLabelOrder(twoImages(), "name");
  EXPECT_THAT(ordered.vocabulary.labels(), ElementsAre("dog", "stove", "tench", "wolf"));
  EXPECT_THAT(ordered.descriptors.row(0), ElementsAre(0, 0, 0.5F, 0.5F));
  EXPECT_THAT(ordered.descriptors.row(1), ElementsAre(0.5F, 0.5F, 0, 0));
  EXPECT_EQ(inLabelOrder(twoImages(), "network").vocabulary, twoImages().vocabulary);
}

TEST(LabelOrder, ChangesCumulatedDistancesAlone) {
  const DescriptorSequence network = twoImages(), byName = inLabelOrder(network, "name");
  EXPECT_NEAR(distanceOf(network, "cumulative-ks"), 0.5, 1e-7) << "a wolf stands beside a dog";
  EXPECT_NEAR(distanceOf(byName, "cumulative-ks"), 1, 1e-7) << "a dog before all, a wolf behind";
  for (const char* distance : {"ks", "l1", "hellinger"})
    EXPECT_NEAR(distanceOf(network, distance), distanceOf(byName, distance), 1e-7) << distance;
}

TEST(LabelOrder, LabelsOfEachModelStayTogether) {
  const DescriptorSequence ordered = inLabelOrder(twoImages({{2, 1}, {2, 1}}), "name");
  EXPECT_THAT(ordered.vocabulary.labels(), ElementsAre("dog", "wolf", "stove", "tench"));
  EXPECT_EQ(ordered.vocabulary.layout().parts.size(), 2U);
}

TEST(LabelOrder, ShufflesBySeed) {
  const auto shuffled = [](std::uint64_t seed) {
    return inLabelOrder(twoImages(), "shuffled", seed).vocabulary.labels();
  };
  EXPECT_EQ(shuffled(1), shuffled(1));
  int others = 0;
  for (std::uint64_t seed = 2; seed < 12; ++seed) {
    others += shuffled(seed) != shuffled(1) ? 1 : 0;
    EXPECT_THAT(shuffled(seed), testing::UnorderedElementsAre("tench", "wolf", "dog", "stove"));
  }
  EXPECT_GT(others, 5);
}

TEST(LabelOrder, RefusesUnknownOnes) {
  EXPECT_THAT([] { inLabelOrder(twoImages(), "size"); }, FailsWith(ErrorCode::unknownName));
}

}  // namespace
}  // namespace estancia::experiments
