// State of the mapper in the map file, so that a run can go on where it stopped.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/removed_options.hpp"
#include "estancia/files/files.hpp"
#include "estancia/mapper/mapper_impl.hpp"

namespace estancia {
namespace {

ByteReader readerOf(std::string_view bytes) {
  return {bytes, "the saved state of the mapper is damaged", "map the sequence again"};
}

void requireEnd(const ByteReader& in) {
  if (in.remaining() > 0) in.fail("it is too long", ErrorCode::corruptFile);
}

/// Size of a transition in states written by older versions [bytes].
constexpr std::size_t transitionBytes = 2 * sizeof(std::int32_t) + 2 * sizeof(std::uint64_t);

void write(ByteWriter& out, const ThresholdEstimator::Memory& memory) {
  for (const std::uint64_t number : {memory.frames, memory.keyframes, memory.views, memory.lastView,
                                     memory.repeats, memory.sampled.size()})
    out.number(number);
  for (const auto& [keyframe, frame] : memory.sampled) {
    out.number<std::uint64_t>(keyframe);
    out.number<std::uint64_t>(frame);
  }
}

ThresholdEstimator::Memory readMemory(ByteReader& in) {
  ThresholdEstimator::Memory memory;
  for (std::size_t* number :
       {&memory.frames, &memory.keyframes, &memory.views, &memory.lastView, &memory.repeats})
    *number = in.number<std::uint64_t>();
  for (std::size_t count = in.count(2 * sizeof(std::uint64_t)); count > 0; --count) {
    const auto keyframe = in.number<std::uint64_t>();
    memory.sampled.emplace(keyframe, in.number<std::uint64_t>());
  }
  return memory;
}

Moments readMoments(ByteReader& in, std::size_t labels, bool spread) {
  return Moments::fromBytes(in.raw(Moments::byteCount(labels, spread)), labels, spread);
}

/// `maxBorder`: images that a node can keep.
NodeMemory readNode(const NodeBank& bank, int id, const std::string& bytes, std::size_t labels, bool spread,
                    std::size_t frames, std::size_t maxBorder) {
  ByteReader in = readerOf(bytes);
  NodeMemory node = bank.makeNode(id);
  node.frames = in.number<std::uint64_t>();
  if (node.frames > frames) in.fail("a node has more frames than the map", ErrorCode::corruptFile);
  node.nextMergeCheck = in.number<std::uint64_t>();
  node.probabilities = readMoments(in, labels, true);
  if (node.embedded) node.embedded = readMoments(in, labels, spread);
  if (in.remaining() > 0) {  // none: of a first drive, or of an older program
    const bool hasOwn = in.number<std::uint8_t>() != 0;
    std::size_t count = in.count(Moments::byteCount(labels, false));
    if (count > 2 * NodeMemory::maxModes) in.fail("a node has too many modes", ErrorCode::corruptFile);
    for (; count > 0; --count) node.modes.push_back(readMoments(in, labels, false));
    if (hasOwn) node.own = readMoments(in, labels, false);
  }
  if (in.remaining() > 0) {
    std::size_t count = in.count(sizeof(std::uint64_t));
    if (count > maxBorder) in.fail("a node has too many images at its ends", ErrorCode::corruptFile);
    for (; count > 0; --count) {
      const auto frame = in.number<std::uint64_t>();
      if (frame >= frames) in.fail("a node has an image that the map does not have", ErrorCode::corruptFile);
      node.border.images.push_back({frame, {}, {}});
    }
  }
  requireEnd(in);
  return node;
}

/// Fills in the descriptors of images that a state has by their numbers.
void describe(NodeBorder& border, const Mapper::Impl& mapper,
              const std::function<LexicalDescriptor(std::size_t)>& descriptor) {
  for (NodeBorder::Image& image : border.images) {
    Mapper::Impl::FrameDescriptor seen = mapper.embeddedFrame(descriptor(image.frame));
    image = {image.frame, std::move(seen.probabilities), std::move(seen.embedded)};
  }
}

/// Absorbed node → absorbing node; the chains have no cycle.
std::map<int, int> readAbsorbed(ByteReader& in) {
  std::map<int, int> absorbedBy;
  for (std::size_t count = in.count(2 * sizeof(std::int32_t)); count > 0; --count) {
    const auto gone = in.number<std::int32_t>();
    absorbedBy[gone] = in.number<std::int32_t>();
  }
  for (const auto& entry : absorbedBy) {
    std::size_t steps = 0;
    for (auto next = absorbedBy.find(entry.second); next != absorbedBy.end();
         next = absorbedBy.find(next->second))
      if (++steps > absorbedBy.size()) in.fail("a node was absorbed by itself", ErrorCode::corruptFile);
  }
  return absorbedBy;
}

/// Reads the state of a further drive.
void readDrive(ByteReader& in, std::size_t frames, Mapper::Impl& mapper) {
  if (const auto lost = in.number<std::int32_t>(); lost >= 0) mapper.lostNode = lost;
  mapper.absorbedBy = readAbsorbed(in);
  if (in.remaining() == 0) return;  // file of an older program
  mapper.hadOtherScales = in.number<std::uint8_t>() != 0;
  mapper.firstOfDrive = in.number<std::int32_t>();
  if (in.remaining() > 0) mapper.lost = LostDrive::from(in, mapper.labels, frames, mapper.nextId);
}

}  // namespace

std::string settingsToJson(const MapperOptions& options) {
  nlohmann::json json{
      {"distance", options.distance},
      {"nearer_than_current", true},  // always, as the ratios of views: older programs look for them
      {"transition_images", options.transitionImages},
      {"warmup_frames", options.warmupFrames},
      {"far_quantile", options.thresholds.farQuantile},
      {"revisit_ratio", options.thresholds.revisitRatio},
      {"merge_ratio", options.thresholds.mergeRatio},
      {"view_ratio", 0.3},
      {"sequence_ratio", 0.5},
      {"views", options.views},
      {"near_distance", options.nearDistance},
      {"near_angle", options.nearAngle}};
  if (options.tauJoin) json["tau_join"] = *options.tauJoin;
  if (options.tauRevisit) json["tau_revisit"] = *options.tauRevisit;
  return json.dump();
}

MapperOptions settingsFromJson(const std::string& text) {
  try {
    const auto json = nlohmann::json::parse(text);
    MapperOptions options;
    options.distance = printable(json.at("distance").get<std::string>());
    json.at("transition_images").get_to(options.transitionImages);
    json.at("warmup_frames").get_to(options.warmupFrames);
    json.at("far_quantile").get_to(options.thresholds.farQuantile);
    json.at("revisit_ratio").get_to(options.thresholds.revisitRatio);
    json.at("merge_ratio").get_to(options.thresholds.mergeRatio);
    options.views = 0;  // map made before views were kept
    if (json.contains("views")) {
      json["views"].get_to(options.views);
      json.at("near_distance").get_to(options.nearDistance);
      json.at("near_angle").get_to(options.nearAngle);
    }
    if (json.contains("tau_join")) options.tauJoin = json["tau_join"].get<double>();
    if (json.contains("tau_revisit")) options.tauRevisit = json["tau_revisit"].get<double>();
    return options;
  } catch (const nlohmann::json::exception& e) {
    fail(ErrorCode::corruptFile, "the settings of the map cannot be read ({}); map the sequence again",
         io::jsonProblem(e));
  }
}

std::vector<std::string> goneSettings(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  std::vector<std::string> sentences;
  for (const std::string path :
       {"mapper.nearer-than-current", "mapper.thresholds.view-ratio", "mapper.thresholds.sequence-ratio"}) {
    const RemovedOption& option = *findRemovedOption(path);
    std::string key = path.substr(path.rfind('.') + 1);
    std::ranges::replace(key, '-', '_');
    if (json.is_object() && json.contains(key) && json[key].dump() != option.value)
      sentences.push_back(describeRemoved(option, path, json[key].dump()));
  }
  return sentences;
}

std::string Mapper::Impl::state() const {
  ByteWriter out;
  write(out, scale.memory());
  out.number<std::uint64_t>(nextEstimate);
  out.number<std::int32_t>(currentNode());
  out.number<std::int32_t>(nextId);
  out.number<std::uint64_t>(0);  // length of the stay, which older programs kept here
  for (const double threshold : {thresholds.join, thresholds.revisit, thresholds.merge})
    out.number(threshold);
  out.numbers(bank.standardization().center);
  out.numbers(bank.standardization().weight);
  out.raw(scale.moments().toBytes());
  out.number<std::uint64_t>(0);  // transitions, which older programs kept here, too
  if (isFirstDrive) return out.bytes();
  out.number<std::int32_t>(lostNode.value_or(-1));
  out.number<std::uint64_t>(absorbedBy.size());
  for (const auto& [gone, kept] : absorbedBy) {
    out.number<std::int32_t>(gone);
    out.number<std::int32_t>(kept);
  }
  out.number<std::uint8_t>(hadOtherScales ? 1 : 0);
  out.number<std::int32_t>(firstOfDrive);
  if (lost) out.raw(lost->toBytes());
  return out.bytes();
}

std::string Mapper::Impl::nodeState(std::size_t slot) const {
  const NodeMemory& node = bank[slot];
  ByteWriter out;
  out.number<std::uint64_t>(node.frames);
  out.number<std::uint64_t>(node.nextMergeCheck);
  out.raw(node.probabilities.toBytes());
  if (node.embedded) out.raw(node.embedded->toBytes());
  if (node.modes.empty() && !node.own && node.border.images.empty()) return out.bytes();
  out.number<std::uint8_t>(node.own ? 1 : 0);
  out.number<std::uint64_t>(node.modes.size());
  for (const Moments& mode : node.modes) out.raw(mode.toBytes());
  if (node.own) out.raw(node.own->toBytes());
  if (node.border.images.empty()) return out.bytes();
  out.number<std::uint64_t>(node.border.images.size());
  for (const NodeBorder::Image& image : node.border.images) out.number<std::uint64_t>(image.frame);
  return out.bytes();
}

Mapper Mapper::Impl::restore(const DescriptorLayout& layout, const MapperOptions& options,
                             const Saved& saved) {
  auto impl = std::make_unique<Impl>(layout, options, saved.prior);
  const std::size_t labels = impl->labels;
  ByteReader in = readerOf(saved.state);
  ThresholdEstimator::Memory memory = readMemory(in);
  const std::size_t frames = memory.frames;
  impl->nextEstimate = in.number<std::uint64_t>();
  const auto current = in.number<std::int32_t>();
  impl->nextId = in.number<std::int32_t>();
  in.number<std::uint64_t>();  // see state()
  std::array<double, 3> thresholds{};
  for (double& threshold : thresholds)
    if (threshold = in.number<double>(); !std::isfinite(threshold) || threshold < 0)
      in.fail("a threshold is none", ErrorCode::corruptFile);
  if (impl->nextId < 0 || impl->nextId > std::numeric_limits<int>::max() / 2)
    in.fail("a node's number is none", ErrorCode::corruptFile);
  impl->thresholds = thresholdsFrom(thresholds[0], options.thresholds);
  impl->thresholds.revisit = thresholds[1];
  impl->thresholds.merge = thresholds[2];
  Standardization standardization;
  standardization.center = in.numbers<float>();
  standardization.weight = in.numbers<float>();
  const std::size_t expected = impl->distance.standardized && frames > 0 ? labels : 0;
  if (standardization.center.size() != expected || standardization.weight.size() != expected)
    in.fail("it is of another vocabulary", ErrorCode::corruptFile);
  Moments moments = readMoments(in, labels, true);
  in.raw(in.count(transitionBytes) * transitionBytes);  // see state()
  impl->isFirstDrive = in.remaining() == 0;
  if (!impl->isFirstDrive) readDrive(in, frames, *impl);
  requireEnd(in);

  impl->bank.setStandardization(std::move(standardization));
  for (const auto& [id, bytes] : saved.nodes) {
    NodeMemory node = readNode(impl->bank, id, bytes, labels, impl->distance.sigmaWeighted, frames,
                               2 * options.transitionImages);
    describe(node.border, *impl, saved.descriptor);
    impl->bank.add(std::move(node));
  }
  for (const Transition& transition : saved.transitions) {
    for (const int node : {transition.from, transition.to}) impl->bank.slotOf(node);
    impl->transitions[{transition.from, transition.to}] = transition;
  }
  if (current >= 0) impl->current = impl->bank.slotOf(current);
  impl->scale.restore(std::move(memory), std::move(moments), saved.descriptor);
  if (impl->views.isOn() && frames > 0)
    impl->views.restore(saved.views, frames, [&](std::size_t frame, int node) {
      if (node >= 0) impl->bank.slotOf(node);
      PlaceView view{.pose = saved.pose(frame),
                     .embedded = impl->embeddedFrame(saved.descriptor(frame)).embedded};
      view.compared = impl->bank.compared(view.embedded);
      return view;
    });
  if (impl->isWarmingUp())
    for (std::size_t frame = 0; frame < frames; ++frame)
      impl->warmup.push_back({saved.descriptor(frame), saved.pose(frame)});
  return Mapper(std::move(impl));
}

Mapper restoreMapper(const MapStore& store) try {
  const auto state = store.findState(mapperStateKey);
  if (!state)
    throw Error(ErrorCode::corruptFile, "the map has no saved mapper state; map the sequence again");
  const Vocabulary& vocabulary = store.identity().vocabulary;
  const auto prior = store.findState(mapperPriorKey);  // none: of an older program's map
  return Mapper::Impl::restore(
      vocabulary.layout(), settingsFromJson(store.identity().settings),
      {prior ? LabelPrior::fromBytes(*prior, vocabulary.size()) : unknownLabelsPrior(vocabulary.size()),
       *state, store.nodeStates(), store.findState(mapperViewsKey).value_or(""), store.transitions(),
       [&store](std::size_t frame) { return store.descriptor(frame); },
       [&store](std::size_t frame) { return store.pose(frame); }});
} catch (const Error& e) {
  const std::string path = store.path().string(), message = e.what();
  // The store names its file; what is read from memory knows none.
  throw Error(e.code(), message.starts_with(path) ? message : path + ": " + message);
}

}  // namespace estancia
