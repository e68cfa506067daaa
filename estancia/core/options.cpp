// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "estancia/core/ascii.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/removed_options.hpp"

namespace estancia {
namespace {

/// Help and reference print sentences, whether they were declared with a full stop or without.
std::string sentence(std::string text) {
  const bool isOpen = !text.empty() && std::string_view(".:?!").find(text.back()) == std::string_view::npos;
  return isOpen ? text + "." : text;
}

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

template <class Number>
std::optional<Number> parsed(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return {};
  return number;
}

/// Leaves an optional unset.
constexpr std::string_view automaticText = "auto";

std::string replaced(std::string_view name, char from, char to) {
  std::string text(name);
  std::ranges::replace(text, from, to);
  return text;
}

template <class... Members>
bool isOneOf(const Option::Value& value) {
  return (std::holds_alternative<Members*>(value) || ...);
}

bool isOptional(const Option::Value& value) {
  return isOneOf<std::optional<int>, std::optional<double>, std::optional<std::uint64_t>>(value);
}

}  // namespace

std::string namesOf(const Choices& choices) {
  std::string names;
  for (const Choice& choice : choices)
    if (!choice.name.empty()) names += (names.empty() ? "" : ", ") + choice.name;
  return names;
}

void requireChoice(std::string_view what, std::string_view name, const Choices& choices) {
  if (std::ranges::find(choices, name, &Choice::name) != choices.end()) return;
  fail(ErrorCode::unknownName, "unknown {} \"{}\"; known: {}", what, name, namesOf(choices));
}

Option::Option(std::string name, Value value, std::string help)
    : name_(std::move(name)), value_(std::move(value)), help_(std::move(help)) {
  if (isOneOf<std::uint32_t, std::uint64_t, std::optional<std::uint64_t>>(value_)) min_ = 0;
}

Option& Option::range(double min, double max) {
  min_ = min;
  max_ = max;
  open_ = false;
  return *this;
}

Option& Option::above(double min, double max) {
  range(min, max);
  open_ = true;
  return *this;
}

Option& Option::unit(std::string unit) {
  unit_ = std::move(unit);
  return *this;
}

Option& Option::choices(Choices choices) {
  choices_ = std::move(choices);
  return *this;
}

Option& Option::why(std::string why) {
  if (!why.empty()) why[0] = upperCase(why[0]);
  why_ = sentence(std::move(why));
  return *this;
}

Option& Option::automatic(std::string meaning) {
  automatic_ = std::move(meaning);
  return *this;
}

std::string Option::key() const {
  return replaced(name_, '-', '_');
}

bool Option::isInteger() const {
  return isOneOf<int, std::uint32_t, std::uint64_t, std::optional<int>, std::optional<std::uint64_t>>(value_);
}

bool Option::isNumber() const {
  return isInteger() || isOneOf<float, double, std::optional<double>>(value_);
}

std::string Option::text() const {
  return std::visit(
      Overloaded{
          [](const bool* v) { return std::string(*v ? "true" : "false"); },
          [](const std::string* v) { return *v; },
          []<class Number>(const std::optional<Number>* v) { return *v ? fmt::format("{}", **v) : ""; },
          [](const Text& v) { return v.get(); }, [](const auto* v) { return fmt::format("{}", *v); }},
      value_);
}

std::optional<double> Option::number() const {
  return std::visit(Overloaded{[](const bool*) { return std::optional<double>(); },
                               [](const std::string*) { return std::optional<double>(); },
                               [](const Text&) { return std::optional<double>(); },
                               []<class Number>(const std::optional<Number>* v) {
                                 return *v ? std::optional<double>(static_cast<double>(**v)) : std::nullopt;
                               },
                               [](const auto* v) { return std::optional<double>(static_cast<double>(*v)); }},
                    value_);
}

bool Option::contains(double number) const {
  return std::isfinite(number) && (open_ ? number > min_ : number >= min_) && number <= max_;
}

void Option::set(const std::string& text, std::string_view path) {
  const auto refuse = [&] {
    fail(ErrorCode::invalidOption, "{} is \"{}\"; give {}", path, text, accepted());
  };
  if (!choices_.empty()) requireChoice(path, text, choices_);
  const auto assign = [&](auto& member, const auto& number) {
    if (!number || !contains(static_cast<double>(*number))) refuse();
    member = *number;
  };
  std::visit(Overloaded{[&](bool* v) {
                          if (text != "true" && text != "false") refuse();
                          *v = text == "true";
                        },
                        [&](std::string* v) { *v = text; }, [&](const Text& v) { v.set(text); },
                        [&]<class Number>(std::optional<Number>* v) {
                          if (text == automaticText)
                            v->reset();
                          else
                            assign(*v, parsed<Number>(text));
                        },
                        [&](auto* v) { assign(*v, parsed<std::remove_pointer_t<decltype(v)>>(text)); }},
             value_);
}

void Option::validate(std::string_view path) const {
  if (!choices_.empty()) requireChoice(path, text(), choices_);
  if (const auto value = number(); value && !contains(*value))
    fail(ErrorCode::invalidOption, "{} is {}; give {}", path, text(), accepted());
}

std::string Option::accepted() const {
  if (!choices_.empty()) return "one of " + namesOf(choices_);
  if (isFlag()) return "true or false";
  if (!isNumber()) return "a text";
  const std::string kind =
      std::string(isOptional(value_) ? "auto, or " : "") + (isInteger() ? "a whole number" : "a number");
  const std::string inUnit = unit_.empty() ? "" : " " + unit_;
  if (std::isfinite(min_) && max_ < std::numeric_limits<double>::max())
    return open_ ? fmt::format("{} above {} and up to {}{}", kind, min_, max_, inUnit)
                 : fmt::format("{} from {} to {}{}", kind, min_, max_, inUnit);
  if (std::isfinite(min_))
    return fmt::format("{} {} {}{}", kind, open_ ? "above" : "of at least", min_, inUnit);
  return kind + (unit_.empty() ? "" : " in " + unit_);
}

Option& OptionGroup::add(std::string name, Option::Value value, std::string help) {
  return options_.emplace_back(std::move(name), std::move(value), sentence(std::move(help)));
}

OptionGroup OptionGroup::named(std::string name) && {
  name_ = std::move(name);
  return std::move(*this);
}

Option* OptionGroup::find(std::string_view path) {
  const std::string wanted = replaced(path, '_', '-');
  const std::size_t dot = wanted.find('.');
  if (dot == std::string::npos) {
    for (Option& option : options_)
      if (option.name() == wanted) return &option;
    return nullptr;
  }
  for (OptionGroup& group : groups_)
    if (group.name() == wanted.substr(0, dot)) return group.find(std::string_view(wanted).substr(dot + 1));
  return nullptr;
}

void OptionGroup::set(std::string_view path, const std::string& text) {
  const std::string full = fmt::format("{}.{}", name_, replaced(path, '_', '-'));
  if (Option* option = find(path)) return option->set(text, full);
  if (const RemovedOption* removed = findRemovedOption(full))
    throw Error(ErrorCode::unknownName, describeRemoved(*removed, full));
  Choices known;
  for (const Option& option : options_) known.push_back({option.name(), option.help()});
  for (const OptionGroup& group : groups_) known.push_back({group.name() + ".…", group.help()});
  requireChoice("option of " + name_, path, known);
}

std::map<std::string, std::string> OptionGroup::texts() const {
  std::map<std::string, std::string> texts;
  for (const Option& option : options_) texts[option.name()] = option.text();
  for (const OptionGroup& group : groups_)
    for (auto& [path, text] : group.texts()) texts[group.name() + "." + path] = std::move(text);
  return texts;
}

void OptionGroup::validate(const std::string& path) const {
  for (const Option& option : options_) option.validate(path + "." + option.name());
  for (const OptionGroup& group : groups_) group.validate(path + "." + group.name());
}

}  // namespace estancia
