// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/json_problem.hpp"

#include <fmt/format.h>

#include <string_view>

#include "estancia/core/printable.hpp"

namespace estancia::io {
namespace {

/// Text between two markers; "" if one is missing.
std::string_view between(std::string_view text, std::string_view before, std::string_view after) {
  const std::size_t from = text.find(before);
  if (from == std::string_view::npos) return {};
  text.remove_prefix(from + before.size());
  return text.substr(0, text.find(after));
}

}  // namespace

std::string jsonProblem(const std::exception& problem) {
  const std::string_view what = problem.what();
  if (const auto place = between(what, "parse error at ", ":"); !place.empty())
    return fmt::format("no JSON at {}", place);
  if (const auto key = between(what, "key '", "' not found"); !key.empty())
    return fmt::format("\"{}\" is missing", printable(key));
  if (what.starts_with("[json.exception.type_error")) return "a value is of another type";
  return printable(between(what, "] ", "\n"));
}

}  // namespace estancia::io
