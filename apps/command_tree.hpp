// Command tree: all commands and options of the program, for shell completion, man pages and the reference.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

namespace estancia::apps {

/// The command, then its subcommands, depth first: "estancia classify train" and the command.
std::vector<std::pair<std::string, const CLI::App*>> commandsOf(const CLI::App& app);

/// A script that completes commands, options and files in bash.
std::string bashCompletion(const CLI::App& app);
/// Completion script for zsh, with the descriptions.
std::string zshCompletion(const CLI::App& app);
/// The man page (roff) of one command; `name` as of commandsOf().
std::string manPage(const std::string& name, const CLI::App& command);
/// All commands with their options, as Markdown.
std::string commandReference(const CLI::App& app);
/// All groups of parameters, as Markdown.
std::string optionReference();

}  // namespace estancia::apps
