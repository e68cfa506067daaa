// The pages' styles and scripts, compiled in by cmake/EstanciaPage.cmake.
#pragma once

#include <string>

namespace estancia::report {

extern const std::string mapPageCss, mapPageScript, findingsPageCss, zonesPageCss, zonesPageScript;

}  // namespace estancia::report
