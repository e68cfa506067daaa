// JSON Schema: whether a value matches a schema, for the keywords that our descriptions use.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace estancia::test {

/// "" where it is, else where in the value and why not. `root`: where references lead. Throws
/// std::runtime_error for a keyword that it does not know.
std::string schemaProblem(const nlohmann::json& value, const nlohmann::json& schema,
                          const nlohmann::json& root, const std::string& at = "$");

}  // namespace estancia::test
