#include "experiments/src/recognition/recognition_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace estancia::experiments {

std::string nameOf(const RecognitionResults::SceneFilter& filter) {
  return filter.second == 0 ? filter.first : fmt::format("{} {}", filter.first, filter.second);
}

std::vector<std::string> RecognitionCell::measures() {
  return {"pairs",         "verified", "correct", "false_positives", "seconds",       "filter_seconds",
          "model_seconds", "absent",   "failed",  "seeds",           "correct_least", "correct_most"};
}

CellResults RecognitionCell::toResults() const {
  const auto [least, most] = std::minmax_element(correctBySeed.begin(), correctBySeed.end());
  CellResults results{
      {"seconds", "", seconds}, {"filter_seconds", "", filterSeconds}, {"model_seconds", "", modelSeconds}};
  for (const auto& [measure, count] : {std::pair<const char*, std::size_t>{"pairs", pairs},
                                       {"verified", verified},
                                       {"correct", correct},
                                       {"false_positives", falsePositives},
                                       {"absent", absent},
                                       {"failed", failed},
                                       {"seeds", seeds},
                                       {"correct_least", least == correctBySeed.end() ? 0 : *least},
                                       {"correct_most", most == correctBySeed.end() ? 0 : *most}})
    results.push_back({measure, "", static_cast<double>(count)});
  return results;
}

std::string titleOf(const RecognitionResults& results, std::size_t preset, std::size_t descriptor,
                    const std::string& rest) {
  return fmt::format("{}{}, {}", results.presets.size() > 1 ? results.presets[preset] + ": " : "",
                     results.descriptors[descriptor], rest);
}

std::string millimeters(double meters) {
  return fmt::format("{:.4g} mm", 1000 * meters);
}

double meanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace estancia::experiments
