// What every page must be.
#pragma once

#include <cstddef>
#include <string>

namespace estancia::test {

/// How often `part` occurs.
std::size_t count(const std::string& text, const std::string& part);

/// The elements of the body are properly nested: nothing that came from outside has opened or closed one.
void expectWellFormed(const std::string& html);

/// No address, import or frame that a browser would follow; every reference is inside the page.
void expectNothingFromOutside(const std::string& html);

/// Text that would break out of a page that does not escape it.
extern const std::string hostileText;

}  // namespace estancia::test
