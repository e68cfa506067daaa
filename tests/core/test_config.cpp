// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/home.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/removed_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

#include "estancia/core/printable.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

/// Reads `text` with the one key `key`, whose value goes to `use`.
void readKey(const std::string& text, const std::function<void(ConfigFile&, const toml::node&)>& use) {
  ConfigFile config("/robot/home.toml", text);
  config.read({{"key", true, "a test", [&](const toml::node& node) { use(config, node); }}});
}

TEST(Config, UsesTheListedKeysAndRefusesOtherAndMissingOnes) {
  std::vector<std::string> seen;
  ConfigFile config("home.toml", "first = 1\nsecond = true\nthird = 'x'\n");
  const auto note = [&](const toml::node&) { seen.push_back(config.key()); };
  config.read({{"first", true, "", note}, {"second", false, "", note}, {"fourth", false, "", note}},
              ConfigFile::Others::skip);
  EXPECT_THAT(seen, testing::UnorderedElementsAre("first", "second"));
  ConfigFile wrong("home.toml", "first = 1\nsceond = 2\n");
  const std::vector<ConfigFile::Key> keys{{"first", true, "the first", [](const toml::node&) {}},
                                          {"second", false, "the second", [](const toml::node&) {}}};
  EXPECT_THAT([&] { wrong.read(keys); }, FailsWith(ErrorCode::malformedFile));
  ConfigFile empty("home.toml", "");
  EXPECT_THAT([&] { empty.read(keys); }, FailsWith(ErrorCode::malformedFile));
}

TEST(Config, RefusesWhatIsNoToml) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "a.toml", "good = 1\nbad\n");
  EXPECT_THAT([&] { ConfigFile(folder / "a.toml"); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { ConfigFile(folder / "none.toml"); }, FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT([&] { ConfigFile(folder.path()); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST(Config, KeysOfManyPartsAreRefused) {
  std::string deep = "a";
  for (int i = 0; i < 100000; ++i) deep += i % 3 == 0 ? " . 'b.c'" : R"(."\".".d)";
  for (const std::string& text : {deep + " = 1", "[" + deep + "]", "a = {b = 1, " + deep + " = 1}",
                                  "a = \"\"\"\n\\\"\"\"\" # \"\n" + deep + " = 1"})
    EXPECT_THAT([&] { ConfigFile("a.toml", text); }, FailsWith(ErrorCode::malformedFile));
  const std::string dots(40, '.');
  for (const std::string& text : {std::string("a.b.c.d.e.f.g.h = 1"), "a = '" + dots + "'", "# " + dots})
    EXPECT_NO_THROW(ConfigFile("a.toml", text)) << text;
}

TEST(Config, ValuesHaveTypesAndRanges) {
  const auto refused = [](const std::string& value,
                          const std::function<void(ConfigFile&, const toml::node&)>& use) {
    EXPECT_THAT([&] { readKey("\nkey = " + value, use); }, FailsWith(ErrorCode::malformedFile)) << value;
  };
  const auto number = [](ConfigFile& c, const toml::node& node) { c.number(node, 0, 1); };
  const auto integer = [](ConfigFile& c, const toml::node& node) { c.integer(node, 1, 9); };
  for (const char* value : {"1.5", "-0.1", "nan", "inf", "true", "'x'"}) refused(value, number);
  for (const char* value : {"0", "10", "1.0", "'1'"}) refused(value, integer);
  refused("1", [](ConfigFile& c, const toml::node& node) { c.text(node); });
  refused("1", [](ConfigFile& c, const toml::node& node) { c.flag(node); });
  refused("1", [](ConfigFile& c, const toml::node& node) { c.list(node); });
  refused("[1]", [](ConfigFile& c, const toml::node& node) { c.subtable(node); });
  refused("'red'", [](ConfigFile& c, const toml::node& node) {
    c.choice<int>(node, {{"green", 1}, {"blue", 2}});
  });
  readKey("key = 1", [](ConfigFile& c, const toml::node& node) {
    EXPECT_EQ(c.number(node, 0, 1), 1);
    EXPECT_EQ(c.integer(node, 1, 9), 1);
  });
  readKey("key = 'blue'", [](ConfigFile& c, const toml::node& node) {
    EXPECT_EQ(c.choice<int>(node, {{"green", 1}, {"blue", 2}}), 2);
  });
}

TEST(Config, PathsInsideStayInside) {
  const auto inside = [](ConfigFile& c, const toml::node& node) { c.inside(node); };
  for (const char* path : {"''", "'/etc/passwd'", "'../x'", "'a/../../x'"})
    EXPECT_THAT([&] { readKey(std::string("key = ") + path, inside); }, FailsWith(ErrorCode::malformedFile))
        << path;
  readKey("key = 'a/b.onnx'",
          [](ConfigFile& c, const toml::node& node) { EXPECT_EQ(c.inside(node), "a/b.onnx"); });
}

TEST(Config, PathsAnywhereAreExpanded) {
  ASSERT_EQ(setenv("ESTANCIA_TEST_FOLDER", "/data", 1), 0);
  const auto expanded = [](const std::string& path) {
    std::string result;
    readKey("key = '" + path + "'",
            [&](ConfigFile& c, const toml::node& node) { result = c.anywhere(node).string(); });
    return result;
  };
  EXPECT_EQ(expanded("a/./b"), "/robot/a/b");
  EXPECT_EQ(expanded("/a"), "/a");
  EXPECT_EQ(expanded("${ESTANCIA_TEST_FOLDER}/x"), "/data/x");
  EXPECT_EQ(expanded("~/x"), std::string(std::getenv("HOME")) + "/x");
  for (const char* path : {"", "${ESTANCIA_TEST_FOLDER", "${ESTANCIA_TEST_NONE}"})
    EXPECT_THAT([&] { expanded(path); }, FailsWith(ErrorCode::malformedFile)) << path;
}

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
  for (const auto& [path, value] : {std::pair{"method", "exact"},
                                    {"count", "7"},
                                    {"loud", "true"},
                                    {"rate", "0.5"},
                                    {"side", "right"},
                                    {"inner.ball_radius", "0.125"},
                                    {"inner.limit", "1"}})
    group.set(path, value);
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
    EXPECT_THAT([&] { group.set("count", bad); }, FailsWith(ErrorCode::invalidOption)) << bad;
  for (const char* bad : {"0", "-1", "nan", "inf"})
    EXPECT_THAT([&] { group.set("inner.ball-radius", bad); }, FailsWith(ErrorCode::invalidOption)) << bad;
  EXPECT_THAT([&] { group.set("loud", "yes"); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { group.set("method", "slow"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { group.set("side", "up"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { group.set("inner.size", "1"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_EQ(outer.count, 3);
  EXPECT_EQ(outer.inner.radius, 0.5);
}

TEST(Options, AreValidatedWithAllTheirParts) {
  Outer outer;
  validate(outer);
  outer.inner.radius = 0;
  EXPECT_THAT([&] { validate(outer); }, FailsWith(ErrorCode::invalidOption));
  outer = {};
  outer.method = "none";
  EXPECT_THAT([&] { validate(outer); }, FailsWith(ErrorCode::unknownName));
  outer = {};
  outer.inner.limit = 2;
  EXPECT_THAT([&] { validate(outer); }, FailsWith(ErrorCode::invalidOption));
}

TEST(Options, AreReadFromTomlOrRefusedWithFileAndLine) {
  Outer outer;
  ConfigFile config("robot.toml", "method = \"exact\"\ncount = 9\nrate = 1\n[inner]\nball_radius = 2.5\n");
  OptionGroup group = declare(outer);
  config.read(config.table(), group);
  EXPECT_EQ(outer.method, "exact");
  EXPECT_EQ(outer.count, 9);
  EXPECT_EQ(outer.rate, 1);
  EXPECT_EQ(outer.inner.radius, 2.5);
  const auto read = [](const char* text) {
    return [text] {
      Outer outer;
      ConfigFile config("robot.toml", text);
      OptionGroup group = declare(outer);
      config.read(config.table(), group);
    };
  };
  EXPECT_THAT(read("loud = true\ncount = 0\n"), FailsWith(ErrorCode::malformedFile, "robot.toml:2", "count"));
  for (const std::string line : {"count = 2.5", "count = true", "count = '2'", "rate = 'x'", "method = 1",
                                 "method = true", "loud = 1", "loud = 'true'", "loud = 1.5", "count = [2]"})
    EXPECT_THAT(read(line.c_str()), FailsWith(ErrorCode::malformedFile, "robot.toml:1")) << line;
  EXPECT_THAT(read("\ncuont = 2\n"), FailsWith(ErrorCode::malformedFile, "robot.toml:2", "cuont"));
  EXPECT_THAT(read("[inner]\nball_radius = 0\n"), FailsWith(ErrorCode::malformedFile, "robot.toml:2"));
  EXPECT_THAT(read("method = \"slow\"\n"), FailsWith(ErrorCode::malformedFile, "robot.toml:1", "exact"));
}

TEST(ErrorCodes, HaveNamesThatLeadBack) {
  for (int i = 0; i <= static_cast<int>(ErrorCode::invalidState); ++i) {
    const auto code = static_cast<ErrorCode>(i);
    EXPECT_EQ(findErrorCode(nameOf(code)), code);
  }
  EXPECT_EQ(nameOf(ErrorCode::invalidState), "invalid-state");
  EXPECT_EQ(findErrorCode("no-such-code"), std::nullopt);
}

TEST(ErrorMessage, ShowsControlCharactersAsTheirBytesAndLeavesOutTheMiddleOfWhatIsTooLong) {
  const Error error(ErrorCode::malformedFile, "a.toml:1: \"\x1b[31m\" and \u202E and \xff\n");
  EXPECT_STREQ(error.what(), "a.toml:1: \"\\x1B[31m\" and \\xE2\\x80\\xAE and \\xFF\\x0A");
  EXPECT_EQ(error.code(), ErrorCode::malformedFile);
  std::string quoted;
  for (int i = 0; i < 20'000; ++i) quoted += "é";
  const std::string text =
      Error(ErrorCode::malformedFile, "a.pcd: \"" + quoted + "\"; write it again").what();
  EXPECT_LE(text.size(), 2000U);
  EXPECT_THAT(text, testing::StartsWith("a.pcd: \"éé"));
  EXPECT_THAT(text, testing::HasSubstr("é … é"));
  EXPECT_THAT(text, testing::EndsWith("é\"; write it again"));
  EXPECT_EQ(printable(text), text) << "no letter is cut";
}

TEST(Choices, AreNamedWithoutTheOneThatIsFoundByItself) {
  const Choices metrics{{"euclidean", ""}, {"cosine", ""}, {"", "the better one"}};
  EXPECT_EQ(namesOf(metrics), "euclidean, cosine");
  EXPECT_NO_THROW(requireChoice("metric", "", metrics));
}

/// The environment as it was, afterwards.
class CacheFolder : public testing::Test {
 protected:
  CacheFolder() {
    for (const char* variable : {"ESTANCIA_CACHE", "XDG_CACHE_HOME", "HOME"}) {
      before_[variable] = environment(variable);
      unsetenv(variable);
    }
  }
  ~CacheFolder() override {
    for (const auto& [variable, value] : before_)
      value.empty() ? unsetenv(variable.c_str()) : setenv(variable.c_str(), value.c_str(), 1);
  }

 private:
  std::map<std::string, std::string> before_;
};

TEST_F(CacheFolder, IsTheUsersUnlessNamed) {
  setenv("HOME", "ana", 1);
  EXPECT_EQ(cacheFolder(), "ana/.cache/estancia");
  EXPECT_EQ(cacheFolder("labels"), "ana/.cache/estancia/labels");
  setenv("XDG_CACHE_HOME", "caches", 1);
  EXPECT_EQ(cacheFolder("labels"), "caches/estancia/labels");
  EXPECT_EQ(cacheFolder(), "caches/estancia");
  setenv("ESTANCIA_CACHE", "own", 1);
  EXPECT_EQ(cacheFolder("labels"), "own") << "the folder itself";
}

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
