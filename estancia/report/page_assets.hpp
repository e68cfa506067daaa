// Page assets: styles and scripts of the pages, compiled in by cmake/EstanciaEmbed.cmake.
#pragma once

#include <string>

namespace estancia::report {

extern const std::string mapPageCss, mapPageScript, tablesCss, zonesPageCss, zonesPageScript;

}  // namespace estancia::report
