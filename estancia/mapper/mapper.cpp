// SPDX-License-Identifier: Apache-2.0

#include <algorithm>

#include "estancia/distances/distance.hpp"
#include "estancia/mapper/mapper_impl.hpp"

namespace estancia {
namespace {

constexpr std::size_t maxFramesPerKeyframe = 10;   // average over a warm-up: bounds its memory
constexpr std::size_t firstEstimate = 10;          // keyframes before anything can be estimated
constexpr std::uint64_t minFramesToMerge = 3;      // the mean of fewer frames is still accidental
constexpr std::size_t maxTransitionImages = 1000;  // they are kept in memory
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

std::size_t nextEstimateAfter(std::size_t keyframes) {
  return keyframes + keyframes / 4 + 1;
}

Thresholds initialThresholds(const MapperOptions& options, const ThresholdEstimator& scale) {
  validate(options);
  Thresholds thresholds =
      options.tauJoin ? thresholdsFrom(*options.tauJoin, options.thresholds) : scale.initial();
  if (options.tauRevisit) thresholds.revisit = *options.tauRevisit;
  return thresholds;
}

/// Line 20 of Algorithm 4.1, with the original program's further condition. A drive begins far from any node.
bool isRevisit(const Decision& decision) {
  return decision.other >= 0 && decision.toOther < decision.tauRevisit &&
         (decision.current < 0 || decision.toOther < decision.toCurrent);
}

}  // namespace

OptionGroup declare(ThresholdOptions& options) {
  OptionGroup group("thresholds", "How the thresholds are estimated from the run itself.");
  group.add("far-quantile", &options.farQuantile, "Share of the pairs of different places within tau-join.")
      .range(0, 1)
      .why("A larger share gives fewer, larger places.");
  group.add("revisit-ratio", &options.revisitRatio, "tau-revisit / tau-join.")
      .range(0)
      .why("A smaller ratio needs more evidence before an earlier place is recognized.");
  group.add("merge-ratio", &options.mergeRatio, "tau-merge / tau-join, between the means of two nodes.")
      .range(0)
      .why("0 never merges nodes.");
  return group;
}

OptionGroup declare(MapperOptions& options) {
  OptionGroup group("mapper", "How frames become places.");
  group.add("distance", &options.distance, "Distance of a frame to a node.").choices(distances());
  group.add("tau-join", &options.tauJoin, "A frame within this distance stays in the current node.")
      .above(0)
      .automatic("estimated from the run")
      .why("A larger distance gives fewer, larger places.");
  group
      .add("tau-revisit", &options.tauRevisit,
           "A frame within this distance of another node returns to that node.")
      .above(0)
      .automatic("revisit-ratio times tau-join")
      .why("A smaller distance recognizes fewer places again.");
  group
      .add("views", &options.views,
           "Images kept in all of the places, to recognize these from another side and by poses.")
      .unit("images")
      .why("0: places are recognized by their means alone.");
  group.add("near-distance", &options.nearDistance, "Frames this far apart can show the same place.")
      .unit("m")
      .above(0)
      .why("Views change over a shorter way in narrow rooms than in halls and streets.");
  group
      .add("near-angle", &options.nearAngle,
           "Frames whose directions differ by this can show the same place.")
      .unit("degrees")
      .above(0)
      .why("A wide field of view allows more.");
  group
      .add("transition-images", &options.transitionImages,
           "The first and last K frames of a node weigh 0, 1/K, … in it.")
      .range(0, static_cast<double>(maxTransitionImages))
      .unit("frames")
      .why("Frames between two places show both of them.");
  group
      .add("warmup-frames", &options.warmupFrames,
           "These first keyframes are remapped each time the thresholds are estimated again.")
      .unit("keyframes")
      .why("A longer warm-up costs memory, and nodes may change for longer.");
  group.add(declare(options.thresholds));
  return group;
}

MapperOptions MapperOptions::thesis() {
  MapperOptions options;
  options.distance = "weighted-root";
  options.tauJoin = 0.015;
  options.tauRevisit = 0.0015;
  options.transitionImages = 15;
  options.views = 0;
  options.thresholds.mergeRatio = 0;
  return options;
}

Mapper::Impl::Impl(const DescriptorLayout& layout, const MapperOptions& chosen, LabelPrior known)
    : labels(layout.labels()),
      options(chosen),
      distance(getDistance(options.distance, layout.parts)),
      prior(std::move(known)),
      scale(distance, labels, options.thresholds, prior),
      bank(distance, labels),
      views(distance, labels, options),
      thresholds(initialThresholds(options, scale)),
      nextEstimate(firstEstimate) {}

bool Mapper::Impl::isWarmingUp() const {
  return isFirstDrive && isAutomatic() && scale.keyframes() < options.warmupFrames &&
         scale.frames() < maxFramesPerKeyframe * options.warmupFrames;
}

Mapper::Impl::FrameDescriptor Mapper::Impl::embeddedFrame(DescriptorView probabilities) const {
  FrameDescriptor descriptor{{probabilities.begin(), probabilities.end()}, std::vector<float>(labels)};
  embed(distance.embedding, probabilities, descriptor.embedded, distance.parts);
  return descriptor;
}

/// The prior's statistics of labels are those of whole distributions; its distances hold for best labels,
/// too.
void Mapper::Impl::forgetLabelStatistics() {
  prior.center.clear();
  prior.variance.clear();
  scale = ThresholdEstimator(distance, labels, options.thresholds, prior);
}

void Mapper::Impl::add(DescriptorView probabilities, const std::optional<Pose>& pose,
                       const std::optional<int>& guess) {
  requireProbabilities(probabilities, labels, "the labeler");
  const FrameDescriptor descriptor = embeddedFrame(probabilities);
  const std::size_t frame = scale.frames();
  if (frame == 0 && missingProbability(probabilities) > 0) forgetLabelStatistics();
  if (std::exchange(isBack, false)) lost.reset();
  const bool warmingUp = isWarmingUp();
  const bool isKeyframe = scale.add(descriptor.probabilities, descriptor.embedded);
  if (lost && isKeyframe) lost->add(descriptor.embedded);
  if (warmingUp) warmup.push_back({descriptor.probabilities, pose});
  if (frame == 0 && distance.standardized) setStandardization();
  place(frame, descriptor, pose, guess);
  if (isAutomatic() && (scale.keyframes() >= nextEstimate || warmingUp != isWarmingUp()))
    estimateScales(warmingUp);
}

void Mapper::Impl::replay(DescriptorView probabilities, const Decision& known) {
  requireProbabilities(probabilities, labels, "the labeler");
  isFirstDrive = false;
  const FrameDescriptor descriptor = embeddedFrame(probabilities);
  scale.add(descriptor.probabilities, descriptor.embedded);
  changes.events.emplace_back(known);
}

void Mapper::Impl::beginDrive() {
  if (scale.frames() == 0) return;
  finish();
  current.reset();
  endModes();
  absorbedBy.clear();
  lostNode.reset();
  isFirstDrive = false;
  warmup = {};
  views.beginDrive(scale.frames());
  getLost();
}

/// Means within τ_merge are one, of modes as of places.
void Mapper::Impl::endModes() {
  for (const int id : bank.endDrive(thresholds.merge, minFramesToMerge)) changes.changedNodes.insert(id);
  if (thresholds.merge <= 0 || (bank.rows() > bank.size() && isFull())) forgetModes();
}

NodeBank Mapper::Impl::bankAtRest() const {
  NodeBank rest = bank;
  if (thresholds.merge > 0) rest.endDrive(thresholds.merge, minFramesToMerge);
  return rest;
}

void Mapper::Impl::estimateScales(bool warmingUp) {
  if (scale.keyframes() >= nextEstimate) nextEstimate = nextEstimateAfter(scale.keyframes());
  setStandardization();
  if (!options.tauJoin)
    if (const auto found = scale.estimate(bank.standardization())) thresholds = *found;
  if (options.tauRevisit) thresholds.revisit = *options.tauRevisit;
  if (warmingUp) remapWarmup();
  if (!isWarmingUp()) warmup = {};
}

void Mapper::Impl::setStandardization() {
  bank.setStandardization(scale.standardization());
  views.rescale([this](std::span<const float> embedded) { return bank.compared(embedded); });
}

void Mapper::Impl::remapWarmup() {
  Standardization standardization = bank.standardization();
  bank = NodeBank(distance, labels);
  bank.setStandardization(std::move(standardization));
  views.clear();
  transitions.clear();
  current.reset();
  nextId = 0;
  changes = {};
  changes.restarted = true;
  for (std::size_t frame = 0; frame < warmup.size(); ++frame)
    place(frame, embeddedFrame(warmup[frame].probabilities), warmup[frame].pose);
}

/// The loop body of Algorithm 4.1 (thesis 4.4) for one image.
void Mapper::Impl::place(std::size_t frame, const FrameDescriptor& descriptor,
                         const std::optional<Pose>& pose, const std::optional<int>& guess) {
  Decision decision{.frame = frame,
                    .current = currentNode(),
                    .toCurrent = unknown,
                    .toOther = unknown,
                    .tauJoin = thresholds.join,
                    .tauRevisit = thresholds.revisit};
  PlaceView seen{frame, -1, frame, pose, descriptor.embedded, bank.compared(descriptor.embedded)};
  if (bank.size() > 0) decide(seen, guess, decision);  // else line 2: DecisionKind::start
  if (lost) stayLost(seen, decision);
  const bool isNew = decision.kind == DecisionKind::start || decision.kind == DecisionKind::createNode;
  const int next = decision.kind == DecisionKind::join ? decision.current : decision.other;
  absorbLostNode(next, decision);
  if (isNew && isFull()) makeRoom(frame);
  if (isNew || next != currentNode()) {
    current = isNew ? createNode() : bank.slotOf(next);  // lines 3–5, 25, 26 and 28; line 22
    if (decision.current >= 0) ++transition(decision.current, currentNode(), frame).count;  // lines 21 and 27
    lostNode.reset();
    if (decision.kind == DecisionKind::start && !isFirstDrive) lostNode = currentNode();
  }
  join(*current, frame, descriptor);  // lines 8 and 23: Eq. 4.3 and 4.4
  decision.node = seen.node = currentNode();
  if (views.isOn()) views.keep(std::move(seen), thresholds);
  changes.events.emplace_back(decision);
  mergeDuplicateNodes(frame);
}

/// Following the thesis' text, not the printed algorithm, a nearer node updates Min_dist (line 14), and an
/// image that joins the current node (line 8) is done. Unlike in the thesis, single views are compared first.
void Mapper::Impl::decide(const PlaceView& seen, const std::optional<int>& guess, Decision& decision) {
  if (current) decision.toCurrent = bank.distance(*current, seen.compared);  // Eq. 4.5, or another distance
  const bool isRecognizedByViews = isRecognized(seen, decision);             // remembers what was seen
  if (isLocalized(seen, guess, decision) || isRecognizedByViews) return;
  decision.kind = DecisionKind::join;
  if (current && decision.toCurrent < thresholds.join && !views.isElsewhere(decision.current, seen.pose))
    return;                                                                         // line 7
  const auto similar = bank.nearest(seen.compared, current.value_or(bank.size()));  // lines 10–17
  if (similar) {
    decision.other = bank[similar->slot].id;
    decision.toOther = similar->distance;
  }
  decision.kind = isRevisit(decision) && !views.isElsewhere(decision.other, seen.pose)
                      ? DecisionKind::revisit  // line 20
                  : current ? DecisionKind::createNode
                            : DecisionKind::start;
}

/// Whether the frames of the drive localize the robot and its words do not contradict.
bool Mapper::Impl::isLocalized(const PlaceView& seen, const std::optional<int>& guess,
                               Decision& decision) const {
  if (!guess) return false;
  int node = *guess;
  for (auto next = absorbedBy.find(node); next != absorbedBy.end(); next = absorbedBy.find(node))
    node = next->second;
  const double away =
      std::min(bank.distance(bank.slotOf(node), seen.compared), views.nearestOf(node, seen.compared));
  if (away >= thresholds.join || views.isElsewhere(node, seen.pose)) return false;
  decision.kind = DecisionKind::localize;
  decision.other = node;
  decision.toOther = away;
  decision.tauRevisit = thresholds.join;
  return true;
}

/// Whether the image shows a place from a side from which it has been seen before.
bool Mapper::Impl::isRecognized(const PlaceView& seen, Decision& decision) {
  if (!views.isOn()) return false;
  const auto found = views.recognize(seen, decision.current, thresholds);
  if (!found) return false;
  if (found->byPose && lost && !lost->isOwn(found->node)) lost.reset();
  const bool stays = found->node == decision.current;
  if (!stays && !found->byPose && found->distance >= decision.toCurrent) return false;
  decision.kind = stays ? DecisionKind::join : DecisionKind::revisit;
  if (stays && decision.toCurrent < thresholds.join) return true;
  decision.other = found->node;
  decision.toOther = found->distance;
  decision.tauRevisit = found->threshold;
  return true;
}

/// A frame that lies in the lost robot's node and is recognized in another one shows that both are one place.
void Mapper::Impl::absorbLostNode(int next, const Decision& decision) {
  if (!lostNode || decision.current != *lostNode || next == *lostNode || next < 0) return;
  if (decision.kind != DecisionKind::localize && decision.kind != DecisionKind::revisit) return;
  if (decision.toCurrent >= thresholds.join) return;
  merge(bank.slotOf(next), *current, {decision.frame, next, *lostNode, decision.toCurrent, thresholds.join});
}

std::size_t Mapper::Impl::createNode() {
  NodeMemory node = bank.makeNode(nextId++);
  node.nextMergeCheck = minFramesToMerge;
  return bank.add(std::move(node));
}

void Mapper::Impl::join(std::size_t slot, std::size_t frame, const FrameDescriptor& descriptor) {
  bank.update(slot, [&](NodeMemory& node) {
    if (hasModes()) {
      if (!node.own) node.own.emplace(labels, false);
      node.own->add(descriptor.embedded);
    }
    const auto change = [&node](const auto& image, double weight) {
      node.probabilities.add(image.probabilities, weight);
      if (node.embedded) node.embedded->add(image.embedded, weight);
    };
    const std::uint64_t before = node.frames++;
    if (options.transitionImages == 0)
      change(descriptor, 1);
    else
      node.border.add({frame, descriptor.probabilities, descriptor.embedded}, before,
                      options.transitionImages, change);
  });
  changes.changedNodes.insert(bank[slot].id);
}

Transition& Mapper::Impl::transition(int from, int to, std::size_t frame) {
  changes.changedTransitions.insert({from, to});
  return transitions.try_emplace({from, to}, Transition{from, to, 0, frame}).first->second;
}

/// Two nodes whose means have come close are one place: the older one keeps its id.
void Mapper::Impl::mergeDuplicateNodes(std::size_t frame) {
  const NodeMemory& node = bank[*current];
  if (thresholds.merge <= 0 || node.frames < node.nextMergeCheck) return;
  bank.update(*current, [](NodeMemory& n) { n.setNextMergeCheck(); });
  const auto duplicate = bank.nearest(bank.mean(*current), *current, minFramesToMerge);
  if (!duplicate || duplicate->distance >= thresholds.merge) return;
  const int other = bank[duplicate->slot].id;
  if (views.areApart(other, node.id) || !mayBeOne(node.id, other)) return;
  const std::size_t kept = other < node.id ? duplicate->slot : *current;
  const std::size_t gone = kept == *current ? duplicate->slot : *current;
  merge(kept, gone, {frame, bank[kept].id, bank[gone].id, duplicate->distance, thresholds.merge});
}

void Mapper::Impl::merge(std::size_t kept, std::size_t gone, const Merge& why) {
  const int here = currentNode();
  bank.update(kept, [&](NodeMemory& n) { n.merge(bank[gone]); });
  bank.joinModes(kept, thresholds.merge, minFramesToMerge);
  bank.remove(gone);
  if (current) current = bank.slotOf(here == why.absorbed ? why.kept : here);
  if (!isFirstDrive) absorbedBy[why.absorbed] = why.kept;
  if (lostNode == why.absorbed || lostNode == why.kept) lostNode.reset();
  redirectTransitions(why.absorbed, why.kept);
  views.merge(why.absorbed, why.kept);
  changes.events.emplace_back(why);
  changes.changedNodes.erase(why.absorbed);
  changes.changedNodes.insert(why.kept);
}

void Mapper::Impl::redirectTransitions(int absorbed, int kept) {
  std::vector<Transition> moved;
  std::erase_if(transitions, [&](const auto& entry) {
    const bool isMoved = entry.first.first == absorbed || entry.first.second == absorbed;
    if (isMoved) moved.push_back(entry.second);
    if (isMoved) changes.changedTransitions.insert(entry.first);
    return isMoved;
  });
  for (const Transition& old : moved) {
    const int from = old.from == absorbed ? kept : old.from, to = old.to == absorbed ? kept : old.to;
    if (from == to) continue;
    Transition& target = transition(from, to, old.firstFrame);
    target.count += old.count;
    target.firstFrame = std::min(target.firstFrame, old.firstFrame);
  }
}

Mapper::Mapper(const DescriptorLayout& layout, const MapperOptions& options)
    : impl_(std::make_unique<Impl>(layout, options, unknownLabelsPrior(layout.labels()))) {}
Mapper::Mapper(const Vocabulary& vocabulary, const MapperOptions& options)
    : impl_(std::make_unique<Impl>(vocabulary.layout(), options, labelPriorOf(vocabulary))) {}
Mapper::Mapper(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;
Mapper::~Mapper() = default;

int Mapper::add(DescriptorView descriptor, const std::optional<Pose>& pose, const std::optional<int>& guess) {
  impl_->add(descriptor, pose && pose->isPlausible() ? pose : std::nullopt, guess);
  return currentNode();
}

void Mapper::beginDrive() {
  impl_->beginDrive();
}

void Mapper::movePoses(const std::function<std::optional<Pose>(std::size_t)>& pose) {
  const auto plausible = [&pose](std::size_t frame) {
    const std::optional<Pose> now = pose(frame);
    return now && now->isPlausible() ? now : std::nullopt;
  };
  impl_->views.movePoses(plausible);
  for (std::size_t i = 0; i < impl_->warmup.size(); ++i) impl_->warmup[i].pose = plausible(i);
}

void Mapper::finish() {
  impl_->finish();
}

void Mapper::setMemory(const std::optional<std::uint64_t>& bytes) {
  impl_->setMemory(bytes);
}

std::size_t Mapper::frames() const {
  return impl_->scale.frames();
}

std::size_t Mapper::nodes() const {
  return impl_->bank.size();
}

const MapperOptions& Mapper::options() const {
  return impl_->options;
}

const Thresholds& Mapper::thresholds() const {
  return impl_->thresholds;
}

int Mapper::currentNode() const {
  return impl_->currentNode();
}

const std::map<std::pair<int, int>, Transition>& Mapper::transitions() const {
  return impl_->transitions;
}

MapChanges Mapper::takeChanges() {
  return std::exchange(impl_->changes, {});
}

}  // namespace estancia
