// Export text: what the writers of JSON and XML for other programs share. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/map_file/map.hpp"

namespace estancia::exporting {

/// Indented by one blank; what is no UTF-8 is replaced.
std::string dump(const nlohmann::ordered_json& json);

/// Six decimals suffice, and 0.2F as a double would be 0.20000000298.
double rounded(double probability);
double rounded(float probability);

/// The short labels of a node's best words.
std::vector<std::string> bestWords(const TopologicalMap& map, const Node& node, std::size_t count);

/// The numbers of each node's frames, as they follow each other: a list of [first, last] a node.
std::vector<nlohmann::ordered_json> frameRanges(const TopologicalMap& map);

/// One line: `<data key="key">value</data>` of a node or an edge in GraphML, its value printable and escaped.
std::string data(const char* key, std::string_view value);

}  // namespace estancia::exporting
