// Declared options on the command line: flags, --set GROUP.NAME=VALUE, --config FILE and --preset, from one
// declaration.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estancia/core/options.hpp"

namespace estancia::apps {

/// Treatment of groups in --config that no command of the program has declared.
enum class OtherGroups { refuse, skip };

/// The options structs of one command. What a user gives is applied, and everything validated, once the
/// command line has been read, in this order: --preset, --config, --set, flags.
class DeclaredOptions {
 public:
  /// Adds --config and --set to `command`. Keep it alive as long as the command.
  explicit DeclaredOptions(CLI::App& command, OtherGroups others = OtherGroups::refuse);
  DeclaredOptions(const DeclaredOptions&) = delete;
  DeclaredOptions& operator=(const DeclaredOptions&) = delete;

  CLI::App& command() const { return command_; }

  /// Every option of `group` can be set; those in `flags`, given by their path below the group, by a flag of
  /// the command, too: "scene-filter.method" as --method, or "scene-filter.method=filter" as --filter, or
  /// "count=-n,--count". What is on by default gets a flag that switches it off: "loops" as --no-loops, or
  /// "bidirectional=one-way" as --one-way. All options named "threads" share the flag --threads.
  void add(OptionGroup group, std::initializer_list<std::string_view> flags = {});
  /// More flags for a group that was added.
  void addFlags(std::string_view group, std::initializer_list<std::string_view> flags);

  /// Adds --preset; `apply` is called with its name before anything else is set.
  void addPreset(Choices presets, std::function<void(const std::string&)> apply);
  /// The name given by --preset, or "".
  const std::string& preset() const { return preset_; }

  /// Sets in `group`, another instance of a struct that was added, what --config, --set and flags gave.
  void applyTo(OptionGroup group) const;

 private:
  struct Flag {
    std::string name, group, path;
  };
  using Targets = std::vector<OptionGroup*>;

  OptionGroup* find(std::string_view name) const;
  void addFlag(OptionGroup& group, std::string_view path, std::string flag);
  void addThreads(const OptionGroup& group);
  void parsed();
  void apply(const Targets& targets) const;
  void applyConfig(const Targets& targets) const;
  void applySetting(const std::string& setting, const Targets& targets) const;

  CLI::App& command_;
  OtherGroups others_;
  std::vector<std::unique_ptr<OptionGroup>> groups_;
  std::string config_, preset_, threads_;
  Choices presets_;
  std::function<void(const std::string&)> applyPreset_;
  std::vector<std::string> settings_;
  std::vector<std::pair<Flag, std::string>> given_;  // with its text
};

/// A group as some commands declare it, with its defaults.
struct PublishedGroup {
  OptionGroup group;
  std::vector<std::string> commands;
  std::map<std::string, std::set<std::string>> flags;  // flags of an option, by its path below the group

  /// Flags of one option over all commands; may be empty.
  std::set<std::string> flagsOf(const std::string& path) const {
    const auto found = flags.find(path);
    return found == flags.end() ? std::set<std::string>() : found->second;
  }
};
/// All groups of the program, sorted by name, as they were declared so far.
const std::vector<PublishedGroup>& publishedGroups();

}  // namespace estancia::apps
