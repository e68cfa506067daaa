// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/drive_guide.hpp"

#include <set>
#include <utility>

#include "estancia/core/pose_bytes.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/localization/localizer_map.hpp"
#include "estancia/mapper/mapper_impl.hpp"

namespace estancia {
namespace {

/// Min probability of a place; the Bayes filter of a map without poses is sure too soon of unknown places.
constexpr double certain = 0.7, certainWithoutPoses = 0.9;
constexpr double maxUnvisited = 0.3, maxUnmapped = 0.5;

}  // namespace

bool isCertain(const Localization& found) {
  return found.unvisited ? found.confidence >= certain && *found.unvisited <= maxUnvisited
                         : found.confidence >= certainWithoutPoses;
}

bool showsView(const Localization& found) {
  return found.unmapped && *found.unmapped <= maxUnmapped;
}

struct DriveGuide::Known {
  struct View {
    std::size_t frame = 0;
    int node = 0;
    std::optional<Pose> pose;
  };
  std::vector<View> views;
  std::vector<std::pair<int, int>> transitions;
  Standardization scale;
};

DriveGuide::Known DriveGuide::knownOf(const MapStore& store, const Standardization& scale,
                                      std::size_t maxFrames) {
  const TopologicalMap map = store.load(maxFrames);
  Known known;
  for (const MappedFrame& frame : map.frames) known.views.push_back({frame.number, frame.node, frame.pose});
  for (const Transition& transition : map.transitions)
    known.transitions.emplace_back(transition.from, transition.to);
  known.scale = scale;
  return known;
}

DriveGuide::Known DriveGuide::knownFrom(const std::string& bytes, const MapStore& store) {
  ByteReader in(bytes, "what the map's last drive was guided by is damaged", "map the sequence again");
  Known known;
  const std::size_t frames = store.frameCount();
  const std::size_t labels = store.identity().vocabulary.size();
  for (std::size_t count = in.count(sizeof(std::uint64_t)); count > 0; --count) {
    Known::View view;
    view.frame = in.number<std::uint64_t>();
    view.node = in.number<std::int32_t>();
    if (view.frame >= frames) in.fail("a frame is missing", ErrorCode::corruptFile);
    if (in.number<std::uint8_t>() != 0) view.pose = readPose(in, ErrorCode::corruptFile);
    known.views.push_back(view);
  }
  for (std::size_t count = in.count(2 * sizeof(std::int32_t)); count > 0; --count) {
    const auto from = in.number<std::int32_t>();
    known.transitions.emplace_back(from, in.number<std::int32_t>());
  }
  known.scale.center = in.numbers<float>();
  known.scale.weight = in.numbers<float>();
  for (const auto* values : {&known.scale.center, &known.scale.weight})
    if (!values->empty() && values->size() != labels)
      in.fail("it is of another vocabulary", ErrorCode::corruptFile);
  if (known.views.empty() || in.remaining() > 0) in.fail("its length is wrong", ErrorCode::corruptFile);
  return known;
}

std::string DriveGuide::known() const {
  ByteWriter out;
  out.number<std::uint64_t>(known_->views.size());
  for (const Known::View& view : known_->views) {
    out.number<std::uint64_t>(view.frame);
    out.number<std::int32_t>(view.node);
    out.number<std::uint8_t>(view.pose ? 1 : 0);
    if (view.pose) write(out, *view.pose);
  }
  out.number<std::uint64_t>(known_->transitions.size());
  for (const auto& [from, to] : known_->transitions) {
    out.number<std::int32_t>(from);
    out.number<std::int32_t>(to);
  }
  out.numbers(known_->scale.center);
  out.numbers(known_->scale.weight);
  return out.bytes();
}

DriveGuide::DriveGuide(const MapStore& store, Known known)
    : known_(std::make_shared<const Known>(std::move(known))) {
  const MapStore::Identity& identity = store.identity();
  const std::size_t labels = identity.vocabulary.size();
  TopologicalMap map{identity.vocabulary, identity.model, settingsFromJson(identity.settings).distance};
  NodeBank bank(getDistance(map.distance, map.vocabulary.layout().parts), labels);
  bank.setStandardization(known_->scale);
  DescriptorMatrix images(labels);
  std::set<int> nodes;
  for (const Known::View& view : known_->views) {
    map.frames.push_back({{"", std::nullopt, view.pose, ""}, view.node});
    nodes.insert(view.node);
    images.append(store.descriptor(view.frame));
  }
  for (const int id : nodes) map.nodes.push_back({id, 1});
  for (const auto& [from, to] : known_->transitions)
    if (nodes.contains(from) && nodes.contains(to)) map.transitions.push_back({from, to, 1, 0});
  localizer_.emplace(std::make_shared<const LocalizerMap>(
                         LocalizerMap{std::move(map), std::move(bank), std::move(images), 1}),
                     LocalizerOptions{});
}

DriveGuide::DriveGuide(const MapStore& store, const Standardization& scale, std::size_t maxFrames)
    : DriveGuide(store, knownOf(store, scale, maxFrames)) {}

DriveGuide::DriveGuide(const MapStore& store, const std::string& known, const std::string& state)
    : DriveGuide(store, knownFrom(known, store)) {
  localizer_->restore(state);
}

std::optional<DriveGuide::Guess> DriveGuide::add(DescriptorView descriptor, const std::optional<Pose>& own) {
  const Localization found = localizer_->add(descriptor, own).front();
  if (!isCertain(found)) return std::nullopt;
  const Known::View& view = known_->views.at(found.beliefImage);
  return Guess{found.beliefNode, showsView(found) ? view.pose : std::nullopt};
}

void DriveGuide::addNeededFrames(std::vector<std::size_t>& frames) const {
  for (const Known::View& view : known_->views) frames.push_back(view.frame);
}

void DriveGuide::addNeededFrames(const std::string& known, const MapStore& store,
                                 std::vector<std::size_t>& frames) {
  for (const Known::View& view : knownFrom(known, store).views) frames.push_back(view.frame);
}

}  // namespace estancia
