// Laboratory: the program estancia-lab, which runs experiments where it is installed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace estancia::apps {

/// Replaces this process by estancia-lab with these arguments (a null at their end), as git does with its
/// subcommands: streams, signals and exit code are those of the laboratory. It is looked for in the folder of
/// this program, in ../libexec/estancia from there, and on PATH. Returns where there is none.
void becomeLaboratory(char** arguments);

}  // namespace estancia::apps
