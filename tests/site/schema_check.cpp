// SPDX-License-Identifier: Apache-2.0
#include "schema_check.hpp"

#include <algorithm>
#include <regex>
#include <set>
#include <stdexcept>

namespace estancia::test {
namespace {

using Json = nlohmann::json;

bool isOfType(const Json& value, const std::string& type) {
  return type == "object"    ? value.is_object()
         : type == "array"   ? value.is_array()
         : type == "string"  ? value.is_string()
         : type == "boolean" ? value.is_boolean()
         : type == "null"    ? value.is_null()
         : type == "integer" ? value.is_number_integer()
         : type == "number"  ? value.is_number()
                             : throw std::runtime_error("no type of JSON: " + type);
}

std::string objectProblem(const Json& value, const Json& schema, const Json& root, const std::string& at) {
  const Json properties = schema.value("properties", Json::object());
  for (const Json& key : schema.value("required", Json::array()))
    if (!value.contains(key.get<std::string>())) return at + " lacks " + key.get<std::string>();
  for (const auto& [key, one] : value.items()) {
    Json of = schema.value("additionalProperties", Json(true));
    if (properties.contains(key)) of = properties[key];
    if (of == Json(false)) return at + " has " + key;
    if (!of.is_object()) continue;
    if (std::string problem = schemaProblem(one, of, root, at + "." + key); !problem.empty()) return problem;
  }
  return "";
}

std::string arrayProblem(const Json& value, const Json& schema, const Json& root, const std::string& at) {
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

void requireKnownKeywords(const Json& schema) {
  static const std::set<std::string> known{
      "$ref",        "type",     "properties", "required", "additionalProperties",
      "items",       "minItems", "maxItems",   "minimum",  "maximum",
      "enum",        "const",    "pattern",    "oneOf",    "maxLength",
      "description", "default"};
  for (const auto& [key, value] : schema.items())
    if (!known.contains(key)) throw std::runtime_error("unknown keyword " + key);
}

}  // namespace

std::string schemaProblem(const Json& value, const Json& schema, const Json& root, const std::string& at) {
  requireKnownKeywords(schema);
  if (schema.contains("$ref"))
    return schemaProblem(value, root.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))),
                         root, at);
  if (schema.contains("oneOf")) {
    std::size_t fits = 0;
    std::string why;
    for (const Json& one : schema["oneOf"]) {
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
    const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
    if (std::ranges::none_of(types, [&](const Json& type) { return isOfType(value, type); }))
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
