// Declared options on the command line: flags, --set GROUP.NAME=VALUE and --config FILE, from one
// declaration.
#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estancia/core/options.hpp"

namespace estancia::apps {

/// The options structs of one command. What a user gives is applied, and everything validated, once the
/// command line has been read, in this order: --config, then --set, then the flags.
class DeclaredOptions {
 public:
  /// Adds --config and --set to `command`. Keep it alive as long as the command.
  explicit DeclaredOptions(CLI::App& command);
  DeclaredOptions(const DeclaredOptions&) = delete;
  DeclaredOptions& operator=(const DeclaredOptions&) = delete;

  /// Every option of `group` can be set; those in `flags`, given by their path below the group, by a flag of
  /// the command, too: "scene-filter.method" as --method, or "scene-filter.method=filter" as --filter.
  void add(OptionGroup group, std::initializer_list<std::string_view> flags = {});

 private:
  void addFlag(OptionGroup& group, std::string_view path, const std::string& flag);
  void apply();
  void readConfig();

  CLI::App& command_;
  std::vector<std::unique_ptr<OptionGroup>> groups_;
  std::string config_;
  std::vector<std::string> settings_;
  /// Flag, option, text.
  std::vector<std::unique_ptr<std::pair<std::string, Option*>>> flags_;
  std::vector<std::pair<const std::pair<std::string, Option*>*, std::string>> given_;
};

/// What the help says of an option: sentence, unit or choices, default.
std::string helpOf(const Option& option);

/// A group as some commands declare it, with its defaults.
struct PublishedGroup {
  OptionGroup group;
  std::vector<std::string> commands;
};
/// All groups of the program by name, as they were declared so far.
const std::vector<PublishedGroup>& publishedGroups();

}  // namespace estancia::apps
