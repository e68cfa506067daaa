// Site assets: the page and the description of the API, compiled in by cmake/EstanciaEmbed.cmake.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace estancia {

extern const std::string livePageHtml, livePageCss, livePageScript, livePanelScript, livePlanScript, openApi;

}  // namespace estancia
