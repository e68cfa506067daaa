// Configuration file: TOML with errors that name file and line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estancia/core/options.hpp"

namespace estancia {

/// Reads one TOML file by a list of its keys. All errors are Error (malformedFile) `FILE:LINE: what`.
class ConfigFile {
 public:
  struct Key {
    std::string name;
    bool required;
    /// Stands in the message that it is missing.
    std::string meaning;
    std::function<void(const toml::node&)> use;
  };

  /// Throws Error (fileNotFound, fileUnreadable, tooLarge, malformedFile).
  explicit ConfigFile(std::filesystem::path path);

  /// Reads a text in memory; `name` stands for the file in messages.
  ConfigFile(std::filesystem::path name, std::string_view text);

  const std::filesystem::path& path() const { return path_; }
  const toml::table& table() const { return table_; }

  /// Treatment by read() of keys that are not in its list.
  enum class Others { refuse, skip };

  /// Uses the listed keys of `table`; throws Error on others, and on missing ones.
  void read(const toml::table& table, const std::vector<Key>& keys, Others others = Others::refuse);
  void read(const std::vector<Key>& keys, Others others = Others::refuse) { read(table_, keys, others); }

  /// Uses the keys of `table` as values of declared options; tables inside are their groups. Throws Error on
  /// other keys and on values that are not accepted.
  void read(const toml::table& table, OptionGroup& options);
  /// The keys of declared options, for tables that hold others, too.
  std::vector<Key> keysOf(OptionGroup& options);

  [[noreturn]] void fail(const toml::node& at, const std::string& what) const;

  // Checks of a key's value; the key being read is named in the message.
  std::string text(const toml::node& node) const;
  bool flag(const toml::node& node) const;
  double number(const toml::node& node, double min, double max) const;
  std::int64_t integer(const toml::node& node, std::int64_t min, std::int64_t max) const;
  /// A relative path that stays inside the file's own folder.
  std::filesystem::path inside(const toml::node& node) const;
  std::filesystem::path inside(const toml::node& node, const std::filesystem::path& path) const;
  /// Any file or folder: `~` and `${VARIABLE}` are expanded; a relative path starts in the file's own folder.
  /// ESTANCIA_HOME and ESTANCIA_DATA have defaults where they are not set.
  std::filesystem::path anywhere(const toml::node& node) const;
  const toml::array& list(const toml::node& node) const;
  const toml::table& subtable(const toml::node& node) const;

  template <class Value>
  Value choice(const toml::node& node, const std::vector<std::pair<std::string, Value>>& choices) const {
    const std::string chosen = text(node);
    std::string known;
    for (const auto& [name, value] : choices) {
      if (name == chosen) return value;
      known += (known.empty() ? "\"" : ", \"") + name + "\"";
    }
    fail(node, "`" + key_ + "` must be one of " + known + ", not \"" + chosen + "\"");
  }

  /// The key being read, for messages about its parts.
  const std::string& key() const { return key_; }

 private:
  void parse(std::string_view text);

  std::filesystem::path path_;
  toml::table table_;
  std::string key_;
};

}  // namespace estancia
