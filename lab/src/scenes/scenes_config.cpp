// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <utility>

#include "estancia/classify/classifier.hpp"
#include "estancia/classify/label_selection.hpp"
#include "estancia/core/config.hpp"
#include "runner/config_lists.hpp"
#include "scenes/scenes.hpp"

namespace estancia::experiments {
namespace {

OptionGroup declare(ScenesOptions::Data& data) {
  OptionGroup group("data", "Images with rooms.");
  group.add("name", &data.name, "What to call them");
  group.add("image-column", &data.imageColumn, "Column of the images' names");
  group.add("room-column", &data.roomColumn, "Column of the rooms");
  group.add("split-column", &data.splitColumn, "Column of the splits; none: all images belong together");
  group.add("train-value", &data.train, "Split that is learned from");
  group.add("test-value", &data.test, "Split that is asked about");
  group.add("optional", &data.optional, "Leave out, with a note, when they are not there");
  return group;
}

OptionGroup declare(ScenesOptions& options) {
  OptionGroup group("scenes", "Descriptors and classifiers of rooms.");
  group.add("folds", &options.folds, "Folds in which classifiers choose their parameters").range(2, 100);
  group.add("same-sequence", &options.sameSequence, "Also pairs of a sequence with itself");
  group.add("thesis-tables", &options.thesisTables, "The thesis' Table 3.2 beside, of ViDRILO");
  return group;
}

ScenesOptions::Data readData(ConfigFile& config, const toml::table& table) {
  ScenesOptions::Data data;
  const toml::table* asked = nullptr;
  auto keys =
      together(sourceKeys(config, data.images, true), requiring("name", keysOf(config, declare(data))));
  keys.push_back({"table", false, "the CSV of rooms", [&](auto& n) { data.table = config.anywhere(n); }});
  keys.push_back({"only", false, "only these rooms",
                  each(config, data.only, [&config](auto& n) { return config.text(n); })});
  keys.push_back({"ignored", false, "columns that are no features",
                  each(config, data.ignored, [&config](auto& n) { return config.text(n); })});
  keys.push_back({"test", false, "the images to ask about", [&](auto& n) { asked = &config.subtable(n); }});
  config.read(table, keys);
  const toml::node* column =
      firstOf(table, {"image_column", "room_column", "split_column", "train_value", "test_value"});
  if (column != nullptr && data.table.empty())
    config.fail(*column, "a column of which table? name it by `table`");
  if (asked != nullptr) {
    if (!data.splitColumn.empty())
      config.fail(*asked, "`split_column` parts the images already; leave out one of the two");
    data.asked = data.images;  // equal except for the labels
    config.read(*asked, sourceKeys(config, *data.asked, false));
  }
  return data;
}

ScenesOptions::Subsets readSubsets(ConfigFile& config, const toml::table& table) {
  ScenesOptions::Subsets subsets;
  const auto count = [&config](const toml::node& node) -> std::size_t {
    if (node.is_string()) return config.choice(node, std::vector{std::pair{std::string("all"), 0}});
    return static_cast<std::size_t>(config.integer(node, 1, 1000000));
  };
  const auto classifier = oneOf(config, classifierTypes());
  config.read(table,
              {{"descriptor", true, "whose labels", [&](auto& n) { subsets.descriptor = config.text(n); }},
               {"classifier", true, "that learns", [&](auto& n) { subsets.classifier = classifier(n); }},
               {"counts", true, "how many labels", each(config, subsets.counts, count)},
               {"by", true, "the rules that choose them",
                each(config, subsets.by, oneOf(config, selectionCriteria()))}});
  // A curve needs ascending positions; all labels come last.
  std::sort(subsets.counts.begin(), subsets.counts.end(),
            [](std::size_t a, std::size_t b) { return a - 1 < b - 1; });
  return subsets;
}

}  // namespace

ScenesOptions readScenes(ConfigFile& config) {
  ScenesOptions options;
  options.name = config.path().stem().string();
  const auto text = [&config](const toml::node& node) { return config.text(node); };
  const auto seed = [&config](const toml::node& node) {
    return static_cast<std::uint64_t>(config.integer(node, 0, std::numeric_limits<std::int64_t>::max()));
  };
  const toml::array* data = nullptr;
  const toml::table* subsets = nullptr;
  const toml::node* focus = nullptr;
  config.read(together(
      keysOf(config, declare(options)),
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"descriptors", true, "what describes an image, as \"inception-v3+gist\"",
        each(config, options.descriptors, text)},
       {"optional_descriptors", false, "and these where they are",
        each(config, options.optionalDescriptors, text)},
       {"classifiers", false, "", each(config, options.classifiers, oneOf(config, classifierTypes()))},
       {"seeds", false, "", each(config, options.seeds, seed)},
       {"subsets", false, "", [&](auto& n) { subsets = &config.subtable(n); }},
       {"focus", false, "a sequence that is also looked at alone", [&](auto& n) { focus = &n; }},
       {"data", true, "[[data]] names images with rooms", [&](auto& n) { data = &config.list(n); }}}));
  if (subsets != nullptr) options.subsets = readSubsets(config, *subsets);
  for (const toml::node& one : *data) options.data.push_back(readData(config, config.subtable(one)));
  if (focus != nullptr) {
    std::vector<std::pair<std::string, std::string>> names;
    for (const auto& one : options.data) names.emplace_back(one.name, one.name);
    options.focus = config.choice(*focus, names);
  }
  return options;
}

}  // namespace estancia::experiments
