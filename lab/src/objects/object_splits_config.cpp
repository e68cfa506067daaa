// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/config.hpp"
#include "objects/object_splits.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

constexpr std::int64_t maxSeed = 1'000'000'000;

/// What may stand at the top, for all data, and again in [[data]].
std::vector<ConfigFile::Key> trialKeys(ConfigFile& config, ObjectSplitsOptions::Trials& trials) {
  const auto readPseudoLabels = [&config, &trials](const toml::node& node) {
    std::vector<std::string> names;
    each(config, names, oneOf(config, pseudoLabelings()))(node);
    trials.pseudoLabelings.clear();
    for (const std::string& name : names) trials.pseudoLabelings.push_back(getPseudoLabeling(name));
  };
  return {{"pseudo_labels", false, "how names are made of a labeler's answers", readPseudoLabels},
          {"classifiers", false, "", each(config, trials.classifiers, oneOf(config, classifierTypes()))},
          {"label_noises", false, "",
           each(config, trials.noises, [&config](auto& n) { return config.number(n, 0, 1); })},
          {"seeds", false, "", each(config, trials.seeds, [&config](auto& n) {
             return static_cast<std::uint64_t>(config.integer(n, 0, maxSeed));
           })}};
}

OptionGroup declare(ObjectSplitsOptions::Data& data) {
  using Split = ObjectSplitsOptions::Split;
  OptionGroup group("data", "Views of objects.");
  group.add("name", &data.name, "What to call the data");
  group.add("model", &data.model, "The labeler that is asked");
  group.add("split", data.split,
            {{{"instances", "one instance of each class is tested"}, Split::instances},
             {{"views", "a third of the views of each instance is tested"}, Split::views},
             {{"official", "the data set's own"}, Split::official}},
            "What is tested");
  group.add("names", data.machineNames, {{{"machine", "the labeler's"}, true}, {{"true", "people's"}, false}},
            "The names that are learned from");
  group.add("prior", data.prior,
            {{{"uniform", "corrected by its prior"}, true}, {{"none", "as it is"}, false}},
            "What the labeler's answers are corrected to");
  group.add("noise-kind", data.noise,
            {{{"view", "view by view"}, NoiseKind::view},
             {{"pair", "view by view, always for the next class"}, NoiseKind::pair},
             {{"instance", "all views of an instance alike"}, NoiseKind::instance}},
            "What label noise misnames");
  group.add("min-points", &data.reading.minPoints, "Smallest number of points of a view").range(1, 1e9);
  group.add("samples", &data.shape.samples, "Samples of the shape descriptor").range(100, 1e6);
  group.add("size", &data.shape.size, "The shape descriptor knows the size");
  group.add("optional", &data.optional, "Leave out, with a note, when it is not there");
  return group;
}

OptionGroup declare(ObjectSplitsOptions& options) {
  OptionGroup group("object-splits", "Objects that name each other.");
  group.add("splits", &options.splits, "Random splits").range(1, 100'000);
  group.add("split-seed", &options.splitSeed, "Seed of the random splits").range(0, maxSeed);
  group.add("folds", &options.folds, "Folds of the cross-validation").range(2, 100);
  group.add("thesis-tables", &options.thesisTables, "The thesis' accuracies beside, of its own objects");
  return group;
}

ObjectSplitsOptions::Data readData(ConfigFile& config, const toml::table& table,
                                   const ObjectSplitsOptions::Trials& defaults) {
  ObjectSplitsOptions::Data data;
  data.trials = defaults;
  auto keys = together(trialKeys(config, data.trials), requiring("name", keysOf(config, declare(data))));
  const auto add = [&keys](const char* name, bool required, const char* meaning, auto use) {
    keys.push_back({name, required, meaning, use});
  };
  add("views", true, "the folder of views", [&](auto& n) { data.views = config.anywhere(n); });
  add("view_type", false, "", [&](auto& n) {
    std::vector<std::pair<std::string, std::string>> types{{"auto", "auto"}};
    for (const auto& [type, explanation] : objectViewTypes()) types.emplace_back(type, type);
    data.reading.type = config.choice(n, types);
  });
  add("study", false, "", [&](auto& n) { data.study = config.anywhere(n); });
  add("labels", false, "", [&](auto& n) { data.labels = config.anywhere(n); });
  config.read(table, keys);
  if (!data.labels.empty() && !data.model.empty())
    config.fail(table, "`model` and `labels` both name the views; leave out one of the two");
  if (data.machineNames && data.labels.empty() && data.model.empty())
    config.fail(table.contains("names") ? *table.get("names") : table,
                "who names the views? Give a `model` or `labels`, or let `names` be \"true\"");
  return data;
}

}  // namespace

ObjectSplitsOptions readObjectSplits(ConfigFile& config) {
  ObjectSplitsOptions options;
  ObjectSplitsOptions::Trials trials;
  const toml::array* data = nullptr;
  config.read(together(
      together(trialKeys(config, trials), keysOf(config, declare(options))),
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"data", true, "[[data]] names views of objects", [&](auto& n) { data = &config.list(n); }}}));
  for (const toml::node& one : *data) options.data.push_back(readData(config, config.subtable(one), trials));
  return options;
}

}  // namespace estancia::experiments
