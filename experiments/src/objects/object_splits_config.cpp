#include <utility>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/config.hpp"
#include "experiments/src/objects/object_splits.hpp"
#include "experiments/src/runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

using Options = ObjectSplitsOptions;
using Data = Options::Data;

constexpr std::int64_t mostSeed = 1'000'000'000;

/// What may stand at the top, for all data, and again in [[data]].
std::vector<ConfigFile::Key> trialKeys(ConfigFile& config, Options::Trials& trials) {
  const auto readNamings = [&config, &trials](const toml::node& node) {
    std::vector<std::string> names;
    each(config, names, oneOf(config, pseudoLabelings()))(node);
    trials.pseudoLabelings.clear();
    for (const std::string& name : names) trials.pseudoLabelings.push_back(getPseudoLabeling(name));
  };
  return {{"namings", false, "how names are made of a labeler's answers", readNamings},
          {"classifiers", false, "", each(config, trials.classifiers, oneOf(config, classifierTypes()))},
          {"label_noises", false, "",
           each(config, trials.noises, [&config](auto& n) { return config.number(n, 0, 1); })},
          {"seeds", false, "", each(config, trials.seeds, [&config](auto& n) {
             return static_cast<std::uint64_t>(config.integer(n, 0, mostSeed));
           })}};
}

Data readData(ConfigFile& config, const toml::table& table, const Options::Trials& defaults) {
  using Split = Options::Split;
  Data data;
  data.trials = defaults;
  const toml::node* names = nullptr;
  auto keys = trialKeys(config, data.trials);
  const auto add = [&keys](const char* name, bool required, const char* meaning, auto use) {
    keys.push_back({name, required, meaning, use});
  };
  add("name", true, "what to call it", [&](auto& n) { data.name = config.text(n); });
  add("views", true, "the folder of views", [&](auto& n) { data.views = config.anywhere(n); });
  add("view_type", false, "", [&](auto& n) {
    std::vector<std::pair<std::string, std::string>> types{{"auto", "auto"}};
    for (const auto& [type, explanation] : objectViewTypes()) types.emplace_back(type, type);
    data.reading.type = config.choice(n, types);
  });
  add("least_points", false, "", [&](auto& n) {
    data.reading.minPoints = static_cast<std::size_t>(config.integer(n, 1, 1'000'000'000));
  });
  add("study", false, "the words", [&](auto& n) { data.study = config.anywhere(n); });
  add("split", false, "", [&](auto& n) {
    data.split = config.choice(
        n, std::vector<std::pair<std::string, Split>>{
               {"instances", Split::instances}, {"views", Split::views}, {"official", Split::official}});
  });
  add("names", false, "", [&](auto& n) {
    names = &n;
    data.machineNames =
        config.choice(n, std::vector<std::pair<std::string, bool>>{{"machine", true}, {"true", false}});
  });
  add("labels", false, "", [&](auto& n) { data.labels = config.anywhere(n); });
  add("model", false, "", [&](auto& n) { data.model = config.text(n); });
  add("prior", false, "", [&](auto& n) {
    data.prior =
        config.choice(n, std::vector<std::pair<std::string, bool>>{{"uniform", true}, {"none", false}});
  });
  add("noise_kind", false, "", [&](auto& n) {
    data.noise = config.choice(
        n, std::vector<std::pair<std::string, NoiseKind>>{
               {"view", NoiseKind::view}, {"pair", NoiseKind::pair}, {"instance", NoiseKind::instance}});
  });
  add("samples", false, "",
      [&](auto& n) { data.shape.samples = static_cast<int>(config.integer(n, 100, 1'000'000)); });
  add("size", false, "", [&](auto& n) { data.shape.size = config.flag(n); });
  add("optional", false, "", [&](auto& n) { data.optional = config.flag(n); });
  config.read(table, keys);
  if (!data.labels.empty() && !data.model.empty())
    config.fail(table, "`model` and `labels` both name the views; leave out one of the two");
  if (data.machineNames && data.labels.empty() && data.model.empty())
    config.fail(names != nullptr ? *names : table,
                "who names the views? Give a `model` or `labels`, or let `names` be \"true\"");
  return data;
}

}  // namespace

ObjectSplitsOptions readObjectSplits(ConfigFile& config) {
  Options options;
  Options::Trials trials;
  const toml::array* data = nullptr;
  auto keys = trialKeys(config, trials);
  keys.push_back({"type", true, "the kind of experiment", [](auto&) {}});
  keys.push_back({"splits", false, "", [&](auto& n) {
                    options.splits = static_cast<std::size_t>(config.integer(n, 1, 100'000));
                  }});
  keys.push_back({"split_seed", false, "", [&](auto& n) {
                    options.splitSeed = static_cast<std::uint64_t>(config.integer(n, 0, mostSeed));
                  }});
  keys.push_back(
      {"folds", false, "", [&](auto& n) { options.folds = static_cast<int>(config.integer(n, 2, 100)); }});
  keys.push_back({"data", true, "[[data]] names views of things", [&](auto& n) { data = &config.list(n); }});
  config.read(keys);
  for (const toml::node& one : *data) options.data.push_back(readData(config, config.subtable(one), trials));
  return options;
}

}  // namespace estancia::experiments
