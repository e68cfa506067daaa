// JSON Schema: whether a value matches a schema, for the keywords that our descriptions use.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>

namespace estancia::test {

/// "" where it is, else where in the value and why not. `root`: where references lead. Throws
/// std::runtime_error for a keyword that it does not know.
std::string schemaProblem(const nlohmann::json& value, const nlohmann::json& schema,
                          const nlohmann::json& root, const std::string& at = "$");

inline bool isOfType(const nlohmann::json& value, const std::string& type) {
  return type == "object"    ? value.is_object()
         : type == "array"   ? value.is_array()
         : type == "string"  ? value.is_string()
         : type == "boolean" ? value.is_boolean()
         : type == "null"    ? value.is_null()
         : type == "integer" ? value.is_number_integer()
         : type == "number"  ? value.is_number()
                             : throw std::runtime_error("no type of JSON: " + type);
}

inline std::string objectProblem(const nlohmann::json& value, const nlohmann::json& schema,
                                 const nlohmann::json& root, const std::string& at) {
  const nlohmann::json properties = schema.value("properties", nlohmann::json::object());
  for (const nlohmann::json& key : schema.value("required", nlohmann::json::array()))
    if (!value.contains(key.get<std::string>())) return at + " lacks " + key.get<std::string>();
  for (const auto& [key, one] : value.items()) {
    nlohmann::json of = schema.value("additionalProperties", nlohmann::json(true));
    if (properties.contains(key)) of = properties[key];
    if (of == nlohmann::json(false)) return at + " has " + key;
    if (!of.is_object()) continue;
    if (std::string problem = schemaProblem(one, of, root, at + "." + key); !problem.empty()) return problem;
  }
  return "";
}

inline std::string arrayProblem(const nlohmann::json& value, const nlohmann::json& schema,
                                const nlohmann::json& root, const std::string& at) {
  if (value.size() < schema.value("minItems", 0U) || value.size() > schema.value("maxItems", 1U << 30))
    return at + " has " + std::to_string(value.size()) + " items";
  if (schema.contains("items"))
    for (std::size_t i = 0; i < value.size(); ++i)
      if (std::string problem =
              schemaProblem(value[i], schema["items"], root, at + "[" + std::to_string(i) + "]");
          !problem.empty())
        return problem;
  return "";
}

inline void requireKnownKeywords(const nlohmann::json& schema) {
  static const std::set<std::string> known{
      "$ref",        "type",     "properties", "required", "additionalProperties",
      "items",       "minItems", "maxItems",   "minimum",  "maximum",
      "enum",        "const",    "pattern",    "oneOf",    "maxLength",
      "description", "default"};
  for (const auto& [key, value] : schema.items())
    if (!known.contains(key)) throw std::runtime_error("unknown keyword " + key);
}

inline std::string schemaProblem(const nlohmann::json& value, const nlohmann::json& schema,
                                 const nlohmann::json& root, const std::string& at) {
  requireKnownKeywords(schema);
  if (schema.contains("$ref"))
    return schemaProblem(
        value, root.at(nlohmann::json::json_pointer(schema["$ref"].get<std::string>().substr(1))), root, at);
  if (schema.contains("oneOf")) {
    std::size_t fits = 0;
    std::string why;
    for (const nlohmann::json& one : schema["oneOf"]) {
      const std::string problem = schemaProblem(value, one, root, at);
      fits += problem.empty() ? 1 : 0;
      if (!problem.empty()) why += (why.empty() ? "" : ", or ") + problem;
    }
    return fits == 1 ? "" : fits == 0 ? why : at + " is several";
  }
  if (schema.contains("const") && value != schema["const"]) return at + " is " + value.dump();
  if (schema.contains("enum") && std::ranges::find(schema["enum"], value) == schema["enum"].end())
    return at + " is " + value.dump();
  if (schema.contains("type")) {
    const nlohmann::json types =
        schema["type"].is_array() ? schema["type"] : nlohmann::json::array({schema["type"]});
    if (std::ranges::none_of(types, [&](const nlohmann::json& type) { return isOfType(value, type); }))
      return at + " is " + value.dump().substr(0, 60) + ", not " + types.dump();
  }
  if (value.is_number() &&
      (value < schema.value("minimum", -1e300) || value > schema.value("maximum", 1e300)))
    return at + " is " + value.dump();
  if (value.is_string() && schema.contains("pattern") &&
      !std::regex_search(value.get<std::string>(), std::regex(schema["pattern"].get<std::string>())))
    return at + " is " + value.dump();
  if (value.is_object()) return objectProblem(value, schema, root, at);
  if (value.is_array()) return arrayProblem(value, schema, root, at);
  return "";
}

}  // namespace estancia::test
