#include "estancia/topology/mapper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estancia/core/error.hpp"

namespace estancia {
namespace {

constexpr std::size_t mostFramesPerKeyframe = 10;  // of a young run, on the average: bounds its memory
constexpr std::size_t firstRescale = 10;           // keyframes before a run can tell anything about itself
constexpr std::uint64_t leastFramesToMerge = 3;    // below this a mean is still one image's accident
constexpr std::size_t mostBlur = 1000;             // images kept in memory for it
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

std::size_t rescaleAfter(std::size_t frames) {
  return frames + frames / 4 + 1;
}

}  // namespace

Mapper::Mapper(const DescriptorLayout& layout, MapperOptions options)
    : labels_(layout.labels()),
      options_(std::move(options)),
      distance_(getDistance(options_.distance, layout.parts)),
      scale_(distance_, labels_, options_.thresholds),
      bank_(distance_, labels_),
      nextRescale_(firstRescale) {
  for (const auto& tau : {options_.tauJoin, options_.tauRevisit})
    if (tau && !(*tau > 0 && std::isfinite(*tau)))
      throw Error(fmt::format("a threshold of {} can never be met; give a positive distance", *tau));
  if (options_.transitionImages > mostBlur)
    throw Error(
        fmt::format("at most {} images can blur a stay, not {}", mostBlur, options_.transitionImages));
  thresholds_ = thresholdsFrom(options_.tauJoin.value_or(distance_.tauJoin), options_.thresholds);
  if (options_.tauRevisit) thresholds_.revisit = *options_.tauRevisit;
}

bool Mapper::isAutomatic() const {
  return distance_.standardized || !options_.tauJoin;
}

int Mapper::currentNode() const {
  return bank_.size() == 0 ? -1 : bank_[current_].id;
}

Mapper::Image Mapper::makeImage(DescriptorView probabilities) const {
  Image image{{probabilities.begin(), probabilities.end()}, std::vector<float>(labels_)};
  embed(distance_.embedding, probabilities, image.embedded, distance_.parts);
  return image;
}

bool Mapper::isWarmingUp() const {
  return isAutomatic() && scale_.keyframes() < options_.warmupFrames &&
         scale_.frames() < mostFramesPerKeyframe * options_.warmupFrames;
}

void Mapper::add(DescriptorView probabilities) {
  requireProbabilities(probabilities, labels_, "the labeler");
  const Image image = makeImage(probabilities);
  const std::size_t frame = scale_.frames();
  const bool young = isWarmingUp();
  scale_.add(image.words, image.embedded);
  if (young) young_.push_back(image.words);
  if (frame == 0 && distance_.standardized) bank_.setStandardization(scale_.standardization());
  place(frame, image);
  if (isAutomatic() && (scale_.keyframes() >= nextRescale_ || young != isWarmingUp())) rescale(young);
}

void Mapper::finish() {
  if (isWarmingUp() && frames() > 1) rescale(true);
}

void Mapper::rescale(bool young) {
  if (scale_.keyframes() >= nextRescale_) nextRescale_ = rescaleAfter(scale_.keyframes());
  bank_.setStandardization(scale_.standardization());
  if (!options_.tauJoin)
    if (const auto found = scale_.estimate(bank_.standardization())) thresholds_ = *found;
  if (options_.tauRevisit) thresholds_.revisit = *options_.tauRevisit;
  if (young) remapWarmup();
  if (!isWarmingUp()) young_ = {};
}

void Mapper::remapWarmup() {
  Standardization standardization = bank_.standardization();
  bank_ = NodeBank(distance_, labels_);
  bank_.setStandardization(std::move(standardization));
  transitions_.clear();
  recent_.clear();
  current_ = 0;
  nextId_ = 0;
  stay_ = 0;
  changes_ = {};
  changes_.restarted = true;
  for (std::size_t frame = 0; frame < young_.size(); ++frame) place(frame, makeImage(young_[frame]));
}

/// The body of Algorithm 4.1's loop, with Min_dist updated and the join case ended, as its text says.
void Mapper::place(std::size_t frame, const Image& image) {
  Decision decision;
  decision.frame = frame;
  decision.toCurrent = decision.toOther = unknown;
  decision.tauJoin = thresholds_.join;
  decision.tauRevisit = thresholds_.revisit;
  decision.current = currentNode();

  if (bank_.size() == 0) {
    decision.kind = DecisionKind::start;
    current_ = createNode();
  } else {
    const std::vector<float> query = bank_.makeQuery(image.embedded);
    decision.toCurrent = bank_.distance(current_, query);
    if (decision.toCurrent < thresholds_.join) {
      decision.kind = DecisionKind::join;
    } else {
      const auto other = bank_.nearest(query, current_);
      if (other) {
        decision.other = bank_[other->slot].id;
        decision.toOther = other->distance;
      }
      const bool near = other && other->distance < thresholds_.revisit;
      leave();
      if (near && (!options_.nearerThanCurrent || other->distance < decision.toCurrent)) {
        decision.kind = DecisionKind::revisit;
        current_ = other->slot;
      } else {
        decision.kind = DecisionKind::createNode;
        current_ = createNode();
      }
      addTransition(decision.current, currentNode(), frame);
    }
  }
  join(current_, image);
  decision.node = currentNode();
  changes_.events.emplace_back(decision);
  mergeDuplicateNodes(frame);
}

std::size_t Mapper::createNode() {
  NodeMemory node = bank_.makeNode(nextId_++);
  node.nextMergeCheck = leastFramesToMerge;
  return bank_.add(std::move(node));
}

void Mapper::join(std::size_t slot, const Image& image) {
  ++stay_;
  const std::size_t k = options_.transitionImages;
  const double weight = k > 0 ? std::min(1.0, static_cast<double>(stay_) / static_cast<double>(k)) : 1.0;
  bank_.update(slot, [&](NodeMemory& node) {
    ++node.frames;
    node.words.add(image.words, weight);
    if (node.embedded) node.embedded->add(image.embedded, weight);
  });
  if (k > 0) {
    recent_.push_back(image);
    if (recent_.size() > k) recent_.pop_front();
  }
  changes_.changedNodes.insert(bank_[slot].id);
}

/// The robot leaves the current node: its last k images get the falling weights they would have had in
/// hindsight.
void Mapper::leave() {
  const std::size_t k = options_.transitionImages;
  bank_.update(current_, [&](NodeMemory& node) {
    for (std::size_t i = 0; i < recent_.size(); ++i) {
      const std::size_t fromStart = stay_ - recent_.size() + i + 1;  // 1 is the stay's first image
      const std::size_t toEnd = recent_.size() - i;                  // 1 is its last
      const double given = std::min(1.0, static_cast<double>(fromStart) / static_cast<double>(k));
      const double due = std::min(given, static_cast<double>(toEnd) / static_cast<double>(k));
      if (due >= given || node.words.weight() - (given - due) <= 0) continue;
      node.words.add(recent_[i].words, due - given);
      if (node.embedded) node.embedded->add(recent_[i].embedded, due - given);
    }
  });
  changes_.changedNodes.insert(bank_[current_].id);
  recent_.clear();
  stay_ = 0;
}

void Mapper::addTransition(int from, int to, std::size_t frame) {
  Transition& transition = transitions_.try_emplace({from, to}, Transition{from, to, 0, frame}).first->second;
  ++transition.count;
  changes_.changedTransitions.insert({from, to});
}

/// Two nodes whose means have come close are one place: the older one keeps its name.
void Mapper::mergeDuplicateNodes(std::size_t frame) {
  const NodeMemory& node = bank_[current_];
  if (thresholds_.merge <= 0 || node.frames < node.nextMergeCheck) return;
  bank_.update(current_,
               [](NodeMemory& n) { n.nextMergeCheck = n.frames + std::max<std::uint64_t>(1, n.frames / 4); });
  const std::vector<float> query = bank_.makeQuery(node.compared().mean());
  const auto twin = bank_.nearest(query, current_, leastFramesToMerge);
  if (!twin || twin->distance >= thresholds_.merge) return;

  const std::size_t kept = bank_[twin->slot].id < node.id ? twin->slot : current_;
  const std::size_t absorbed = kept == current_ ? twin->slot : current_;
  const int keptId = bank_[kept].id, absorbedId = bank_[absorbed].id;
  bank_.update(kept, [&](NodeMemory& n) {
    const NodeMemory& other = bank_[absorbed];
    n.frames += other.frames;
    n.words.merge(other.words);
    if (n.embedded) n.embedded->merge(*other.embedded);
    n.nextMergeCheck = n.frames + std::max<std::uint64_t>(1, n.frames / 4);
  });
  bank_.remove(absorbed);
  current_ = bank_.slotOf(keptId);

  std::map<std::pair<int, int>, Transition> redirected;
  for (const auto& [ends, transition] : transitions_) {
    const int from = ends.first == absorbedId ? keptId : ends.first;
    const int to = ends.second == absorbedId ? keptId : ends.second;
    if (from == to) continue;
    Transition& target =
        redirected.try_emplace({from, to}, Transition{from, to, 0, transition.firstFrame}).first->second;
    target.count += transition.count;
    target.firstFrame = std::min(target.firstFrame, transition.firstFrame);
  }
  transitions_ = std::move(redirected);
  changes_.redirected = true;
  changes_.events.emplace_back(Merge{frame, keptId, absorbedId, twin->distance, thresholds_.merge});
  changes_.changedNodes.erase(absorbedId);
  changes_.changedNodes.insert(keptId);
}

Mapper::MapChanges Mapper::takeChanges() {
  return std::exchange(changes_, {});
}

}  // namespace estancia
