// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/instance_accuracy.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <unordered_map>

#include "estancia/objects/segment_image.hpp"

namespace estancia {
namespace {

std::optional<double> shareOf(std::size_t part, std::size_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

/// The thing that most of an instance's pixels show, below io::firstInstance where that is structure, and
/// whether another thing has a quarter of them.
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

std::optional<double> InstanceScore::recall() const {
  return shareOf(found, things);
}
std::optional<double> InstanceScore::precision() const {
  return shareOf(right, instances);
}
std::optional<double> InstanceScore::nameAccuracy() const {
  return shareOf(named, nameable);
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
