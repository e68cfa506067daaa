// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/removed_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/config.hpp"
#include "estancia/core/options.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

/// With options that have gone.
struct Odometry {
  double maxDepth = 8;
};

OptionGroup declare(Odometry& options) {
  OptionGroup group("odometry", "With options that have gone.");
  group.add("max-depth", &options.maxDepth, "Depth beyond is not used.");
  return group;
}

TEST(RemovedOptions, AreNamedWithWhatHoldsInstead) {
  Odometry options;
  OptionGroup group = declare(options);
  EXPECT_THAT([&] { group.set("max_gap", "2"); }, FailsWith(ErrorCode::unknownName));
  OptionGroup world("world", "");
  world.add(declare(options));
  EXPECT_THAT([&] { world.set("odometry.max-gap", "2"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { world.set("odometry.max-gaps", "2"); }, FailsWith(ErrorCode::unknownName));
  ConfigFile config("p.toml", "[odometry]\nmax_gap = 2\n");
  EXPECT_THAT([&] { config.read(config.subtable(*config.table().get("odometry")), group); },
              FailsWith(ErrorCode::malformedFile));
  EXPECT_EQ(findRemovedOption("odometry.max-depth"), nullptr);
}

}  // namespace
}  // namespace estancia
