#include "estancia/topology/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <variant>

#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"

namespace estancia {
namespace {

constexpr auto writeInterval = std::chrono::seconds(1);
constexpr const char* stateKey = "mapper";

Node toNode(const NodeMemory& memory) {
  Node node{memory.id, memory.frames, {}, {}};
  node.mean.assign(memory.words.mean().begin(), memory.words.mean().end());
  for (const float variance : memory.words.variance()) node.sigma.push_back(std::sqrt(variance));
  return node;
}

Mapper restoreMapper(const MapStore& store) {
  const auto state = store.findState(stateKey);
  if (!state) throw Error("the map has no saved mapper state; the file is damaged, map again");
  return Mapper::restore(store.identity().vocabulary.layout(),
                         MapperOptions::fromJson(store.identity().settings), *state, store.nodeStates(),
                         [&store](std::size_t frame) { return store.descriptor(frame); });
}

/// The map and the mapper's memory must be of one moment: a run that goes on may write in between.
MapStore openAtOneMoment(const std::filesystem::path& path) {
  MapStore store = MapStore::open(path, MapStore::Access::read);
  store.beginReading();
  return store;
}

}  // namespace

MappingSession::MappingSession(MapStore store, Mapper mapper)
    : store_(std::move(store)), mapper_(std::move(mapper)) {}

MappingSession MappingSession::create(const std::filesystem::path& path, const Vocabulary& vocabulary,
                                      const std::string& model, const MapperOptions& options,
                                      MapStore::Existing existing) {
  Mapper mapper(vocabulary.layout(), options);  // first: unknown distances leave no file
  return {MapStore::create(path, {vocabulary, model, options.toJson()}, existing), std::move(mapper)};
}

MappingSession MappingSession::resume(const std::filesystem::path& path, const Vocabulary& vocabulary,
                                      const std::string& model) {
  MapStore store = MapStore::open(path, MapStore::Access::write);
  requireSameVocabulary(store.identity().vocabulary, printableLabels(vocabulary), path.string());
  if (store.identity().model != printable(model))
    throw Error(fmt::format("{} was made with the model {}, not {}; continue it with that model",
                            path.string(), store.identity().model, printable(model)));
  Mapper mapper = restoreMapper(store);
  return {std::move(store), std::move(mapper)};
}

void MappingSession::add(const Frame& frame, DescriptorView descriptor, const Image& image) {
  const std::size_t index = mapper_.frames();
  mapper_.add(descriptor);
  MappedFrame mapped;
  static_cast<Frame&>(mapped) = frame;
  mapped.node = mapper_.currentNode();
  store_.addFrame(index, mapped, descriptor);
  // Images of all young frames, whose nodes may still change, then of a node's 1st, 2nd, 4th, 8th … frame.
  const bool keep = index < mapper_.options().warmupFrames ||
                    std::has_single_bit(mapper_.bank()[mapper_.currentSlot()].frames);
  if (image && keep) store_.putImage(index, image());
  if (std::chrono::steady_clock::now() - lastWritten_ >= writeInterval) write();
}

void MappingSession::finish() {
  mapper_.finish();
  if (mapper_.frames() > 0) write();
}

void MappingSession::write() {
  const Mapper::MapChanges news = mapper_.takeChanges();
  if (news.restarted) store_.clearMap();
  const NodeBank& bank = mapper_.bank();
  for (const auto& event : news.events)
    if (const auto* decision = std::get_if<Decision>(&event))
      store_.putDecision(*decision);
    else
      store_.addMerge(std::get<Merge>(event));
  for (const int id : news.changedNodes) {
    const std::size_t slot = bank.slotOf(id);
    store_.putNode(toNode(bank[slot]), mapper_.nodeState(slot));
  }
  if (news.redirected || news.restarted) {
    store_.clearTransitions();
    for (const auto& entry : mapper_.transitions()) store_.putTransition(entry.second);
  } else {
    for (const auto& ends : news.changedTransitions) store_.putTransition(mapper_.transitions().at(ends));
  }
  store_.putState(stateKey, mapper_.state());
  store_.commit();
  lastWritten_ = std::chrono::steady_clock::now();
}

std::size_t firstUnmapped(const TopologicalMap& map, const Sequence& sequence) {
  std::size_t next = 0;
  for (const MappedFrame& frame : map.frames) {
    while (next < sequence.size() && printable(sequence.frame(next).name) != frame.name) ++next;
    if (next == sequence.size())
      throw Error(fmt::format(
          "the map holds the frame {}, which is not (or not in this order) in {}; continue it with "
          "the sequence that it was made from",
          frame.name, sequence.name()));
    ++next;
  }
  return next;
}

MapReader::MapReader(const std::filesystem::path& path)
    : store_(openAtOneMoment(path)), map_(store_.load()), mapper_(restoreMapper(store_)) {
  store_.endReading();  // what forLocalizer() reads later never changes
}

LocalizerMap MapReader::forLocalizer(std::size_t mostImages) const {
  const std::size_t frames = map_.frames.size();
  const std::size_t stride = std::max<std::size_t>(1, (frames + mostImages - 1) / mostImages);
  LocalizerMap source{&map_, &mapper_.bank(), DescriptorMatrix(map_.vocabulary.size()), stride};
  source.images.reserve((frames + stride - 1) / stride);
  for (std::size_t frame = 0; frame < frames; frame += stride) source.images.append(store_.descriptor(frame));
  return source;
}

}  // namespace estancia
