// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/object_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "estancia/core/printable.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/objects/clustered_frame.hpp"

namespace estancia {
namespace {

/// Labels by the views that they are of.
class LabeledViewRows {
 public:
  LabeledViewRows(const ObjectViews& views, const DescriptorSequence& labels) : labels_(labels) {
    std::map<std::string, std::size_t> rowNamed;
    for (std::size_t row = 0; row < labels.frames.size(); ++row)
      rowNamed.emplace(labels.frames[row].name, row);
    for (std::size_t i = 0; i < views.size(); ++i)
      if (const auto row = rowNamed.find(views.view(i).name); row != rowNamed.end()) rowOf_[i] = row->second;
  }

  /// The most probable word of these views; nameless where none has labels.
  FamiliarWord wordOf(const std::vector<std::size_t>& views, const LabelConcepts& concepts) const {
    const auto labeled = std::ranges::count_if(views, [&](std::size_t i) { return rowOf_.contains(i); });
    std::vector<float> mean(labels_.vocabulary.size());
    for (const std::size_t view : views)
      if (const auto row = rowOf_.find(view); row != rowOf_.end())
        for (std::size_t l = 0; l < mean.size(); ++l)
          mean[l] += labels_.descriptors.row(row->second)[l] / static_cast<float>(labeled);
    const auto words = familiarWords(labels_.vocabulary, concepts, mean, labeled > 0 ? 1 : 0);
    return words.empty() ? FamiliarWord{} : words.front();
  }

  float shareOf(const FamiliarWord& word, std::size_t view) const {
    float share = 0;
    if (const auto row = rowOf_.find(view); row != rowOf_.end())
      for (const std::size_t label : word.labels) share += labels_.descriptors.row(row->second)[label];
    return share;
  }

 private:
  const DescriptorSequence& labels_;
  std::map<std::size_t, std::size_t> rowOf_;
};

}  // namespace

Images objectSheet(const ObjectViews& views, const DescriptorSequence* labels,
                   const LabelConcepts& concepts) {
  std::optional<LabeledViewRows> rows;
  if (labels != nullptr) rows.emplace(views, *labels);
  std::map<std::string, std::vector<std::size_t>> objects;
  for (std::size_t i = 0; i < views.size(); ++i) objects[views.view(i).instance].push_back(i);
  Images sheet{
      "All objects", "A view of each, its most probable word by all of its views, and their number.", {}};
  const auto crops = cropsOf(views);
  for (const auto& [instance, of] : objects) {
    const FamiliarWord word = rows ? rows->wordOf(of, concepts) : FamiliarWord{};
    const std::size_t best = *std::ranges::max_element(of, {}, [&](std::size_t i) {
      return std::pair(!views.view(i).flat && !views.view(i).atBorder, rows ? rows->shareOf(word, i) : 0.F);
    });
    const std::string& category = views.view(best).category;
    sheet.images.push_back(
        {encodeImage(crops->image(best), 128),
         fmt::format("{}{}: {}{}", printable(instance),
                     category.empty() ? "" : fmt::format(" ({})", printable(category)),
                     word.name.empty() ? "" : fmt::format("{} {:.0f} %, ", word.name, 100 * word.probability),
                     report::counted(of.size(), "view"))});
  }
  return sheet;
}

}  // namespace estancia
