// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

/// Reads `text` with the one key `key`, whose value goes to `use`.
void readKey(const std::string& text, const std::function<void(ConfigFile&, const toml::node&)>& use) {
  ConfigFile config("/robot/home.toml", text);
  config.read({{"key", true, "a test", [&](const toml::node& node) { use(config, node); }}});
}

TEST(Config, UsesTheListedKeys) {
  std::vector<std::string> seen;
  ConfigFile config("home.toml", "first = 1\nsecond = true\nthird = 'x'\n");
  const auto note = [&](const toml::node&) { seen.push_back(config.key()); };
  config.read({{"first", true, "", note}, {"second", false, "", note}, {"fourth", false, "", note}},
              ConfigFile::Others::skip);
  EXPECT_THAT(seen, testing::UnorderedElementsAre("first", "second"));
}

TEST(Config, RefusesOtherKeysAndMissingOnes) {
  ConfigFile config("home.toml", "first = 1\nsceond = 2\n");
  const std::vector<ConfigFile::Key> keys{{"first", true, "the first", [](const toml::node&) {}},
                                          {"second", false, "the second", [](const toml::node&) {}}};
  EXPECT_THAT([&] { config.read(keys); }, FailsWith(ErrorCode::malformedFile));
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

}  // namespace
}  // namespace estancia
