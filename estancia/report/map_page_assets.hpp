// map_page.css, map_page.js and findings_page.css, compiled in by cmake/EstanciaPage.cmake.
#pragma once

#include <string>

namespace estancia::report {

extern const std::string mapPageCss;
extern const std::string mapPageScript;
extern const std::string findingsPageCss;

}  // namespace estancia::report
