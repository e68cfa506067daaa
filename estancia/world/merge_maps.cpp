// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/merge_maps.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/rigid.hpp"
#include "estancia/topology/drive_store.hpp"
#include "estancia/topology/mapper_impl.hpp"
#include "estancia/topology/session_impl.hpp"
#include "estancia/world/edit_objects.hpp"
#include "estancia/world/world_mapper_impl.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

/// What a map keeps, as of one moment.
struct Source {
  explicit Source(const fs::path& file)
      : path(file), store(MapStore::open(file, MapStore::Access::read)), map(asOfNow(store)) {
    layers.emplace(store, MapStore::Access::read);
    if (map.frames.empty())
      fail(ErrorCode::insufficientData, "{} has no frames; map some images first", path.string());
    isObserved.resize(map.frames.size());
    if (!layers->exists()) return;
    for (const std::size_t frame : layers->observedFrames())
      if (const auto index = map.findFrame(frame)) isObserved[*index] = true;
  }
  static TopologicalMap asOfNow(MapStore& store) {
    store.beginReading();
    return store.load();
  }

  // By places in map.frames.
  std::optional<Pose> givenPose(std::size_t i) const {
    return DriveStore(store).givenPose(map.frames[i].number);
  }
  LexicalDescriptor descriptor(std::size_t i) const { return store.descriptor(map.frames[i].number); }
  std::vector<unsigned char> image(std::size_t i) const { return store.image(map.frames[i].number); }
  std::optional<Observation> observation(std::size_t i) const {
    return isObserved[i] ? std::optional(layers->observation(map.frames[i].number)) : std::nullopt;
  }
  std::vector<std::size_t> numbers(std::size_t first, std::size_t end) const {
    std::vector<std::size_t> numbers;
    for (std::size_t i = first; i < end; ++i) numbers.push_back(map.frames[i].number);
    return numbers;
  }
  /// T_map_drive of a drive that is aligned.
  cv::Affine3d alignment(std::size_t drive) const {
    const auto& found = map.drives[drive].alignment;
    return found ? rigidOf(*found) : cv::Affine3d::Identity();
  }
  std::size_t end(std::size_t drive) const {
    return drive + 1 < map.drives.size() ? map.drives[drive + 1].firstFrame : map.frames.size();
  }

  fs::path path;
  mutable MapStore store;  // reading its tables needs the connection
  TopologicalMap map;
  std::optional<WorldStore> layers;
  std::vector<bool> isObserved;
};

/// A drive of a source, and where its frames go.
struct Part {
  Source* source;
  std::size_t drive, first, end, offset;

  bool hasPoses() const {
    const auto& frames = source->map.frames;
    return std::any_of(frames.begin() + static_cast<std::ptrdiff_t>(first),
                       frames.begin() + static_cast<std::ptrdiff_t>(end),
                       [](const MappedFrame& frame) { return frame.pose.has_value(); });
  }
};

void requireMergeable(const Source& first, const Source& other) {
  const std::string file = other.path.string();
  requireSameVocabulary(first.map.vocabulary, other.map.vocabulary, file);
  if (first.map.model != other.map.model)
    fail(ErrorCode::mismatch, "{} was made with the model {}, and {} with {}; map both with one model",
         first.path.string(), first.map.model, file, other.map.model);
  for (std::size_t a = 0; a < first.map.drives.size(); ++a)
    for (std::size_t b = 0; b < other.map.drives.size(); ++b) {
      const std::size_t begin = first.map.drives[a].firstFrame, end = other.map.drives[b].firstFrame;
      const std::size_t frames = first.end(a) - begin;
      if (other.end(b) - end != frames) continue;
      const auto isSame = [&](std::size_t i) {
        return first.map.frames[begin + i].name == other.map.frames[end + i].name &&
               first.descriptor(begin + i) == other.descriptor(end + i);
      };
      if (isSame(0) && isSame(frames / 2) && isSame(frames - 1))
        fail(ErrorCode::invalidInput,
             "{} and {} have the drive \"{}\" in common; a map cannot be merged with itself: undo the drive "
             "in "
             "one of them",
             first.path.string(), file, first.map.drives[a].name);
    }
}

}  // namespace

/// The map that is made, in a file beside its place until it is whole.
class NewMap {
 public:
  NewMap(const fs::path& place, const Source& first, const std::vector<Part>& parts)
      : path_(place.parent_path() / fmt::format(".{}.{}.new", place.filename().string(), getpid())),
        session_(MappingSession::create(path_, first.map.vocabulary, first.map.model,
                                        settingsFromJson(first.store.identity().settings),
                                        ExistingMap::replace)) {
    MapStore& store = session_->impl_->store;
    session_->impl_->takeBudgetOf(first.store);
    WorldStore layers(store, MapStore::Access::write);
    for (const Part& part : parts)
      layers.copyViews(*part.source->layers, part.source->numbers(part.first, part.end), part.offset);
    if (const auto labels = first.layers->regionLabels(); !labels.empty()) layers.putRegionLabels(labels);
    for (const AreaEdit& edit : first.layers->edits()) layers.addEdit(edit);
    for (const ObjectEdit& edit : first.layers->objectEdits()) layers.addObjectEdit(edit);
    WorldOptions options = MapTerms(first.store).options().value_or(WorldOptions{});
    if (const std::string kept = first.layers->layers(); !kept.empty()) options.layers = layersFrom(kept);
    world_.emplace(*session_, options);
  }
  ~NewMap() {
    world_.reset();
    session_.reset();
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  NewMap(const NewMap&) = delete;
  NewMap& operator=(const NewMap&) = delete;

  WorldMapper& world() { return *world_; }
  const Drive& drive() const { return session_->impl_->drive; }
  std::size_t places() const { return session_->mapper().nodes(); }

  /// `toMerged`: from the map of its source to this one, where that is known. A drive keeps the poses that it
  /// was given, so that it can be gone on with.
  void add(const Part& part, const std::optional<cv::Affine3d>& toMerged, Progress& progress) {
    const Source& source = *part.source;
    const Drive& known = source.map.drives[part.drive];
    DriveStart start{known.name, known.fingerprint};
    if (toMerged && known.isAligned) {
      start.posesAreInMap = !known.alignment && toMerged->matrix == cv::Affine3d::Identity().matrix;
      if (!start.posesAreInMap) start.alignment = poseOf(*toMerged * source.alignment(part.drive));
    }
    session_->beginDrive(start);
    world_->beginDrive();
    for (std::size_t i = part.first; i < part.end; ++i) {
      if (interrupted()) throw Interrupted("stopped; nothing was changed");
      Frame frame = source.map.frames[i];
      if (const auto given = source.givenPose(i)) frame.pose = given;
      const LexicalDescriptor words = source.descriptor(i);
      world_->observe(frame, words, source.observation(i));
      session_->add(frame, words, [&] { return source.image(i); });
      progress.advance();
    }
  }

  void finish() {
    session_->finish();
    world_->finish();
  }

  /// To its place, or in the place of the map `old`, which nobody else writes; then with that one's mode.
  void move(const fs::path& place, std::optional<MapStore>& old) {
    world_.reset();
    session_.reset();
    if (old) fs::permissions(path_, fs::status(place).permissions());
    old.reset();  // what SQLite keeps beside the file goes with it
    fs::rename(path_, place);
  }

 private:
  fs::path path_;
  std::optional<MappingSession> session_;
  std::optional<WorldMapper> world_;
};

namespace {

std::vector<Part> partsOf(const std::vector<std::unique_ptr<Source>>& sources,
                          std::optional<std::size_t> but = {}) {
  std::vector<Part> parts;
  std::size_t offset = 0;
  for (const auto& source : sources)
    for (std::size_t drive = 0; drive < source->map.drives.size(); ++drive) {
      if (drive == but) continue;
      const Part part{source.get(), drive, source->map.drives[drive].firstFrame, source->end(drive), offset};
      offset += part.end - part.first;
      parts.push_back(part);
    }
  return parts;
}

/// Of the maps but the first.
std::vector<MergedMaps::Part> partsOfMerged(const TopologicalMap& merged,
                                            const std::vector<std::unique_ptr<Source>>& sources) {
  std::vector<MergedMaps::Part> parts;
  std::set<int> known;
  std::size_t frame = 0, drive = 0;
  for (const auto& source : sources) {
    MergedMaps::Part part;
    std::set<int> own;
    for (const std::size_t end = frame + source->map.frames.size(); frame < end; ++frame) {
      own.insert(merged.frames[frame].node);
      part.isRecognized = part.isRecognized || known.contains(merged.frames[frame].node);
    }
    for (std::size_t i = 0; i < source->map.drives.size(); ++i) {
      const Drive& now = merged.drives[drive++];
      part.isAligned = part.isAligned || (now.isAligned && now.alignment);
      part.hasPoses = part.hasPoses || now.alignment || !now.isAligned;
    }
    if (source != sources.front()) parts.push_back(part);
    known.merge(own);
  }
  return parts;
}

/// People's corrections of an aligned map; they may contradict those of the maps before.
class Corrections {
 public:
  Corrections(const Source& source, const cv::Affine3d& toMerged) : source_(source), toMerged_(toMerged) {}

  void giveTo(NewMap& merged, const fs::path& file, std::vector<std::string>& conflicts) const {
    const WorldMap own = worldOf();
    for (AreaEdit edit : source_.layers->edits()) {
      if (!own.plan) break;
      const WorldMap now = merged.world().read();
      if (!now.plan) break;
      for (cv::Point2d* at : {&edit.from, &edit.to}) *at = moved(*at, own.plan->floor, now.plan->floor);
      if (edit.kind == AreaEdit::Kind::name) {
        const WorldArea* area = now.findArea(areaAt(*now.plan, edit.from, 0));
        if (area != nullptr && !area->givenName.empty() && area->givenName != edit.name) {
          conflicts.push_back(
              fmt::format("{} calls an area \"{}\" that is called \"{}\" already: that is kept",
                          file.string(), printable(edit.name), area->givenName));
          continue;
        }
      }
      try {
        merged.world().edit(edit);
      } catch (const Error& e) {  // it cuts or joins nothing here
        if (e.code() != ErrorCode::invalidInput) throw;
      }
    }
    for (ObjectEdit edit : source_.layers->objectEdits()) {
      edit.center = toMerged_ * edit.center;
      merged.world().edit(edit);
    }
  }

 private:
  WorldMap worldOf() const {
    WorldMap world{source_.map};
    source_.layers->read(world);
    return world;
  }
  cv::Point2d moved(const cv::Point2d& at, const Floor& from, const Floor& to) const {
    const cv::Point3d point = toMerged_ * from.point({at.x, at.y, 0});
    return to.position({point.x, point.y, point.z});
  }

  const Source& source_;
  cv::Affine3d toMerged_;
};

}  // namespace

MergedMaps mergeMaps(std::span<const fs::path> maps, const fs::path& wanted, ExistingMap existing,
                     Progress& progress) {
  if (maps.size() < 2) fail(ErrorCode::invalidInput, "give two maps or more to merge");
  fs::path output = wanted;
  std::optional<MapStore> old;
  if (fs::exists(wanted)) {
    if (existing == ExistingMap::refuse)
      fail(ErrorCode::fileExists, "{} exists; give another name, or --overwrite", wanted.string());
    output = fs::canonical(wanted);  // what a link leads to
    old.emplace(MapStore::open(output, MapStore::Access::write));
  }
  std::vector<std::unique_ptr<Source>> sources;
  for (const fs::path& map : maps) {
    auto source = std::make_unique<Source>(map);
    for (const auto& before : sources) requireMergeable(*before, *source);
    sources.push_back(std::move(source));
  }
  const std::vector<Part> parts = partsOf(sources);
  NewMap merged(output, *sources.front(), parts);
  progress.begin("merging", parts.back().offset + parts.back().end - parts.back().first, 0);
  MergedMaps done;
  std::map<const Source*, std::optional<cv::Affine3d>> known;
  known[sources.front().get()] = cv::Affine3d::Identity();
  for (const Part& part : parts) {
    auto& toMerged = known[part.source];
    merged.add(part, toMerged, progress);
    const Drive& now = merged.drive();
    if (toMerged || !part.source->map.drives[part.drive].isAligned || !now.isAligned || !part.hasPoses())
      continue;
    const cv::Affine3d found = now.alignment ? rigidOf(*now.alignment) : cv::Affine3d::Identity();
    toMerged = found * part.source->alignment(part.drive).inv();
  }
  merged.finish();
  for (const auto& source : sources)
    if (source != sources.front() && known[source.get()])
      Corrections(*source, *known[source.get()]).giveTo(merged, source->path, done.conflicts);
  done.parts = partsOfMerged(merged.world().read().places, sources);
  progress.end();
  done.drives = parts.size();
  done.frames = parts.back().offset + parts.back().end - parts.back().first;
  done.places = merged.places();
  sources.clear();
  merged.move(output, old);
  return done;
}

void undoDrive(const fs::path& file, std::size_t drive, Progress& progress) {
  std::optional<MapStore> writer(MapStore::open(file, MapStore::Access::write));  // nobody else writes it now
  const fs::path map = fs::canonical(file);                                       // what a link leads to
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<Source>(map));
  const std::size_t drives = sources.front()->map.drives.size();
  if (drive >= drives)
    fail(ErrorCode::unknownName, "{} has no drive {}; it has {}, numbered from 0", map.string(), drive,
         drives);
  if (drives == 1)
    fail(ErrorCode::insufficientData, "{} has no other drive; remove the file instead", map.string());
  const std::vector<Part> parts = partsOf(sources, drive);
  NewMap without(map, *sources.front(), parts);
  progress.begin("mapping the other drives", parts.back().offset + parts.back().end - parts.back().first, 0);
  for (const Part& part : parts) without.add(part, cv::Affine3d::Identity(), progress);
  without.finish();
  progress.end();
  sources.clear();
  without.move(map, writer);
}

}  // namespace estancia
