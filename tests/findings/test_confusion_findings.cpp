// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/confusion_findings.hpp"

#include <gtest/gtest.h>

#include "support/errors.hpp"
#include "support/golden_findings.hpp"

namespace estancia {
namespace {

TEST(ConfusionFindings, AreAWholeFile) {
  const Confusion confusion =
      confusionOf({"hall", "hall", "lab", "lab", "lab"}, {"hall", "lab", "lab", "lab", "attic"});
  EXPECT_EQ(rightOf(confusion), 3U);
  test::expectGolden("confusion", findingsOf(confusion, "rooms", {{"Sequence", "tour"}}));
  EXPECT_THAT([] { findingsOf(confusionOf({}, {}), "rooms", {}); }, test::FailsWith(ErrorCode::mismatch));
}

}  // namespace
}  // namespace estancia
