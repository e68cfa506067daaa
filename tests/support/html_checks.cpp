#include "support/html_checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <vector>

namespace estancia::test {

const std::string hostileText =
    "</script><script>alert(1)</script></title><img src=x onerror='a'>\"'&\xFF]]>--><!--";

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

void expectWellFormed(const std::string& html) {
  const std::string body = html.substr(html.find("<body>"));
  std::vector<std::string> open{"html"};
  for (std::size_t at = body.find('<'); at != std::string::npos; at = body.find('<', at + 1)) {
    const std::size_t end = body.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const std::string tag = body.substr(at + 1, end - at - 1);
    const std::string name = tag.substr(0, tag.find_first_of(" />", 1));
    if (tag[0] == '/') {
      ASSERT_FALSE(open.empty());
      ASSERT_EQ(tag.substr(1), open.back()) << body.substr(at > 200 ? at - 200 : 0, 300);
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(name);
      if (name == "script") at = body.find("</script", at) - 1;
    }
  }
  EXPECT_TRUE(open.empty()) << open.back();
}

void expectNothingFromOutside(const std::string& html) {
  EXPECT_FALSE(std::regex_search(html, std::regex("https?:|//[a-z]+\\.|@import|url\\(|<link|<iframe")));
  const std::regex reference("(src|href|action|data)=\"([^\"]{0,12})");
  for (std::sregex_iterator it(html.begin(), html.end(), reference), end; it != end; ++it) {
    const std::string target = (*it)[2];
    EXPECT_TRUE(target.starts_with("#") || target.starts_with("data:image/")) << target;
  }
  EXPECT_THAT(html, testing::HasSubstr("default-src 'none'"));
}

}  // namespace estancia::test
