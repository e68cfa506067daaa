// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/config.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>

#include "estancia/core/fail.hpp"
#include "estancia/core/home.hpp"
#include "estancia/core/removed_options.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

std::optional<std::string> variable(const std::string& name) {
  if (std::string value = environment(name); !value.empty()) return value;
  if (name == "ESTANCIA_HOME") return userHome() / ".local/share/estancia";
  if (name == "ESTANCIA_DATA") return userHome() / ".cache/estancia/data";
  return std::nullopt;
}

/// A key in the command line's spelling as it is declared.
std::string withUnderscores(std::string_view key) {
  std::string text(key);
  std::ranges::replace(text, '-', '_');
  return text;
}

/// A value of TOML as Option::set() takes it. Throws Error when it is of another type than the option.
std::string tomlText(const toml::node& node, const Option& option) {
  const auto refuse = [&]() -> std::string {
    fail(ErrorCode::malformedFile, "`{}` must be {}", option.key(), option.accepted());
  };
  if (const auto text = node.value_exact<std::string>())
    return (option.isNumber() && *text != "auto") || option.isFlag() ? refuse() : *text;
  if (const auto flag = node.value_exact<bool>())
    return option.isFlag() ? (*flag ? "true" : "false") : refuse();
  if (const auto whole = node.value_exact<std::int64_t>())
    return option.isNumber() ? std::to_string(*whole) : refuse();
  if (const auto number = node.value_exact<double>())
    return option.isNumber() && !option.isInteger() ? fmt::format("{}", *number) : refuse();
  return refuse();
}

/// Behind the string that begins at `begin`; behind its line where it does not end.
std::size_t endOfString(std::string_view text, std::size_t begin) {
  const char quote = text[begin];
  const std::string triple(3, quote);
  const bool isLong = text.substr(begin, 3) == triple;
  for (std::size_t at = begin + (isLong ? 3 : 1); at < text.size(); ++at) {
    if (quote == '"' && text[at] == '\\') {
      ++at;
    } else if (isLong && text.substr(at, 3) == triple) {
      at += 3;
      // followed by up to two quotes of the content
      for (int more = 0; more < 2 && text.substr(at, 1) == triple.substr(2); ++more) ++at;
      return at;
    } else if (!isLong && (text[at] == quote || text[at] == '\n')) {
      return text[at] == quote ? at + 1 : at;
    }
  }
  return text.size();
}

/// The line of the first key `a.b.c…` of too many parts, if any. toml++ before 3.5 makes a table of each part
/// without a limit, and deletes these one inside of the other: some ten thousand of them exhaust the stack.
std::optional<std::size_t> lineOfDeepKey(std::string_view text) {
  constexpr int maxParts = 16;
  std::size_t line = 1;
  int parts = 1;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = at++;
    if (text[begin] == '"' || text[begin] == '\'') at = endOfString(text, begin);
    if (text[begin] == '#') at = std::min(text.find_first_of("\n\r\v\f", begin), text.size());
    if (text[begin] == '.' && ++parts > maxParts) return line;
    if (std::string_view("\n=,{[").find(text[begin]) != std::string_view::npos) parts = 1;
    line += static_cast<std::size_t>(std::ranges::count(text.substr(begin, at - begin), '\n'));
  }
  return std::nullopt;
}

std::string contentOf(const fs::path& path) {
  std::string text(fs::file_size(path), '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(text.data(), static_cast<std::streamsize>(text.size())))
    fail(ErrorCode::fileUnreadable, "{} cannot be read; check its permissions", path.string());
  return text;
}

}  // namespace

ConfigFile::ConfigFile(fs::path path) : path_(std::move(path)) {
  if (!fs::exists(path_))
    estancia::fail(ErrorCode::fileNotFound, "{} is missing; give a TOML file", path_.string());
  if (!fs::is_regular_file(path_))
    estancia::fail(ErrorCode::unsupportedFile, "{} is no regular file; give a TOML file", path_.string());
  constexpr std::uintmax_t maxBytes = 16 << 20;
  if (const std::uintmax_t bytes = fs::file_size(path_); bytes > maxBytes)
    estancia::fail(ErrorCode::tooLarge, "{}: {} bytes; at most {} are read", path_.string(), bytes, maxBytes);
  parse(contentOf(path_));
}

ConfigFile::ConfigFile(fs::path name, std::string_view text) : path_(std::move(name)) {
  parse(text);
}

void ConfigFile::parse(std::string_view text) {
  if (const auto line = lineOfDeepKey(text))
    estancia::fail(ErrorCode::malformedFile, "{}:{}: a key has too many parts", path_.string(), *line);
  try {
    table_ = toml::parse(text);
  } catch (const toml::parse_error& e) {
    estancia::fail(ErrorCode::malformedFile, "{}:{}: {}", path_.string(), e.source().begin.line,
                   e.description());
  }
}

void ConfigFile::read(const toml::table& table, const std::vector<Key>& keys, Others others) {
  for (const auto& [name, value] : table) {
    const auto found = std::ranges::find(keys, withUnderscores(name.str()), &Key::name);
    if (found == keys.end() && others == Others::skip) continue;
    if (found == keys.end()) {
      std::vector<std::string> names;
      for (const auto& key : keys) names.push_back(key.name);
      fail(value, fmt::format("unknown key `{}`; known keys are {}", std::string(name.str()),
                              fmt::join(names, ", ")));
    }
    key_ = found->name;
    found->use(value);
  }
  for (const auto& key : keys)
    if (key.required && !table.contains(key.name))
      estancia::fail(ErrorCode::malformedFile, "{}: the key `{}` is missing: {}", path_.string(), key.name,
                     key.meaning);
}

std::vector<ConfigFile::Key> ConfigFile::keysOf(OptionGroup& options) {
  std::vector<Key> keys;
  for (Option& option : options.options())
    keys.push_back({option.key(), false, option.help(), [this, &option](const toml::node& node) {
                      try {
                        option.set(tomlText(node, option), "`" + key_ + "`");
                      } catch (const Error& e) {
                        fail(node, e.what());
                      }
                    }});
  for (OptionGroup& group : options.groups())
    keys.push_back({Option(group.name(), Option::Text{}, "").key(), false, group.help(),
                    [this, &group](const toml::node& node) { read(subtable(node), group); }});
  return keys;
}

void ConfigFile::read(const toml::table& table, OptionGroup& options) {
  const std::vector<Key> keys = keysOf(options);
  for (const auto& [name, value] : table) {
    if (std::ranges::find(keys, withUnderscores(name.str()), &Key::name) != keys.end()) continue;
    const std::string path = fmt::format("{}.{}", options.name(), name.str());
    if (const RemovedOption* removed = findRemovedOption(path)) fail(value, describeRemoved(*removed, path));
  }
  read(table, keys);
}

void ConfigFile::fail(const toml::node& at, const std::string& what) const {
  estancia::fail(ErrorCode::malformedFile, "{}:{}: {}", path_.string(), at.source().begin.line, what);
}

std::string ConfigFile::text(const toml::node& node) const {
  const auto value = node.value_exact<std::string>();
  if (!value) fail(node, fmt::format("`{}` must be a text in quotes", key_));
  return *value;
}

bool ConfigFile::flag(const toml::node& node) const {
  const auto value = node.value_exact<bool>();
  if (!value) fail(node, fmt::format("`{}` must be true or false", key_));
  return *value;
}

double ConfigFile::number(const toml::node& node, double min, double max) const {
  const auto value = node.value<double>();
  if (!value || node.is_boolean() || !std::isfinite(*value) || *value < min || *value > max)
    fail(node, fmt::format("`{}` must be a number from {} to {}", key_, min, max));
  return *value;
}

std::int64_t ConfigFile::integer(const toml::node& node, std::int64_t min, std::int64_t max) const {
  const auto value = node.value_exact<std::int64_t>();
  if (!value || *value < min || *value > max)
    fail(node, fmt::format("`{}` must be a whole number from {} to {}", key_, min, max));
  return *value;
}

fs::path ConfigFile::inside(const toml::node& node) const {
  return inside(node, text(node));
}

fs::path ConfigFile::inside(const toml::node& node, const fs::path& path) const {
  if (path.empty() || path.is_absolute() ||
      std::any_of(path.begin(), path.end(), [](auto& part) { return part == ".."; }))
    fail(node, fmt::format("`{}` must be a file in the model's own folder, not \"{}\"", key_, path.string()));
  return path;
}

fs::path ConfigFile::anywhere(const toml::node& node) const {
  std::string path = text(node);
  if (path.empty()) fail(node, fmt::format("`{}` is empty; name a file or folder", key_));
  if (path == "~" || path.starts_with("~/")) path.replace(0, 1, "${HOME}");
  for (std::size_t begin = 0; (begin = path.find("${", begin)) != std::string::npos;) {
    const std::size_t end = path.find('}', begin);
    if (end == std::string::npos) fail(node, fmt::format("`{}`: a ${{ is never closed", key_));
    const std::string name = path.substr(begin + 2, end - begin - 2);
    const auto found = variable(name);
    if (!found) fail(node, fmt::format("`{}`: there is no environment variable {}; set it", key_, name));
    path.replace(begin, end + 1 - begin, *found);
    begin += found->size();
  }
  return (path_.parent_path() / path).lexically_normal();
}

const toml::array& ConfigFile::list(const toml::node& node) const {
  const auto* array = node.as_array();
  if (array == nullptr) fail(node, fmt::format("`{}` must be a list in [ ]", key_));
  return *array;
}

const toml::table& ConfigFile::subtable(const toml::node& node) const {
  const auto* table = node.as_table();
  if (table == nullptr) fail(node, fmt::format("`{}` must be a table", key_));
  return *table;
}

}  // namespace estancia
