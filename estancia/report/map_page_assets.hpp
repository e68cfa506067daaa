// map_page.css and map_page.js, compiled in by cmake/EstanciaPage.cmake.
#pragma once

#include <string>

namespace estancia::report {

extern const std::string mapPageCss;
extern const std::string mapPageScript;

}  // namespace estancia::report
