// SPDX-License-Identifier: Apache-2.0
#include "estancia/layers/known_layer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {
namespace {

/// The best views of an instance, in which a known object is looked for.
constexpr std::size_t maxTries = 3;
/// Views that a pose is verified by.
constexpr std::size_t maxWitnesses = 7;
/// Confidence with which an instance is a model: see recognized(). Chosen on one drive of a made-up home, and
/// checked on another.
constexpr double minConfidence = 0.8;
/// What may be two models, whose confidences differ by less, is neither.
constexpr double apart = 0.05;
/// Poses of a view that are verified.
constexpr std::size_t maxPoses = 6;
/// A model that is seen from farther round shows another side, which its cloud may not have [cosine].
constexpr double sameSide = 0.5;
/// Range of the ratio of an instance's diagonal to a model's: box axes differ, and a side may be unseen.
constexpr double smallest = 0.55, largest = 1.35;

double diagonalOf(const ObjectInstance& instance) {
  return cv::norm(instance.box.size);
}

double middleOf(std::vector<double> values) {  // the lower one of two
  std::ranges::sort(values);
  return values.empty() ? 0 : values[(values.size() - 1) / 2];
}

}  // namespace

void KnownLayer::recognize(std::shared_ptr<const KnownObjects> objects) {
  objects_ = std::move(objects);
  for (const KnownObjects::Model& model : objects_->models()) store_.begin(model.name, model.digest);
}

std::vector<std::optional<KnownPose>> KnownLayer::find(std::span<const ObjectInstance> instances,
                                                       const FramePoses& poses, const Floor& floor) {
  std::multimap<SegmentPlace, SegmentRecognition> kept = store_.recognitions();
  try {
    if (objects_ != nullptr) search(instances, poses, floor, kept);
  } catch (const Interrupted&) {  // Ctrl-C ended the mapping: --continue looks for the rest
  }
  std::vector<std::optional<KnownPose>> known(instances.size());
  for (std::size_t i = 0; i < instances.size(); ++i) {
    std::map<std::string, double> confidences;  // how far each model agrees
    for (const SegmentPlace& place : instances[i].segments) {
      if (!poses[place.first]) continue;
      const auto [begin, end] = kept.equal_range(place);
      for (auto found = begin; found != end; ++found) {
        const SegmentRecognition& recognition = found->second;
        double& confidence = confidences[recognition.name];
        confidence = std::max(confidence, recognition.confidence);
        if (!recognition.pose || (known[i] && known[i]->confidence >= recognition.confidence)) continue;
        known[i] = {recognition.name, recognition.confidence,
                    poseOf(rigidOf(*poses[place.first]) * rigidOf(*recognition.pose)), place.first};
      }
    }
    if (known[i] && std::ranges::any_of(confidences, [&](const auto& other) {
          return other.first != known[i]->name && other.second > known[i]->confidence - apart;
        }))
      known[i].reset();
  }
  return known;
}

/// Looks for each known object in the best views of each instance that can be it.
void KnownLayer::search(std::span<const ObjectInstance> instances, const FramePoses& poses,
                        const Floor& floor, std::multimap<SegmentPlace, SegmentRecognition>& kept) {
  const auto mayBe = [](const ObjectInstance& instance, const KnownObjects::Model& model) {
    const double ratio = diagonalOf(instance) / model.extent;
    return ratio >= smallest && ratio <= largest;
  };
  const std::vector<std::vector<InstanceView>> views =
      bestViews(observations_, instances, poses, maxWitnesses, [&](std::size_t i, const auto&) {
        return std::ranges::any_of(objects_->models(),
                                   [&](const auto& model) { return mayBe(instances[i], model); });
      });
  for (std::size_t i = 0; i < instances.size(); ++i) {
    std::vector<KnownWitness> witnesses;  // loaded when they are needed
    for (const KnownObjects::Model& model : objects_->models()) {
      if (!mayBe(instances[i], model)) continue;
      std::size_t tries = 0;
      for (const SegmentPlace& place : instances[i].segments) {
        const auto [begin, end] = kept.equal_range(place);
        for (auto found = begin; found != end; ++found)
          if (found->second.name == model.name) tries += found->second.pose ? maxTries : 1;
      }
      for (std::size_t v = 0; v < views[i].size() && tries < maxTries; ++v) {
        if (interrupted()) throw Interrupted("stopped while objects were recognized");
        const SegmentPlace& place = views[i][v].place;
        const auto [begin, end] = kept.equal_range(place);
        if (std::any_of(begin, end, [&](const auto& found) { return found.second.name == model.name; }))
          continue;
        if (witnesses.empty()) witnesses = load(views[i], poses, floor.point(instances[i].box.center));
        const SegmentRecognition recognition = recognized(model, witnesses[v], witnesses, poses);
        store_.put(place, recognition);
        kept.emplace(place, recognition);
        tries += recognition.pose ? maxTries : 1;
      }
    }
  }
}

/// Loads the witnesses of one instance only, to bound memory.
std::vector<KnownWitness> KnownLayer::load(const std::vector<InstanceView>& views, const FramePoses& poses,
                                           const cv::Vec3d& center) const {
  std::vector<KnownWitness> witnesses;
  for (const InstanceView& view : views) {
    const Observation seen = observations_.observation(view.place.first);
    const Pose& from = *poses[view.place.first];
    witnesses.push_back({view.place, cv::normalize(cv::Vec3d(from.x, from.y, from.z) - center), depthOf(seen),
                         seen.segments == static_cast<int>(view.place.second), seen.camera});
  }
  return witnesses;
}

/// In a view, and verified by all. The confidence is the geometric mean of three shares: of what is seen of
/// the model, that which is where something was measured, and not in free space; of the segments from that
/// side, that which the model explains; of the model, that which any view confirms, or a planar side would be
/// like any board.
SegmentRecognition KnownLayer::recognized(const KnownObjects::Model& model, const KnownWitness& view,
                                          const std::vector<KnownWitness>& views,
                                          const FramePoses& poses) const {
  SegmentRecognition best{model.name};
  const cv::Affine3d here = rigidOf(*poses[view.place.first]);
  std::vector<cv::Affine3d> found = objects_->find(model, view.depth, view.segment, view.camera);
  found.resize(std::min(found.size(), maxPoses));
  for (const cv::Affine3d& pose : found) {
    std::vector<double> explained;
    std::vector<std::uint8_t> seen(model.points.size());
    double same = 0, before = 0;
    for (const KnownWitness& witness : views) {
      const ViewAgreement agreement =
          agreementIn(model, rigidOf(*poses[witness.place.first]).inv() * here * pose, witness.depth,
                      witness.segment, witness.camera, &seen);
      same += agreement.same;
      before += agreement.before;
      if (witness.direction.dot(view.direction) >= sameSide)
        explained.push_back(agreement.inside / std::max(1.0, agreement.segment));
    }
    if (same == 0) continue;
    const double confirmed =
        static_cast<double>(std::ranges::count(seen, 1)) / static_cast<double>(seen.size());
    const double confidence = std::cbrt(same / (same + before) * middleOf(std::move(explained)) * confirmed);
    if (confidence <= best.confidence) continue;
    best.confidence = confidence;
    best.pose.reset();
    if (confidence >= minConfidence) best.pose = poseOf(pose);
  }
  return best;
}

}  // namespace estancia
