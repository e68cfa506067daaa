// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/map_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "estancia/core/fail.hpp"

namespace estancia::report {

std::vector<std::size_t> HeatMap::ranking(std::size_t count) const {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [this](std::size_t a, std::size_t b) { return values[a] > values[b]; });
  order.resize(std::min(count, order.size()));
  while (!order.empty() && values[order.back()] <= 0) order.pop_back();
  return order;
}

HeatMap heatMapOf(const TopologicalMap& map, std::size_t label) {
  if (label >= map.vocabulary.size())
    fail(ErrorCode::invalidInput, "there is no label {} for a heat map; the map has {}", label,
         map.vocabulary.size());
  HeatMap heat{label, {}, 0};
  for (const Node& node : map.nodes) {
    const float value = label < node.mean.size() && node.mean[label] > 0 ? node.mean[label] : 0;
    heat.values.push_back(value);
    heat.largest = std::max(heat.largest, value);
  }
  return heat;
}

std::size_t distinctiveLabel(const TopologicalMap& map) {
  std::size_t best = 0;
  double bestVariance = -1;
  const auto count = static_cast<double>(std::max<std::size_t>(map.nodes.size(), 1));
  for (std::size_t label = 0; label < map.vocabulary.size(); ++label) {
    double sum = 0, squares = 0;
    for (const Node& node : map.nodes) {
      const double value = label < node.mean.size() ? node.mean[label] : 0;
      sum += value;
      squares += value * value;
    }
    const double variance = squares / count - sum / count * (sum / count);
    if (variance > bestVariance) {
      bestVariance = variance;
      best = label;
    }
  }
  return best;
}

Markup heatLegend(const HeatMap& heat) {
  std::string gradient = "background:linear-gradient(90deg";
  for (const Color& color : viridisStops()) gradient += "," + color.hex();
  gradient += ")";
  const double largest = heat.largest;
  Markup legend;
  legend.open("div", {{"class", "heat-legend"}});
  legend.element("span", {{"class", "heat-title"}}, "mean probability");
  legend.open("div", {{"class", "heat-scale"}});
  legend.element("i", {{"style", gradient}}, "");
  legend.open("div", {{"class", "heat-ticks"}});
  for (const double part : {0.0, 0.5, 1.0}) legend.element("span", significant(part * largest));
  return legend.close().close().close();
}

}  // namespace estancia::report
