// SPDX-License-Identifier: Apache-2.0
#include "estancia/layers/object_layer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "estancia/areas/area_plan.hpp"
#include "estancia/cloud/crop_object.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/log_opinion_pool.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/layers/instance_views.hpp"
#include "estancia/world_file/edit_rules.hpp"

namespace estancia {
namespace {

/// Unused label budget carries over, at most that of so many frames: one frame must not take long.
constexpr std::size_t maxSaved = 3;

/// Whether an image could be labeled. Where it could not, the next one may be.
template <class Work>
bool tried(const char* what, const Work& work) {
  try {
    work();
    return true;
  } catch (const FrameError&) {
  } catch (const Error&) {
    throw;
  } catch (...) {
    frameFailure(what);
  }
  return false;
}

/// Scales a box to an image of another size.
cv::Rect inImage(const cv::Rect& box, const cv::Size& from, const cv::Size& to) {
  const double x = static_cast<double>(to.width) / from.width,
               y = static_cast<double>(to.height) / from.height;
  const cv::Rect scaled(
      cv::Point(static_cast<int>(box.x * x), static_cast<int>(box.y * y)),
      cv::Point(static_cast<int>(std::ceil(box.br().x * x)), static_cast<int>(std::ceil(box.br().y * y))));
  return scaled & cv::Rect({}, to);
}

/// The labels that are more probable than by chance, at most 32, best first.
std::vector<LabelProbability> bestWords(const std::vector<double>& pooled, const Vocabulary& vocabulary) {
  constexpr std::size_t most = 32;
  std::vector<std::size_t> order(pooled.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t i) { return pooled[i]; });
  std::vector<LabelProbability> words;
  for (const std::size_t i : order) {
    if (words.size() == most || pooled[i] * static_cast<double>(pooled.size()) <= 1) break;
    // a word of two members
    if (std::ranges::find(words, vocabulary[i], &LabelProbability::label) == words.end())
      words.push_back({vocabulary[i], static_cast<float>(pooled[i])});
  }
  return words;
}

}  // namespace

ObjectLayer::ObjectLayer(WorldStore& store, const Vocabulary& vocabulary, const InstanceMapOptions& options,
                         Labeler* labeler, std::size_t crops)
    : store_(store), vocabulary_(vocabulary), options_(options), labeler_(labeler), crops_(crops) {
  regionLabels_ = store_.regionLabels();
  if (labeler_ != nullptr && labeler_->regionLabels() != regionLabels_) {
    regionLabels_ = labeler_->regionLabels();
    store_.putRegionLabels(regionLabels_);
  }
  for (LabeledSegment& view : store_.views())
    labeled_.emplace(SegmentPlace(view.frame, view.segment), std::move(view));
}

void ObjectLayer::restart(const Floor& floor) {
  floor_ = floor;
  instances_.emplace(floor, options_);
  looks_.clear();
  lastFrame_.reset();
}

void ObjectLayer::add(std::size_t frame, const cv::Mat& depth, const Observation& seen, const Pose& pose) {
  if (seen.segments.empty()) return;
  frames_ = lastFrame_ ? frame - *lastFrame_ : 1;
  lastFrame_ = frame;
  instances_->add(frame, depth, seen.segments, seen.camera, pose);
  for (std::size_t s = 1; s <= seen.info.size(); ++s) {
    const Observation::Segment& segment = seen.info[s - 1];
    looks_[{frame, s}] = {segment.color, segment.flat, viewQuality(segment)};
    if (labeled_.contains({frame, s})) instances_->labeled({frame, s});
  }
}

void ObjectLayer::label(std::size_t frame, const Observation& seen, const cv::Mat& image,
                        const Deadline& deadline) {
  if (labeler_ == nullptr || seen.info.empty() || image.empty()) return;
  labelRegions(frame, seen, image);
  const std::vector<double> worth = instances_->worthLabeling();
  std::vector<std::size_t> order(worth.size());
  std::iota(order.begin(), order.end(), 0);
  const auto value = [&](std::size_t i) { return seen.info[i].atBorder ? worth[i] / 4 : worth[i]; };
  std::ranges::stable_sort(order, std::ranges::greater{}, value);
  const std::size_t most = maxSaved * crops_,
                    owed = std::min(std::min(frames_, maxSaved) * crops_ + std::exchange(putOff_, 0), most);
  order.resize(std::min(order.size(), owed));
  for (std::size_t done = 0; done < order.size(); ++done) {
    if (!labeling_.isDue(deadline)) {
      putOff_ = order.size() - done;
      break;
    }
    const std::size_t i = order[done];
    const Observation::Segment& segment = seen.info[i];
    const cv::Mat crop = cropObject(image, inImage(segment.box, seen.depth.size(), image.size()));
    LabeledSegment labeled{frame, i + 1, value(i)};
    if (!tried("an image of an object", [&] { labeling_.run([&] { labeled.words = labelCrop(crop); }); }))
      continue;
    store_.putView(labeled, encodeImage(crop));
    instances_->labeled({frame, i + 1});
    labeled_.emplace(SegmentPlace(frame, i + 1), std::move(labeled));
  }
}

/// A detector looks at the whole image once, and reports each segment in its surroundings.
void ObjectLayer::labelRegions(std::size_t frame, const Observation& seen, const cv::Mat& image) {
  if (regionLabels_.empty()) return;
  const double width = seen.depth.cols, height = seen.depth.rows;
  std::vector<cv::Rect2d> regions;
  for (const Observation::Segment& segment : seen.info)
    regions.emplace_back(segment.box.x / width, segment.box.y / height, segment.box.width / width,
                         segment.box.height / height);
  std::vector<LexicalDescriptor> words;
  tried("the objects of an image", [&] { words = labeler_->labelRegions(image, regions); });
  for (std::size_t i = 0; i < words.size(); ++i) store_.putSegmentWords({frame, i + 1}, words[i]);
}

/// By the members that are no detectors: a detector knows a thing among others, not cut out.
LexicalDescriptor ObjectLayer::labelCrop(const cv::Mat& crop) {
  if (regionLabels_.empty()) return labeler_->label(crop);
  std::vector<LexicalDescriptor> answers;
  for (Labeler* member : labeler_->members())
    answers.push_back(member->regionLabels().empty() ? member->label(crop)
                                                     : LexicalDescriptor(member->vocabulary().size(), 0.0F));
  return answers.empty() ? LexicalDescriptor(vocabulary_.size(), 0.0F) : labeler_->combine(answers);
}

/// A probability a label of each object: its images pooled; a detector's labels as means of its segments.
std::vector<std::vector<double>> ObjectLayer::wordsOf(const std::vector<ObjectInstance>& found,
                                                      const std::map<SegmentPlace, int>& objectOf) const {
  std::vector<std::vector<double>> words, sums(found.size(), std::vector<double>(regionLabels_.size()));
  std::vector<double> segments(found.size());
  store_.forEachSegmentWords([&](const SegmentPlace& place, const LexicalDescriptor& here) {
    const auto object = objectOf.find(place);
    if (object == objectOf.end()) return;
    const auto i = static_cast<std::size_t>(object->second);
    ++segments[i];
    for (std::size_t l = 0; l < here.size(); ++l) sums[i][l] += static_cast<double>(here[l]);
  });
  for (std::size_t i = 0; i < found.size(); ++i) {
    LogOpinionPool pool(vocabulary_.size());
    for (const SegmentPlace& place : found[i].segments)
      if (const auto view = labeled_.find(place); view != labeled_.end()) pool.add(view->second.words);
    words.push_back(pool.pooled());
    if (segments[i] == 0) continue;
    words[i].resize(vocabulary_.size());
    for (std::size_t l = 0; l < regionLabels_.size(); ++l)
      words[i][regionLabels_[l]] = sums[i][l] / segments[i];
  }
  return words;
}

WorldObject ObjectLayer::worldObject(const ObjectInstance& instance) const {
  WorldObject object;
  const OrientedBox& box = instance.box;
  object.center = floor_->point(box.center);
  object.size = box.size;
  object.yaw = box.yaw;
  object.views = instance.views;
  object.firstFrame = instance.segments.front().first;
  object.lastFrame = instance.segments.back().first;
  static_assert(static_cast<int>(Support::wall) == static_cast<int>(ObjectInstance::Stands::wall));
  object.support = static_cast<Support>(instance.stands);  // they have the same order
  object.onObject = instance.on;
  return object;
}

std::vector<ObjectInstance> ObjectLayer::instances() const {
  return instances_ ? instances_->instances() : std::vector<ObjectInstance>();
}

std::function<std::vector<ObjectInstance>()> ObjectLayer::finding() const {
  return
      [instances = instances_] { return instances ? instances->instances() : std::vector<ObjectInstance>(); };
}

std::vector<WorldObject> ObjectLayer::put(const std::vector<ObjectInstance>& found, const AreaPlan* plan,
                                          std::span<const std::optional<KnownPose>> known,
                                          std::span<const std::vector<LabelProbability>> shapes) {
  if (!instances_) return {};
  std::map<SegmentPlace, int> objectOf;
  for (std::size_t i = 0; i < found.size(); ++i)
    for (const SegmentPlace& place : found[i].segments) objectOf[place] = static_cast<int>(i);
  struct Sum {
    std::array<double, 3> color{};
    double segments = 0, flat = 0, best = 0;
    std::size_t bestFrame = 0;
  };
  std::vector<Sum> looks(found.size());
  for (const auto& [place, object] : objectOf) {
    const auto seen = looks_.find(place);
    if (seen == looks_.end()) continue;
    Sum& look = looks[static_cast<std::size_t>(object)];
    for (std::size_t c = 0; c < 3; ++c) look.color[c] += seen->second.color[c];
    ++look.segments;
    look.flat += seen->second.flat ? 1 : 0;
    if (seen->second.quality > look.best) {
      look.best = seen->second.quality;
      look.bestFrame = place.first;
    }
  }
  const std::vector<std::vector<double>> words = wordsOf(found, objectOf);
  std::vector<WorldObject> objects;
  for (std::size_t i = 0; i < found.size(); ++i) {
    WorldObject object = worldObject(found[i]);
    object.id = static_cast<int>(i);
    object.known = known[i];
    const Sum& look = looks[i];
    for (std::size_t c = 0; c < 3; ++c)
      object.color[c] = static_cast<int>(std::lround(look.color[c] / std::max(1.0, look.segments)));
    object.flat = look.flat > look.segments / 2;
    if (!object.flat) object.shapeClasses = shapes[i];
    object.bestFrame = look.bestFrame;
    if (plan != nullptr) object.area = areaOfObject(*plan, object.center);
    object.words = bestWords(words[i], vocabulary_);
    objects.push_back(std::move(object));
  }
  const std::vector<int> numbers = applyEdits(store_.objectEdits(), objects);
  for (auto& [place, object] : objectOf) object = numbers[static_cast<std::size_t>(object)];
  std::erase_if(objectOf, [](const auto& segment) { return segment.second < 0; });
  store_.putObjects(objects, objectOf);
  return objects;
}

}  // namespace estancia
