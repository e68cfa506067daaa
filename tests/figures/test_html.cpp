// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>

#include "estancia/core/error.hpp"
#include "estancia/figures/color.hpp"
#include "estancia/figures/html.hpp"

namespace estancia::report {
namespace {

TEST(Text, BrokenUtf8BecomesReplacementCharacters) {
  EXPECT_EQ(cleanText("caf\xC3\xA9"), "café");
  EXPECT_EQ(cleanText("a\xFF"
                      "b"),
            "a\uFFFDb");
  EXPECT_EQ(cleanText("cut \xE2\x82"), "cut \uFFFD\uFFFD");
  EXPECT_EQ(cleanText("\xC0\xAF"), "\uFFFD\uFFFD") << "an overlong slash";
  EXPECT_EQ(cleanText("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD") << "a surrogate";
}

TEST(Text, ControlCharactersAndLineBreaksBecomeBlanks) {
  EXPECT_EQ(cleanText(std::string("a\0b\nc\x1B", 6)), "a b c ");
  EXPECT_EQ(cleanText("a\u2028b"), "a b");
}

TEST(Text, IsShortenedToAWidthInAnyScript) {
  EXPECT_EQ(shortenToWidth("corridor", 10), "corridor");
  for (const std::string text : {"a corridor with a view", "日本語の名前の廊下"}) {
    const std::string cut = shortenToWidth(text, 5);
    EXPECT_LE(textWidth(cut), 5) << cut;
    EXPECT_GT(textWidth(cut), 3) << cut;
    EXPECT_TRUE(cut.ends_with("…"));
  }
  EXPECT_EQ(shortenToWidth("corridor", 0), "…");
}

TEST(Text, NumbersHaveNoTrailingZeros) {
  EXPECT_EQ(number(1.5), "1.5");
  EXPECT_EQ(number(-0.001), "0");
  EXPECT_EQ(number(100), "100");
  EXPECT_EQ(significant(0.0123), "0.0123");
  EXPECT_EQ(significant(123.4), "123");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1234567), "1,234,567");
  EXPECT_EQ(significant(0.0 / 0.0), "n/a");
}

TEST(Html, EscapesEverythingThatCouldEndATextOrAnAttribute) {
  EXPECT_EQ(escapeHtml("<a href=\"x\" id='y'>&"), "&lt;a href=&quot;x&quot; id=&#39;y&#39;&gt;&amp;");
  Markup markup;
  markup.element("p", {{"title", "\"><script>"}}, "</p><script>");
  EXPECT_EQ(markup.str(), "<p title=\"&quot;&gt;&lt;script&gt;\">&lt;/p&gt;&lt;script&gt;</p>");
}

TEST(Html, JsonCannotCloseItsScript) {
  EXPECT_EQ(jsonForScript("[\"</script><!--\"]"), "[\"\\u003c/script>\\u003c!--\"]");
  EXPECT_EQ(jsonForScript("\"a\u2028b\u2029\""), "\"a\\u2028b\\u2029\"");
}

TEST(Html, ImagesAreEmbeddedByTheirBytesAndOthersRefused) {
  EXPECT_EQ(imageUri({0xFF, 0xD8, 0xFF, 0xE0}, "x"), "data:image/jpeg;base64,/9j/4A==");
  const std::string svg = "<svg onload='x'/>";
  EXPECT_THROW(imageUri({svg.begin(), svg.end()}, "plan.svg"), Error);
  EXPECT_THROW(imageUri({}, "empty.jpg"), Error);
}

TEST(Color, ViridisRunsFromPurpleToYellowAndStaysInside) {
  EXPECT_EQ(viridis(0).hex(), "#440154");
  EXPECT_EQ(viridis(1).hex(), "#fde725");
  EXPECT_EQ(viridis(-3).hex(), viridis(0).hex());
  EXPECT_EQ(viridis(7).hex(), viridis(1).hex());
  EXPECT_EQ(viridis(0.0 / 0.0).hex(), viridis(0).hex());
  EXPECT_EQ(viridis(0).ink(), "#fff");
  EXPECT_EQ(viridis(1).ink(), "#000");
}

TEST(Color, ManyClassesLookDifferent) {
  for (const auto style : {classStyle, symbolStyle}) {
    std::set<std::pair<std::string, std::size_t>> seen;
    for (std::size_t i = 0; i < distinctClasses; ++i) seen.emplace(style(i).fill.hex(), style(i).shape);
    EXPECT_EQ(seen.size(), distinctClasses);
  }
}

}  // namespace
}  // namespace estancia::report
