// SPDX-License-Identifier: Apache-2.0
#include "recognition/recognition_results.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "findings/pivot.hpp"

namespace estancia::experiments {

std::string nameOf(const RecognitionResults::SceneFilter& filter) {
  return filter.second == 0 ? filter.first : fmt::format("{} {}", filter.first, filter.second);
}

std::vector<std::string> RecognitionCell::measures() {
  return {"pairs",          "verified",      "correct",        "false_positives", "seconds",
          "filter_seconds", "model_seconds", "absent",         "failed",          "seeds",
          "correct_least",  "correct_most",  "extra_instances"};
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
                                       {"extra_instances", extra},
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

RecognitionResults::Place RecognitionResults::placeOf(std::size_t cell) const {
  const auto next = [&cell](std::size_t size) {
    const std::size_t digit = cell % size;
    cell /= size;
    return digit;
  };
  Place place;
  place.sceneFilter = next(sceneFilters.size());
  place.noise = next(noises.size());
  place.modelFilter = next(modelFilters.size());
  place.descriptor = next(descriptors.size());
  place.keypoint = next(keypoints.size());
  place.preset = cell;
  return place;
}

double RecognitionResults::mean(const RecognitionScore& score,
                                const std::function<bool(const Place&)>& wanted) const {
  std::vector<double> values;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (wanted(placeOf(i))) values.push_back(score.of(cells[i]));
  return meanOf(values);
}

}  // namespace estancia::experiments
