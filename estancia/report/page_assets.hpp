// Page assets: styles and scripts of the pages, compiled in by cmake/EstanciaEmbed.cmake.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace estancia::report {

extern const std::string mapPageCss, mapPageScript, tablesCss, wordSearchScript, worldPageCss,
    worldPageScript, zonesPageCss, zonesPageScript;

}  // namespace estancia::report
