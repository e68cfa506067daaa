// Options: each parameter is declared once; TOML keys, command options, range checks and the reference
// follow.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace estancia {

/// One entry of a registry.
struct Choice {
  std::string name;
  std::string explanation;
  bool operator==(const Choice&) const = default;
};
using Choices = std::vector<Choice>;

/// "a, b, c"; the name "" (see Option::automatic) is left out.
std::string namesOf(const Choices& choices);

/// Throws Error (unknownName) unless one of `choices` has this name; `what` names their kind ("filter").
/// The sentence lists the known names.
void requireChoice(std::string_view what, std::string_view name, const Choices& choices);

/// One parameter, bound to the member of an options struct that it reads and writes.
///
/// Its name is what the command takes (--normal-radius) and, with underscores, the key in TOML and JSON
/// (normal_radius). A number lies in [min, max], or in (min, max] where `above` was used.
class Option {
 public:
  /// A member that is no plain value: as text, and from text (throws Error).
  struct Text {
    std::function<std::string()> get;
    std::function<void(const std::string&)> set;
  };
  using Value =
      std::variant<bool*, int*, std::uint32_t*, std::uint64_t*, float*, double*, std::string*,
                   std::optional<int>*, std::optional<double>*, std::optional<std::uint64_t>*, Text>;

  Option(std::string name, Value value, std::string help);

  /// Smallest and largest value that is accepted.
  Option& range(double min, double max = std::numeric_limits<double>::infinity());
  /// Like range(), but excludes `min`.
  Option& above(double min, double max = std::numeric_limits<double>::infinity());
  Option& unit(std::string unit);
  /// The names that a text may be.
  Option& choices(Choices choices);
  /// Why one would change it, for the reference.
  Option& why(std::string why);
  /// Text for "not set" in help and reference instead of a number: "follows the noise".
  Option& automatic(std::string meaning);

  const std::string& name() const { return name_; }
  const std::string& unit() const { return unit_; }
  const std::string& help() const { return help_; }
  const std::string& why() const { return why_; }
  const std::string& automatic() const { return automatic_; }
  const Choices& choices() const { return choices_; }
  const Value& value() const { return value_; }
  double min() const { return min_; }
  double max() const { return max_; }
  /// The key in TOML and JSON.
  std::string key() const;
  bool isFlag() const { return std::holds_alternative<bool*>(value_); }
  bool isInteger() const;
  bool isNumber() const;

  /// The current value as text; "" for an optional that is not set.
  std::string text() const;
  /// Parses and assigns. `path` names the option in messages. Throws Error (invalidOption, unknownName).
  void set(const std::string& text, std::string_view path);
  /// Throws Error (invalidOption, unknownName) when the current value is not accepted.
  void validate(std::string_view path) const;
  /// "0 to 1", "above 0", "a, b or c", "true or false".
  std::string accepted() const;

 private:
  std::optional<double> number() const;
  bool contains(double number) const;

  std::string name_;
  Value value_;
  std::string help_, unit_, why_, automatic_;
  double min_ = -std::numeric_limits<double>::infinity(), max_ = std::numeric_limits<double>::infinity();
  bool open_ = false;  // min_ itself is not accepted
  Choices choices_;
};

/// The options of one struct, and of the structs inside of it. Each options struct has a function
/// `OptionGroup declare(XOptions& options)` that makes one; it must not outlive the struct.
class OptionGroup {
 public:
  OptionGroup(std::string name, std::string help) : name_(std::move(name)), help_(std::move(help)) {}

  Option& add(std::string name, Option::Value value, std::string help);
  /// An enumeration, by the names of its values.
  template <class Enum>
  Option& add(std::string name, Enum& member, std::vector<std::pair<Choice, Enum>> values, std::string help);
  /// A struct inside of the struct.
  void add(OptionGroup group) { groups_.push_back(std::move(group)); }
  /// Renames the group, such as "scene-filter".
  OptionGroup named(std::string name) &&;

  const std::string& name() const { return name_; }
  const std::string& help() const { return help_; }
  const std::vector<Option>& options() const { return options_; }
  std::vector<Option>& options() { return options_; }
  const std::vector<OptionGroup>& groups() const { return groups_; }
  std::vector<OptionGroup>& groups() { return groups_; }

  /// By its path below this group, dashes or underscores: "gng.winner-rate". Null for others.
  Option* find(std::string_view path);
  /// Parses and assigns one. Throws Error (unknownName) that lists the names of the group.
  void set(std::string_view path, const std::string& text);
  /// All values as text, by their paths below this group, also of the groups inside.
  std::map<std::string, std::string> texts() const;
  /// Throws Error (invalidOption, unknownName) on the first value that is not accepted.
  void validate() const { validate(name_); }

 private:
  void validate(const std::string& path) const;

  std::string name_, help_;
  std::vector<Option> options_;
  std::vector<OptionGroup> groups_;
};

/// Throws Error when an option of the struct is out of its range.
template <class Options>
void validate(const Options& options) {
  Options copy = options;
  declare(copy).validate();
}

template <class Enum>
Option& OptionGroup::add(std::string name, Enum& member, std::vector<std::pair<Choice, Enum>> values,
                         std::string help) {
  Choices choices;
  for (const auto& [choice, value] : values) choices.push_back(choice);
  Option::Text text{[&member, values] {
                      for (const auto& [choice, value] : values)
                        if (value == member) return choice.name;
                      return std::string();
                    },
                    [&member, values](const std::string& chosen) {
                      for (const auto& [choice, value] : values)
                        if (choice.name == chosen) member = value;
                    }};
  return add(std::move(name), Option::Value(std::move(text)), std::move(help)).choices(std::move(choices));
}

}  // namespace estancia
