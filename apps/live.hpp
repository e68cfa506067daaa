// Live command: estancia live, for a robot that drives.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace estancia::apps {

void addLiveCommand(CLI::App& app);

}  // namespace estancia::apps
