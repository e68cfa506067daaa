// Command line: what all programs of the command do around their arguments: streams, log, errors and exit
// codes. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace estancia::apps {

/// Exit codes: all went well; the question has no answer (nothing found, no way); something is wrong.
enum ExitCode { success = 0, noAnswer = 1, failure = 2 };

/// Thrown by a subcommand to end with `noAnswer` after it has printed the reason on stdout.
struct NoAnswer {};

/// Type name of an option whose value may be "", which means something there.
inline constexpr const char* textOrNothing = "TEXT|\"\"";

/// Whether an option is followed by a value; flags are not.
bool takesValue(const CLI::Option& option);

/// Ends the help of a command with examples, one a line.
void addExamples(CLI::App& command, const std::string& examples);

/// Adds `--json`.
void addJsonOption(CLI::App& command, bool& json);

/// One line of JSON on stdout.
void print(const nlohmann::ordered_json& json);

/// To be called first in main(): closed standard files are occupied, libraries are silent, the log goes to
/// stderr, Ctrl-C is caught.
void prepareProgram();

/// Runs a program whose commands were added to `app`, and returns its exit code. An error is one line on
/// stderr with its code in brackets, and with --json an object on stdout, too.
int runProgram(CLI::App& app, int argc, char** argv);

}  // namespace estancia::apps
