// MCP tools: what agents can ask of a map, with the JSON schemas of their arguments. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "estancia/site/queries.hpp"

namespace estancia {

/// An answer for machines, and the same in short for people and language models.
struct ToolAnswer {
  nlohmann::ordered_json content;
  std::string text;
};

/// Answer to tools/list.
nlohmann::ordered_json mcpTools();

/// Nothing where there is no tool of that name. Throws Error: invalidInput where the arguments do not fit
/// its schema, else as the question does.
std::optional<ToolAnswer> callTool(const LiveQueries& queries, const std::string& name,
                                   const nlohmann::json& arguments);

}  // namespace estancia
