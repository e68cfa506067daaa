// A browser (Debian's chromium, by npm's puppeteer-core) that page.mjs leads over a live page.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <future>
#include <string>

#include "estancia/site/page_server.hpp"
#include "support/support.hpp"

namespace estancia::test {

/// Any port that is free, unless one is wanted.
ServerOptions optionsAt(int port = 0);

/// `kind`: "live" or "at rest"; ESTANCIA_SCREENSHOTS names a folder to see what the browser shows.
/// What comes is not valid without a browser.
std::future<CommandResult> browse(const PageServer& server, int width, const std::string& kind);

}  // namespace estancia::test
