// Object commands: the subcommands of `estancia objects`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace estancia::apps {

void addObjectsCollect(CLI::App& objects);
void addObjectsLabel(CLI::App& objects);
void addObjectsTrain(CLI::App& objects);
void addObjectsPredict(CLI::App& objects);
void addObjectsList(CLI::App& objects);
void addObjectsName(CLI::App& objects);
void addObjectsDelete(CLI::App& objects);

}  // namespace estancia::apps
