// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/config.hpp"
#include "estancia/core/removed_options.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

enum class Side { left, right };

struct Inner {
  double radius = 0.5;
  std::optional<double> limit;
};

struct Outer {
  std::string method = "fast";
  std::size_t count = 3;
  bool loud = false;
  float rate = 0.25F;
  Side side = Side::left;
  Inner inner;
};

OptionGroup declare(Inner& options) {
  OptionGroup group("inner", "A part.");
  group.add("ball-radius", &options.radius, "Radius of the ball.").above(0).unit("m");
  group.add("limit", &options.limit, "Largest value.").range(0, 1).automatic("follows the data");
  return group;
}

OptionGroup declare(Outer& options) {
  OptionGroup group("outer", "The whole.");
  group.add("method", &options.method, "How.").choices({{"fast", "quick"}, {"exact", "slow"}});
  group.add("count", &options.count, "How many.").range(1, 100);
  group.add("loud", &options.loud, "Say more.");
  group.add("rate", &options.rate, "How much.").range(0, 1);
  group.add("side", options.side, {{{"left", ""}, Side::left}, {{"right", ""}, Side::right}}, "Where.");
  group.add(declare(options.inner));
  return group;
}

TEST(Options, AreSetByTheirPath) {
  Outer outer;
  OptionGroup group = declare(outer);
  group.set("method", "exact");
  group.set("count", "7");
  group.set("loud", "true");
  group.set("rate", "0.5");
  group.set("side", "right");
  group.set("inner.ball_radius", "0.125");
  group.set("inner.limit", "1");
  EXPECT_EQ(outer.inner.limit, 1);
  group.set("inner.limit", "auto");
  EXPECT_FALSE(outer.inner.limit);
  group.set("inner.limit", "1");
  EXPECT_EQ(outer.method, "exact");
  EXPECT_EQ(outer.count, 7);
  EXPECT_TRUE(outer.loud);
  EXPECT_EQ(outer.rate, 0.5F);
  EXPECT_EQ(outer.side, Side::right);
  EXPECT_EQ(outer.inner.radius, 0.125);
  EXPECT_EQ(outer.inner.limit, 1);
  EXPECT_EQ(group.find("inner.ball-radius")->text(), "0.125");
  EXPECT_EQ(group.find("side")->text(), "right");
}

TEST(Options, RefuseWhatIsOutOfRangeAndStayAsTheyWere) {
  Outer outer;
  OptionGroup group = declare(outer);
  for (const char* bad : {"0", "101", "-1", "2.5", "", "seven", "99999999999999999999999"})
    EXPECT_THAT([&] { group.set("count", bad); }, FailsWith(ErrorCode::invalidOption, "outer.count")) << bad;
  for (const char* bad : {"0", "-1", "nan", "inf"})
    EXPECT_THAT([&] { group.set("inner.ball-radius", bad); },
                FailsWith(ErrorCode::invalidOption, "outer.inner.ball-radius"))
        << bad;
  EXPECT_THAT([&] { group.set("loud", "yes"); }, FailsWith(ErrorCode::invalidOption, "yes"));
  EXPECT_THAT([&] { group.set("method", "slow"); },
              FailsWith(ErrorCode::unknownName, "slow", "fast", "exact"));
  EXPECT_THAT([&] { group.set("side", "up"); }, FailsWith(ErrorCode::unknownName, "up"));
  EXPECT_THAT([&] { group.set("inner.size", "1"); }, FailsWith(ErrorCode::unknownName, "inner.size"));
  EXPECT_EQ(outer.count, 3);
  EXPECT_EQ(outer.inner.radius, 0.5);
}

TEST(Options, AreValidatedWithAllTheirParts) {
  Outer outer;
  validate(outer);
  outer.inner.radius = 0;
  EXPECT_THAT([&] { validate(outer); }, FailsWith(ErrorCode::invalidOption, "outer.inner.ball-radius", "0"));
  outer = {};
  outer.method = "none";
  EXPECT_THAT([&] { validate(outer); }, FailsWith(ErrorCode::unknownName, "none", "outer.method"));
  outer = {};
  outer.inner.limit = 2;
  EXPECT_THAT([&] { validate(outer); }, FailsWith(ErrorCode::invalidOption, "outer.inner.limit"));
}

TEST(Options, AreReadFromToml) {
  Outer outer;
  ConfigFile config("robot.toml", "method = \"exact\"\ncount = 9\nrate = 1\n[inner]\nball_radius = 2.5\n");
  OptionGroup group = declare(outer);
  config.read(config.table(), group);
  EXPECT_EQ(outer.method, "exact");
  EXPECT_EQ(outer.count, 9);
  EXPECT_EQ(outer.rate, 1);
  EXPECT_EQ(outer.inner.radius, 2.5);
}

TEST(Options, OfTomlAreRefusedWithFileAndLine) {
  const auto read = [](const char* text) {
    return [text] {
      Outer outer;
      ConfigFile config("robot.toml", text);
      OptionGroup group = declare(outer);
      config.read(config.table(), group);
    };
  };
  EXPECT_THAT(read("loud = true\ncount = 0\n"), FailsWith(ErrorCode::malformedFile, "robot.toml:2", "count"));
  EXPECT_THAT(read("count = 2.5\n"), FailsWith(ErrorCode::malformedFile, "robot.toml:1", "count"));
  EXPECT_THAT(read("\ncuont = 2\n"), FailsWith(ErrorCode::malformedFile, "robot.toml:2", "cuont"));
  EXPECT_THAT(read("[inner]\nball_radius = 0\n"), FailsWith(ErrorCode::malformedFile, "robot.toml:2"));
  EXPECT_THAT(read("method = \"slow\"\n"), FailsWith(ErrorCode::malformedFile, "robot.toml:1", "exact"));
}

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
  EXPECT_THAT([&] { group.set("max_gap", "2"); },
              FailsWith(ErrorCode::unknownName, "odometry.max-gap has gone", "always 1"));
  OptionGroup world("world", "");
  world.add(declare(options));
  EXPECT_THAT([&] { world.set("odometry.max-gap", "2"); },
              FailsWith(ErrorCode::unknownName, "world.odometry.max-gap has gone"));
  EXPECT_THAT([&] { world.set("odometry.max-gaps", "2"); }, FailsWith(ErrorCode::unknownName, "unknown"));
  ConfigFile config("p.toml", "[odometry]\nmax_gap = 2\n");
  EXPECT_THAT([&] { config.read(config.subtable(*config.table().get("odometry")), group); },
              FailsWith(ErrorCode::malformedFile, "p.toml:2", "has gone"));
  EXPECT_EQ(findRemovedOption("odometry.max-depth"), nullptr);
}

TEST(Options, SayWhatTheyAccept) {
  Outer outer;
  OptionGroup group = declare(outer);
  EXPECT_EQ(group.find("count")->accepted(), "a whole number from 1 to 100");
  EXPECT_EQ(group.find("inner.ball-radius")->accepted(), "a number above 0 m");
  EXPECT_EQ(group.find("method")->accepted(), "one of fast, exact");
}

TEST(ErrorCodes, HaveNamesThatLeadBack) {
  for (int i = 0; i <= static_cast<int>(ErrorCode::invalidState); ++i) {
    const auto code = static_cast<ErrorCode>(i);
    EXPECT_EQ(findErrorCode(nameOf(code)), code);
  }
  EXPECT_EQ(nameOf(ErrorCode::invalidState), "invalid-state");
  EXPECT_EQ(findErrorCode("no-such-code"), std::nullopt);
}

}  // namespace
}  // namespace estancia
