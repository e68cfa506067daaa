// HTML checks: pages as elements, and what every page must be.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace estancia::test {

/// How often `part` occurs.
std::size_t count(const std::string& text, const std::string& part);

struct HtmlElement {
  std::string name;
  std::map<std::string, std::string> attributes;
  /// Its own and that of the elements in it, with entities replaced.
  std::string text;

  bool operator==(const HtmlElement&) const = default;
};

/// The elements of a page or an SVG, in the order in which they begin.
class Html {
 public:
  explicit Html(const std::string& html);

  /// Elements of a selector: "td", ".best", "td.best", "#rooms" or "*".
  std::vector<HtmlElement> all(const std::string& selector) const;
  std::size_t count(const std::string& selector) const { return all(selector).size(); }
  std::vector<std::string> texts(const std::string& selector) const;
  /// One attribute of each, "" where an element has none.
  std::vector<std::string> values(const std::string& selector, const std::string& attribute) const;
  /// Whether some text or attribute of the page holds `part`, in any case.
  bool mentions(const std::string& part) const;

 private:
  std::vector<HtmlElement> elements_;
};

/// The elements of the body are properly nested: nothing that came from outside has opened or closed one.
void expectWellFormed(const std::string& html);

/// No address, import or frame that a browser would follow; every reference is inside the page.
void expectNothingFromOutside(const std::string& html);

/// Text that would break out of a page that does not escape it.
extern const std::string hostileText;

}  // namespace estancia::test
