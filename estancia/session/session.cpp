// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <system_error>
#include <utility>
#include <variant>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/printable_labels.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/localization/localizer_map.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/session/session_impl.hpp"

namespace estancia {
namespace {

constexpr const char *guideKey = "guide", *guidedKey = "guided", *alignmentKey = "alignment";
/// A drive whose poses are known in the map is lost no longer when it was recognized so often: poses and
/// views identify places from then on, as in a first drive, at a tenth of the cost.
constexpr std::size_t enoughGuided = 200;

Node toNode(const NodeMemory& memory) {
  Node node{memory.id, memory.frames};
  node.mean.assign(memory.probabilities.mean().begin(), memory.probabilities.mean().end());
  for (const float variance : memory.probabilities.variance()) node.sigma.push_back(std::sqrt(variance));
  return node;
}

LocalizerMap localizerMapOf(const MapStore& store, const Mapper& mapper, const LocalizerOptions& options) {
  validate(options);
  return readLocalizerMap(store, mapper.impl().bankAtRest(), options.maxImages);
}

/// Before a drive's places are forgotten: those before it have none of them.
void requireApart(MapStore& store, int firstNode, std::size_t firstFrame) {
  sqlite::Statement shared(store.database(),
                           "SELECT EXISTS(SELECT 1 FROM frames WHERE id < ?1 AND node >= ?2)", firstFrame,
                           firstNode);
  if (shared.next() && shared.integer(0) != 0)
    store.database().failDamaged("what is known of its last drive is not true");
}

}  // namespace

Localizer::Localizer(MappingSession& session, const LocalizerOptions& options)
    : Localizer(std::make_shared<const LocalizerMap>(
                    localizerMapOf(session.impl_->written(), session.impl_->mapper, options)),
                options) {}

MappingSession::MappingSession(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MappingSession::MappingSession(MappingSession&&) noexcept = default;
MappingSession& MappingSession::operator=(MappingSession&&) noexcept = default;

MappingSession::~MappingSession() {
  if (!impl_ || impl_->finished || std::uncaught_exceptions() > impl_->exceptions) return;
  try {
    finish();
  } catch (const std::exception&) {  // the file keeps its last commit; finish() reports the reason
  }
}

MappingSession MappingSession::create(const std::filesystem::path& path, const Vocabulary& vocabulary,
                                      const std::string& model, const MapperOptions& options,
                                      ExistingMap existing) {
  Mapper mapper(vocabulary, options);  // first: invalid options leave no file
  MapStore store = MapStore::create(path, {vocabulary, model, settingsToJson(options)}, existing);
  store.putState(mapperPriorKey, mapper.impl().prior.toBytes());
  return MappingSession(std::make_unique<Impl>(Impl{std::move(store), std::move(mapper)}));
}

MappingSession MappingSession::resume(const std::filesystem::path& path, const Vocabulary& vocabulary,
                                      const std::string& model) {
  MapStore store = MapStore::open(path, MapStore::Access::write);
  requireSameVocabulary(store.identity().vocabulary, printableLabels(vocabulary), path.string());
  if (store.identity().model != printable(model))
    fail(ErrorCode::mismatch,
         "{} was made with the model {}, not {}; use that one (--model, --precision, --reduced-images)",
         path.string(), store.identity().model, printable(model));
  Mapper mapper = restoreMapper(store);
  MappingSession session(std::make_unique<Impl>(Impl{std::move(store), std::move(mapper)}));
  if (const MapBudget kept = budgetOf(session.impl_->store); kept != MapBudget{}) session.setBudget(kept);
  session.impl_->restoreDrive();
  return session;
}

MappingSession::MappingSession(const std::filesystem::path& path, Labeler& labeler,
                               const std::optional<MapperOptions>& options) {
  if (labeler.discovers())
    fail(ErrorCode::invalidInput,
         "{} discovers its words, but a map needs to know them; record() its labels first",
         labeler.identity());
  std::error_code none;  // create() reports an invalid name
  *this = std::filesystem::exists(path, none)
              ? resume(path, labeler.vocabulary(), labeler.identity())
              : create(path, labeler.vocabulary(), labeler.identity(), options.value_or(MapperOptions{}));
  if (options && *options != mapper().options())
    fail(ErrorCode::mismatch, "{} was made with other settings, which it keeps; give none", path.string());
  impl_->labeler = &labeler;
  if (frames() > 0) beginDrive();
}

void MappingSession::beginDrive(const DriveStart& start) {
  impl_->beginDrive(start);
}

int MappingSession::add(const cv::Mat& image, std::optional<double> timestamp,
                        const std::optional<Pose>& pose) {
  if (impl_->labeler == nullptr)
    throw Error(ErrorCode::invalidState, "the session has no labeler; add descriptors, or make it with one");
  const Frame frame{fmt::format("frame {:06}", frames()), timestamp, pose, ""};
  return add(frame, impl_->labeler->label(image, frame.name), [&image] { return encodeImage(image); });
}

int MappingSession::add(const Frame& frame, DescriptorView descriptor, const Image& image) {
  const int node = impl_->add(frame, descriptor, image);
  impl_->writeWhenDue();
  return node;
}

int MappingSession::Impl::add(const Frame& frame, DescriptorView descriptor, const Image& image) {
  const std::size_t index = mapper.frames();
  finished = false;
  MappedFrame mapped{frame, 0, index};
  const std::optional<Pose> given = frame.pose && frame.pose->isPlausible() ? frame.pose : std::nullopt;
  mapped.pose = inMap(given);
  const auto guess = guide ? guide->add(descriptor, given) : std::nullopt;
  const bool isGuided = guess && given && drive.isAligned && !mapper.impl().lost;
  if (isGuided && ++guided >= enoughGuided) endGuidance();
  mapped.node = mapper.add(descriptor, mapped.pose, guess ? std::optional(guess->node) : std::nullopt);
  const bool isTaken = take(mapped, descriptor, given);
  const bool isNewPair = alignment && given && guess && guess->pose && alignment->add(*given, *guess->pose);
  if (isNewPair && !mapper.impl().lost) align();
  // Images of all warm-up frames, whose nodes may still change, then of a node's 1st, 2nd, 4th, 8th … frame.
  const Mapper::Impl& state = mapper.impl();
  const bool isShown =
      index < state.options.warmupFrames || std::has_single_bit(state.bank[*state.current].frames);
  if (image && isTaken && isShown) {
    const std::vector<unsigned char> jpeg = image();
    store.putImage(index, jpeg);
    if (keeper) keeper->count(jpeg.size());
  }
  if (state.isBack) comeBack(state.lost->cameBack());
  return mapper.currentNode();
}

void MappingSession::Impl::replay(const Frame& frame, DescriptorView descriptor,
                                  const std::vector<unsigned char>& jpeg, Decision known) {
  finished = false;
  known.frame = mapper.frames();
  MappedFrame mapped{frame, known.node, known.frame};
  const std::optional<Pose> given = frame.pose && frame.pose->isPlausible() ? frame.pose : std::nullopt;
  mapped.pose = inMap(given);
  mapper.impl().replay(descriptor, known);
  if (take(mapped, descriptor, given) && !jpeg.empty()) {
    store.putImage(mapped.number, jpeg);
    if (keeper) keeper->count(jpeg.size());
  }
  writeWhenDue();
}

bool MappingSession::Impl::take(const MappedFrame& frame, DescriptorView descriptor,
                                const std::optional<Pose>& given) {
  const std::optional<Pose> own = drive.alignment || !drive.isAligned ? given : std::nullopt;
  const bool isTaken = !keeper || mapper.impl().isWarmingUp() || keeper->takes(mapper.impl().lastDecision());
  if (isTaken)
    keep(frame, descriptor, own);
  else
    keeper->wait({frame, {descriptor.begin(), descriptor.end()}, own});
  return isTaken;
}

void MappingSession::Impl::keep(const MappedFrame& frame, DescriptorView descriptor,
                                const std::optional<Pose>& given) {
  store.addFrame(frame, descriptor);
  if (given) store.putGivenPose(frame.number, *given);
  if (keeper) keeper->count(descriptor.size_bytes());
}

void MappingSession::Impl::writeWhenDue() {
  if (std::chrono::steady_clock::now() - lastWritten >= std::chrono::seconds(1) ||
      (keeper && keeper->isDue()))
    write();
}

void MappingSession::Impl::beginDrive(const DriveStart& start, bool isLost) {
  const std::size_t frame = mapper.frames();
  drive = {frame, printable(start.name), start.fingerprint};
  guide.reset();
  guided = 0;
  endAlignment();
  if (frame > 0) {
    mapAlone();
    mapper.beginDrive();
    if (!isLost) mapper.impl().lost.reset();
    write();
    drive.alignment = start.alignment;
    drive.isAligned = start.posesAreInMap || start.alignment || !store.hasPoses();
  }
  if (frame > 0 && isLost) {
    guide.emplace(store, mapper.impl().bank.standardization(), maxGuideFrames());
    store.putState(guideMapKey, guide->known());
    if (!drive.isAligned) alignment.emplace(mapper.options().nearDistance, mapper.options().nearAngle);
    nextAlignment = 0;
  }
  store.putDrive(drive);
}

void MappingSession::Impl::restoreDrive() {
  const std::vector<Drive> drives = store.drives();
  if (drives.empty()) return;
  drive = drives.back();
  const auto known = store.findState(guideMapKey), state = store.findState(guideKey);
  if (drive.firstFrame == 0 || !known || known->empty()) return;
  if (state && drive.firstFrame < mapper.frames()) {
    guide.emplace(store, *known, *state);
    if (const auto count = store.findState(guidedKey))
      guided = ByteReader(*count, "what guided the map's last drive is damaged", "map the sequence again")
                   .number<std::uint64_t>();
  } else {
    guide.emplace(store, mapper.impl().bank.standardization(), maxGuideFrames());
  }
  const auto pairs = store.findState(alignmentKey);
  if (drive.isAligned && (!pairs || pairs->empty())) return;
  alignment.emplace(mapper.options().nearDistance, mapper.options().nearAngle);
  if (pairs && !pairs->empty()) nextAlignment = alignment->restore(*pairs);
}

void MappingSession::Impl::endGuidance() {
  guide.reset();
  if (alignment) endAlignment();
  for (const char* key : {guideKey, guideMapKey}) store.putState(key, "");
}

void MappingSession::Impl::endAlignment() {
  alignment.reset();
  store.putState(alignmentKey, "");
}

void MappingSession::Impl::mapAlone(std::size_t end) {
  Mapper::Impl& map = mapper.impl();
  if (!map.lost || map.lost->firstFrame() >= mapper.frames() || map.lost->isMapped(mapper.frames())) return;
  const int firstNode = map.lost->firstNode();
  const std::size_t firstFrame = map.lost->firstFrame();
  write();
  requireApart(store, firstNode, firstFrame);
  auto own = std::make_unique<Mapper::Impl>(store.identity().vocabulary.layout(), map.options, map.prior);
  if (budget.memory) own->setMemory(*budget.memory * megabyte);
  Mapper alone(std::move(own));
  std::vector<std::size_t> numbers;
  try {
    store.forEachDescriptor(firstFrame, [&](std::size_t frame, DescriptorView words) {
      if (frame >= end) return false;
      numbers.push_back(frame);
      const auto given = store.givenPose(frame);
      alone.add(words, given ? given : store.pose(frame));
      return true;
    });
    alone.finish();
  } catch (const Error& e) {
    if (e.code() != ErrorCode::tooLarge) throw;
    return;  // more places than fit into the memory: it keeps those that it has
  }
  if (numbers.empty() || !map.hasRoomFor(alone.impl())) return;
  store.clearMap(firstNode, firstFrame);
  if (keeper) keeper->forgetFrom(firstNode);
  map.takeAlone(
      alone.impl(), [&numbers](std::size_t frame) { return numbers[frame]; },
      [this](std::size_t frame) { return store.pose(frame); });
}

/// The drive comes back from elsewhere: what it saw before `frame` is mapped alone, the rest in the map.
void MappingSession::Impl::comeBack(std::size_t frame) {
  Mapper::Impl& map = mapper.impl();
  mapAlone(frame);
  map.isBack = false;
  if (alignment) alignment.emplace(map.options.nearDistance, map.options.nearAngle);  // pairs of elsewhere
  nextAlignment = 0;
  if (!std::exchange(map.lost, std::nullopt)->isMapped(mapper.frames())) return;
  store.forEachDescriptor(frame, [&](std::size_t number, DescriptorView words) {
    map.place(number, map.embeddedFrame(words), store.pose(number));
    return true;
  });
}

std::optional<Pose> MappingSession::Impl::inMap(const std::optional<Pose>& given) const {
  if (!given || !drive.isAligned) return std::nullopt;
  return drive.alignment ? poseOf(rigidOf(*drive.alignment) * rigidOf(*given)) : *given;
}

/// Tries to align the drive, again when a quarter more is known of it, until depth has confirmed it.
void MappingSession::Impl::align() {
  if (alignment->pairs() < nextAlignment) return;
  nextAlignment = alignment->pairs() + alignment->pairs() / 4 + 1;
  const auto estimate = alignment->estimate();
  if (!estimate) return;
  const auto byDepth = verify.lock();
  const std::optional<cv::Affine3d> found = byDepth                 ? (*byDepth)(estimate->transform)
                                            : estimate->isCertain() ? std::optional(estimate->transform)
                                                                    : std::nullopt;
  if (!found) return;
  ++alignments;
  drive.isAligned = true;
  drive.alignment = poseOf(*found);
  store.putDrive(drive);
  if (byDepth) endAlignment();
  std::vector<Correction> corrections;
  for (std::size_t frame = drive.firstFrame; frame < mapper.frames(); ++frame)
    corrections.push_back({frame, inMap(store.givenPose(frame))});
  correct(corrections);
}

void MappingSession::setBudget(const MapBudget& budget) {
  impl_->setBudget(budget);
}

void MappingSession::changeBudget(const std::function<void(MapBudget&)>& change) {
  MapBudget wanted = budget();
  if (change) change(wanted);
  if (wanted != budget()) setBudget(wanted);
}

const MapBudget& MappingSession::budget() const {
  return impl_->budget;
}

void MappingSession::correct(const std::vector<Correction>& corrections) {
  impl_->correct(corrections);
}

void MappingSession::Impl::correct(const std::vector<Correction>& corrections) {
  if (corrections.empty()) return;
  finished = false;
  if (keeper) settleWaiting(neededFrames());
  for (const Correction& correction : corrections) store.putPose(correction.frame, correction.pose);
  mapper.movePoses([this](std::size_t frame) { return store.pose(frame); });
}

void MappingSession::finish() {
  impl_->mapper.finish();
  impl_->mapAlone();
  impl_->write();
  impl_->finished = true;
}

std::size_t MappingSession::frames() const {
  return impl_->mapper.frames();
}

const Mapper& MappingSession::mapper() const {
  return impl_->mapper;
}

TopologicalMap MappingSession::map() {
  return impl_->written().load();
}

const MapStore& MappingSession::Impl::written() {
  write();
  return store;
}

void MappingSession::Impl::write() {
  if (mapper.frames() == 0) return;
  const std::vector<std::size_t> needed = keeper ? neededFrames() : std::vector<std::size_t>();
  if (keeper) settleWaiting(needed);
  const MapChanges changes = mapper.takeChanges();
  if (changes.restarted) store.clearMap();
  for (const auto& event : changes.events)
    if (const auto* merge = std::get_if<Merge>(&event)) {
      store.addMerge(*merge);
      if (keeper) keeper->merge(merge->absorbed);
    } else if (const auto& decision = std::get<Decision>(event);
               !keeper || !keeper->isLeftOut(decision.frame)) {
      store.putDecision(decision);
    }
  const Mapper::Impl& state = mapper.impl();
  for (const int id : changes.changedNodes) {
    const std::size_t slot = state.bank.slotOf(id);
    store.putNode(toNode(state.bank[slot]), state.nodeState(slot));
  }
  for (const auto& [from, to] : changes.changedTransitions)
    if (const auto known = state.transitions.find({from, to}); known != state.transitions.end())
      store.putTransition(known->second);
    else
      store.removeTransition(from, to);
  store.putState(mapperStateKey, state.state());
  if (state.views.isOn()) store.putState(mapperViewsKey, state.views.state());
  if (guide) {
    store.putState(guideKey, guide->state());
    ByteWriter count;
    count.number<std::uint64_t>(guided);
    store.putState(guidedKey, count.bytes());
  }
  if (alignment) store.putState(alignmentKey, alignment->state(nextAlignment));
  if (keeper) {
    store.putState(frameSampleKey, keeper->state());
    keeper->endWriting(needed);
  }
  store.commit();
  if (keeper) keeper->fit(needed);
  lastWritten = std::chrono::steady_clock::now();
}

std::optional<std::size_t> firstUnmapped(const TopologicalMap& map, const Sequence& sequence) {
  if (map.frames.empty()) return 0;
  const Drive last = map.drives.empty() ? Drive{} : map.drives.back();
  const std::string begins = driveStartOf(sequence).fingerprint;
  if (!begins.empty() && !last.fingerprint.empty() && begins != last.fingerprint) return std::nullopt;
  std::size_t next = 0;
  for (std::size_t i = last.firstFrame; i < map.frames.size(); ++i) {
    const MappedFrame& frame = map.frames[i];
    while (next < sequence.size() && printable(sequence.frame(next).name) != frame.name) ++next;
    if (next == sequence.size()) return std::nullopt;
    const std::optional<double> time = sequence.frame(next).timestamp;
    if (time && frame.timestamp && *time != *frame.timestamp) return std::nullopt;
    ++next;
  }
  return next;
}

DriveStart driveStartOf(const Sequence& sequence) {
  DriveStart start{sequence.name()};
  if (sequence.size() == 0) return start;
  try {
    start.fingerprint = sequence.fingerprint(0);
  } catch (const Error&) {  // it cannot be read, which is reported elsewhere
  }
  return start;
}

}  // namespace estancia
