// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/instance_accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <unordered_map>

#include "estancia/core/label_words.hpp"

namespace estancia {
namespace {

/// What most of an instance's pixels show (structure: below io::firstInstance); `merged`: another has ≥ 1/4.
struct MainThing {
  int id = 0;
  bool merged = false;
};

MainThing mainThing(const PixelsOfThings& pixels) {
  MainThing main;
  double all = 0, most = 0, second = 0;
  for (const auto& [id, count] : pixels) {
    all += count;
    if (count > most) {
      second = main.id >= io::firstInstance ? most : 0;
      most = count;
      main.id = id;
    } else if (id >= io::firstInstance) {
      second = std::max(second, count);
    }
  }
  main.merged = second >= all / 4 && second > 0;
  return main;
}

void countSplits(std::span<const FoundInstance> found, InstanceAccuracy& accuracy) {
  if (std::ranges::all_of(found, [](const FoundInstance& instance) { return instance.pixels.empty(); }))
    return;
  std::unordered_map<int, int> instancesOf;
  accuracy.merged = 0;
  for (const FoundInstance& instance : found) {
    const MainThing main = mainThing(instance.pixels);
    if (main.id >= io::firstInstance) ++instancesOf[main.id];
    *accuracy.merged += main.merged ? 1 : 0;
  }
  accuracy.split = static_cast<std::size_t>(
      std::ranges::count_if(instancesOf, [](const auto& instances) { return instances.second > 1; }));
}

}  // namespace

const std::string& ThingClasses::of(const std::string& category) const {
  const auto known = classOf.find(category);
  return known == classOf.end() ? otherClass : known->second;
}

std::vector<std::string> ThingClasses::labelsOf(const std::string& category,
                                                const Vocabulary& vocabulary) const {
  std::vector<std::string> labels;
  const auto named = words.find(category);
  if (named == words.end()) return labels;
  for (const std::string& word : named->second)
    for (const std::size_t label : findLabels(vocabulary, word))
      if (std::ranges::find(labels, vocabulary[label]) == labels.end()) labels.push_back(vocabulary[label]);
  return labels;
}

std::vector<ConfigFile::Key> thingClassKeys(ConfigFile& config, ThingClasses& classes, bool required,
                                            const std::set<std::string_view>& reserved) {
  const auto requireOwnName = [&config, reserved](const toml::node& node, std::string_view name) {
    if (name.empty() || reserved.contains(name))
      config.fail(node, fmt::format("a class cannot be called \"{}\"; choose another name", name));
  };
  const auto read = [&config, &classes, requireOwnName](const toml::node& node) {
    for (const auto& [name, categories] : config.subtable(node)) {
      requireOwnName(categories, name.str());
      for (const toml::node& category : config.list(categories))
        if (!classes.classOf.emplace(config.text(category), std::string(name.str())).second)
          config.fail(category, fmt::format("{} has a class already", config.text(category)));
    }
  };
  return {{"other", false, "the class of all other categories",
           [&config, &classes, requireOwnName](const toml::node& node) {
             classes.otherClass = config.text(node);
             requireOwnName(node, classes.otherClass);
           }},
          {"classes", required, "a list of categories by class", read}};
}

ThingClasses readThingClasses(const std::filesystem::path& file) {
  ConfigFile config(file);
  ThingClasses classes;
  std::vector<ConfigFile::Key> keys = thingClassKeys(config, classes, false);
  keys.push_back({"words", false, "a list of labels by category", [&](const toml::node& node) {
                    for (const auto& [name, labels] : config.subtable(node)) {
                      std::vector<std::string>& words = classes.words[std::string(name.str())];
                      for (const toml::node& label : config.list(labels)) words.push_back(config.text(label));
                      if (words.empty())
                        config.fail(labels, fmt::format("{} has no words; leave it out", name.str()));
                    }
                  }});
  config.read(keys);
  return classes;
}

std::vector<BoxMatch> matchBoxes(std::span<const OrientedBox> found, std::span<const OrientedBox> things,
                                 double least) {
  std::vector<BoxMatch> pairs;
  for (std::size_t f = 0; f < found.size(); ++f)
    for (std::size_t t = 0; t < things.size(); ++t)
      if (const double overlap = intersectionOverUnion(found[f], things[t]); overlap >= least)
        pairs.push_back({f, t, overlap});
  std::ranges::stable_sort(pairs, std::ranges::greater{}, &BoxMatch::overlap);
  std::vector<bool> used(found.size()), matched(things.size());
  std::vector<BoxMatch> matches;
  for (const BoxMatch& pair : pairs) {
    if (used[pair.found] || matched[pair.thing]) continue;
    used[pair.found] = matched[pair.thing] = true;
    matches.push_back(pair);
  }
  return matches;
}

std::vector<TrueThing> trueThings(const io::HomeTruth& truth, const ThingClasses& classes,
                                  const Vocabulary* vocabulary, const std::set<std::string>& images,
                                  std::size_t minPixels) {
  std::unordered_map<int, std::size_t> framesOf;
  for (const auto& [image, shown] : truth.visible) {
    if (!images.empty() && !images.contains(image)) continue;
    for (const io::VisibleInstance& thing : shown)
      if (thing.pixels >= static_cast<int>(minPixels)) ++framesOf[thing.id];
  }
  std::vector<TrueThing> things;
  for (const io::HomeInstance& thing : truth.instances)
    things.push_back(
        {thing.id,
         {thing.center, thing.size, thing.yaw},
         classes.of(thing.category),
         truth.visible.empty() || framesOf[thing.id] >= minFramesOfThing,
         vocabulary == nullptr ? std::vector<std::string>{} : classes.labelsOf(thing.category, *vocabulary)});
  return things;
}

void addPixels(std::size_t frame, const cv::Mat& segments, const cv::Mat& mask,
               std::map<SegmentPlace, PixelsOfThings>& pixels) {
  if (segments.empty() || mask.empty()) return;
  const int step = (mask.cols + segments.cols - 1) / segments.cols;
  if ((mask.cols + step - 1) / step != segments.cols || (mask.rows + step - 1) / step != segments.rows)
    return;
  for (int v = 0; v < segments.rows; ++v)
    for (int u = 0; u < segments.cols; ++u)
      if (const std::uint8_t segment = segments.at<std::uint8_t>(v, u); inSegment(segment))
        ++pixels[{frame, segment}][mask.at<std::uint16_t>(v * step, u * step)];
}

InstanceAccuracy judgeInstances(std::span<const FoundInstance> found, std::span<const TrueThing> things) {
  std::vector<OrientedBox> foundBoxes, trueBoxes;
  for (const FoundInstance& instance : found) foundBoxes.push_back(instance.box);
  for (const TrueThing& thing : things) trueBoxes.push_back(thing.box);
  std::vector<const TrueThing*> thingOf(found.size(), nullptr);
  std::vector<const FoundInstance*> foundBy(things.size(), nullptr);
  for (const BoxMatch& match : matchBoxes(foundBoxes, trueBoxes)) {
    thingOf[match.found] = &things[match.thing];
    foundBy[match.thing] = &found[match.found];
  }
  const bool anyLabel = std::ranges::any_of(found, [](const auto& one) { return !one.label.empty(); });
  InstanceAccuracy accuracy;
  std::map<InstanceScore*, std::vector<double>> errors;
  for (std::size_t t = 0; t < things.size(); ++t) {
    const TrueThing& thing = things[t];
    if (!thing.counts) continue;
    for (InstanceScore* score : {&accuracy.ofClass[thing.thingClass], &accuracy.counted}) {
      if (score == &accuracy.counted && thing.thingClass == ThingClasses::fixture) continue;
      ++score->things;
      if (foundBy[t] == nullptr) continue;
      ++score->found;
      errors[score].push_back(cv::norm(thing.box.center - foundBy[t]->box.center));
      if (thing.labels.empty() || !anyLabel) continue;
      ++score->nameable;
      score->named += std::ranges::find(thing.labels, foundBy[t]->label) != thing.labels.end() ? 1 : 0;
    }
  }
  for (std::size_t f = 0; f < found.size(); ++f) {
    const std::string name = thingOf[f] == nullptr ? "none" : thingOf[f]->thingClass;
    const bool apart = name == ThingClasses::fixture || (name == "none" && found[f].hangsAtWall);
    for (InstanceScore* score : {&accuracy.ofClass[name], &accuracy.counted}) {
      if (score == &accuracy.counted && apart) continue;
      ++score->instances;
      score->right += thingOf[f] != nullptr ? 1 : 0;
    }
  }
  for (auto& [score, distances] : errors) {
    std::ranges::sort(distances);
    score->error = distances[distances.size() / 2];
  }
  countSplits(found, accuracy);
  return accuracy;
}

}  // namespace estancia
