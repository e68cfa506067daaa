// SPDX-License-Identifier: Apache-2.0
#include "support/html_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <regex>
#include <utility>
#include <vector>

namespace estancia::test {

const std::string hostileText =
    "</script><script>alert(1)</script></title><img src=x onerror='a'>\"'&\xFF]]>--><!--";

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

namespace {

std::string withoutEntities(std::string text) {
  for (const auto& [entity, sign] :
       {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&#39;", "'"}, {"&amp;", "&"}})
    for (std::size_t at = 0; (at = text.find(entity, at)) != std::string::npos; ++at)
      text.replace(at, std::string(entity).size(), sign);
  return text;
}

std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

Html::Html(const std::string& html) {
  std::vector<std::size_t> open;  // positions in elements_
  std::size_t at = 0;
  while (at < html.size()) {
    if (html[at] != '<') {
      const std::size_t end = std::min(html.find('<', at), html.size());
      const std::string text = withoutEntities(html.substr(at, end - at));
      for (const std::size_t element : open) elements_[element].text += text;
      at = end;
      continue;
    }
    const std::size_t end = std::min(html.find('>', at), html.size());
    const std::string tag = html.substr(at + 1, end - at - 1);
    at = end + 1;
    if (tag.starts_with("!") || tag.starts_with("?")) continue;
    if (tag.starts_with("/")) {
      if (!open.empty()) open.pop_back();
      continue;
    }
    HtmlElement element{tag.substr(0, tag.find_first_of(" />")), {}, ""};
    // By hand: std::regex takes a stack frame a character, and a value may hold an image.
    for (std::size_t equals = 0; (equals = tag.find("=\"", equals)) != std::string::npos;) {
      const std::size_t name = tag.find_last_of(" \n", equals) + 1, quote = tag.find('"', equals + 2);
      element.attributes[tag.substr(name, equals - name)] =
          withoutEntities(tag.substr(equals + 2, quote - equals - 2));
      equals = quote;
    }
    elements_.push_back(element);
    const bool isVoid = tag.ends_with("/") || element.name == "meta" || element.name == "img";
    if (!isVoid) open.push_back(elements_.size() - 1);
    if (element.name == "script" || element.name == "style") {
      const std::size_t close = std::min(html.find("</" + element.name, at), html.size());
      elements_.back().text = html.substr(at, close - at);
      at = close;
    }
  }
}

std::vector<HtmlElement> Html::all(const std::string& selector) const {
  const std::size_t mark = selector.find_first_of(".#");
  const std::string name = selector.substr(0, mark);
  const std::string rest = mark == std::string::npos ? "" : selector.substr(mark + 1);
  std::vector<HtmlElement> found;
  for (const HtmlElement& element : elements_) {
    if (!name.empty() && name != "*" && element.name != name) continue;
    if (!rest.empty()) {
      const auto value = element.attributes.find(selector[mark] == '#' ? "id" : "class");
      if (value == element.attributes.end()) continue;
      if (selector[mark] == '#' ? value->second != rest
                                : (" " + value->second + " ").find(" " + rest + " ") == std::string::npos)
        continue;
    }
    found.push_back(element);
  }
  return found;
}

std::vector<std::string> Html::texts(const std::string& selector) const {
  std::vector<std::string> texts;
  for (const HtmlElement& element : all(selector)) texts.push_back(element.text);
  return texts;
}

std::vector<std::string> Html::values(const std::string& selector, const std::string& attribute) const {
  std::vector<std::string> values;
  for (const HtmlElement& element : all(selector)) {
    const auto value = element.attributes.find(attribute);
    values.push_back(value == element.attributes.end() ? "" : value->second);
  }
  return values;
}

bool Html::mentions(const std::string& part) const {
  const std::string wanted = lowerCase(part);
  for (const HtmlElement& element : elements_) {
    if (element.name == "script" || element.name == "style") continue;
    if (lowerCase(element.text).find(wanted) != std::string::npos) return true;
    for (const auto& [name, value] : element.attributes)
      if (lowerCase(value).find(wanted) != std::string::npos) return true;
  }
  return false;
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
  const auto policies = Html(html).values("meta", "content");
  EXPECT_TRUE(std::ranges::any_of(policies, [](auto& p) { return p.starts_with("default-src 'none'"); }));
}

}  // namespace estancia::test
