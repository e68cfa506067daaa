// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/export_text.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/places.hpp"

namespace estancia::exporting {
namespace {

std::string escapeXml(std::string_view text) {
  std::string result;
  for (const char c : printable(text)) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  return result;
}

}  // namespace

std::string dump(const nlohmann::ordered_json& json) {
  // Names come from file systems and may be no UTF-8.
  return json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

double rounded(double probability) {
  return std::round(probability * 1e6) / 1e6;
}

double rounded(float probability) {
  return rounded(static_cast<double>(probability));
}

std::vector<std::string> bestWords(const TopologicalMap& map, const Node& node, std::size_t count) {
  std::vector<std::string> words;
  for (const std::size_t label : bestLabels(node, count)) words.push_back(shortLabel(map.vocabulary[label]));
  return words;
}

std::vector<nlohmann::ordered_json> frameRanges(const TopologicalMap& map) {
  std::vector<nlohmann::ordered_json> ranges(map.nodes.size(), nlohmann::ordered_json::array());
  for (const Visit& visit : visitsOf(map))
    if (const std::size_t i = indexOf(map, visit.node); i < ranges.size())
      ranges[i].push_back({visit.firstFrame, visit.lastFrame});
  return ranges;
}

std::string data(const char* key, std::string_view value) {
  return fmt::format("      <data key=\"{}\">{}</data>\n", key, escapeXml(value));
}

}  // namespace estancia::exporting
