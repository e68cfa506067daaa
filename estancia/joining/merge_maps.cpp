// SPDX-License-Identifier: Apache-2.0
#include "estancia/joining/merge_maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/joining/merge_plan.hpp"
#include "estancia/map_file/store_files.hpp"
#include "estancia/mapper/mapper_merge.hpp"
#include "estancia/session/session_impl.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world/world_mapper_impl.hpp"
#include "estancia/world_file/edit_rules.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

/// A drive of a source, and where its frames go.
struct Part {
  const MapSource* source;
  std::size_t number, drive, first, end, offset;
};

/// Layers of any of the maps; absent where no map stores them.
std::optional<WorldLayers> layersOf(const std::vector<Part>& parts) {
  std::optional<WorldLayers> all;
  for (const Part& part : parts) {
    const std::string kept = part.source->layers->layers();
    if (kept.empty()) continue;
    const WorldLayers own = layersFrom(kept);
    if (!all) all = own;
    all = {all->zones || own.zones, all->areas || own.areas, all->objects || own.objects};
  }
  return all;
}

void removeDraft(const fs::path& draft) {
  std::error_code ignored;
  fs::remove(draft, ignored);
  storage::removeCompanions(draft);
}

}  // namespace

/// The map that is made, in a file beside its place until it is whole.
class NewMap {
 public:
  NewMap(const fs::path& place, const MapSource& first, const std::vector<Part>& parts)
      : path_(partFile(place)),
        session_(MappingSession::create(path_, first.map.vocabulary, first.map.model,
                                        settingsFromJson(first.store.identity().settings),
                                        ExistingMap::replace)) {
    MapStore& store = session_->impl_->store;
    WorldStore layers(store, MapStore::Access::write);
    for (const Part& part : parts)
      layers.copyViews(*part.source->layers, part.source->numbers(part.first, part.end), part.offset);
    for (const Part& part : parts)
      if (const auto labels = part.source->layers->regionLabels(); !labels.empty()) {
        layers.putRegionLabels(labels);
        break;
      }
    for (const AreaEdit& edit : first.layers->edits()) layers.addEdit(edit);
    for (const ObjectEdit& edit : first.layers->objectEdits()) layers.addObjectEdit(edit);
    namesRooms_ =
        std::ranges::any_of(parts, [](const Part& part) { return part.source->map.predictions.has_value(); });
    WorldOptions options = MapTerms(first.store).options().value_or(WorldOptions{});
    options.layers = layersOf(parts);
    world_.emplace(*session_, options);
  }
  ~NewMap() {
    world_.reset();
    session_.reset();
    removeDraft(path_);
  }
  NewMap(const NewMap&) = delete;
  NewMap& operator=(const NewMap&) = delete;

  WorldMapper& world() { return *world_; }
  std::size_t places() const { return session_->mapper().nodes(); }

  /// Maps a drive anew, as if it came after those before.
  void map(const Part& part, Progress& progress) {
    beginDrive(part, cv::Affine3d::Identity(), true);
    forEachFrame(part, progress, [&](std::size_t i, const Frame& frame, const LexicalDescriptor& words) {
      session_->add(frame, words, [&] { return part.source->image(i); });
    });
  }

  /// Takes a drive and its places over; `toMerged`: from its source's map to this one, where known.
  void replay(const Part& part, const std::optional<cv::Affine3d>& toMerged, int firstNode,
              Progress& progress) {
    beginDrive(part, toMerged, false);
    const TopologicalMap& map = part.source->map;
    auto decision = map.decisions.begin();
    forEachFrame(part, progress, [&](std::size_t i, const Frame& frame, const LexicalDescriptor& words) {
      while (decision != map.decisions.end() && decision->frame < i) ++decision;
      Decision known{.node = map.frames[i].node, .current = map.frames[i].node};
      if (decision != map.decisions.end() && decision->frame == i) known = *decision;
      for (int* node : {&known.node, &known.current, &known.other})
        if (*node >= 0) *node += firstNode;
      session_->impl_->replay(frame, words, part.source->image(i), known);
    });
  }

  /// After all drives were replayed.
  void mergePlaces(const std::vector<std::unique_ptr<MapSource>>& sources, const MergePlan& plan) {
    MappingSession::Impl& session = *session_->impl_;
    MapperMerge merge(session.mapper.impl());
    const std::size_t last = session.mapper.frames() - 1;
    std::size_t offset = 0;
    int node = 0;
    for (const std::size_t number : plan.order) {
      const MapSource& source = *sources[number];
      const int firstNode = plan.firstNode[number];
      const Mapper own = restoreMapper(source.store);
      merge.take(own.impl(),
                 {firstNode, [&](std::size_t frame) { return offset + source.map.indexOf(frame); },
                  [&plan](int id) { return plan.kept(id); }});
      for (Merge before : source.map.merges) {
        before.frame += offset;
        for (int* end : {&before.kept, &before.absorbed}) *end += firstNode;
        session.mapper.impl().changes.events.emplace_back(before);
      }
      offset += source.map.frames.size();
      node = plan.kept(firstNode + source.map.frames.back().node);
    }
    for (Merge now : plan.merges) {
      now.frame = last;
      session.mapper.impl().changes.events.emplace_back(now);
    }
    merge.finish(node, [&session](std::size_t frame) { return session.store.pose(frame); });
  }

  void finish() {
    session_->finish();
    world_->finish();
  }

  /// Sum of the maps' budgets, if each has one.
  void takeBudgetsOf(const std::vector<std::unique_ptr<MapSource>>& sources) {
    MapBudget sum{0, 0};
    for (const auto& source : sources) {
      const MapBudget own = budgetOf(source->store);
      sum.memory = sum.memory && own.memory ? std::optional(*sum.memory + *own.memory) : std::nullopt;
      sum.file = sum.file && own.file ? std::optional(*sum.file + *own.file) : std::nullopt;
    }
    if (sum == MapBudget{}) return;
    session_->setBudget(sum);
    session_->impl_->write();
  }

  /// Its last drive is that of the source: it goes on with the same camera.
  void takeCameraOf(const MapSource& source) {
    MapStore& store = session_->impl_->store;
    MapTerms(store).keepCameraOf(MapTerms(source.store));
    store.commit();
  }

  /// To its place, or that of the map `old`, which no other process writes; then with its mode.
  void move(const fs::path& place, std::optional<MapStore>& old) {
    world_.reset();
    session_.reset();
    if (namesRooms_) renewRoomsByNames(path_);            // before the map is visible to others
    if (!old) return storage::renameToNew(path_, place);  // which another program may have made meanwhile
    fs::permissions(path_, fs::status(place).permissions());
    old.reset();  // what SQLite keeps beside the file goes with it
    fs::rename(path_, place);
  }

 private:
  /// A drive keeps the poses that it was given, so that it can be gone on with.
  void beginDrive(const Part& part, const std::optional<cv::Affine3d>& toMerged, bool isLost) {
    const Drive& known = part.source->map.drives[part.drive];
    DriveStart start{known.name, known.fingerprint};
    if (toMerged && known.isAligned) {
      start.posesAreInMap = !known.alignment && toMerged->matrix == cv::Affine3d::Identity().matrix;
      if (!start.posesAreInMap) start.alignment = poseOf(*toMerged * part.source->alignment(part.drive));
    }
    session_->impl_->beginDrive(start, isLost);
    world_->beginDrive();
  }

  template <class Take>
  void forEachFrame(const Part& part, Progress& progress, Take take) {
    for (std::size_t i = part.first; i < part.end; ++i) {
      if (interrupted()) throw Interrupted("stopped; nothing was changed");
      Frame frame = part.source->map.frames[i];
      if (const auto given = part.source->givenPose(i)) frame.pose = given;
      const LexicalDescriptor words = part.source->descriptor(i);
      world_->observe(frame, words, part.source->observation(i));
      take(i, frame, words);
      progress.advance();
    }
  }

  bool namesRooms_ = false;  ///< one of the maps does
  fs::path path_;
  std::optional<MappingSession> session_;
  std::optional<WorldMapper> world_;
};

namespace {

/// Parts of the maps in this order, without one drive.
std::vector<Part> partsOf(const std::vector<std::unique_ptr<MapSource>>& sources,
                          const std::vector<std::size_t>& order, std::optional<std::size_t> but = {}) {
  std::vector<Part> parts;
  std::size_t offset = 0;
  for (const std::size_t number : order) {
    const auto& source = sources[number];
    for (std::size_t drive = 0; drive < source->map.drives.size(); ++drive) {
      if (drive == but) continue;
      const Part part{source.get(),       number, drive, source->map.drives[drive].firstFrame,
                      source->end(drive), offset};
      offset += part.end - part.first;
      parts.push_back(part);
    }
  }
  return parts;
}

std::size_t framesOf(const std::vector<Part>& parts) {
  return parts.back().offset + parts.back().end - parts.back().first;
}

/// Parts of all maps but the first, in the given order.
std::vector<MergedMaps::Part> partsOfMerged(const std::vector<std::unique_ptr<MapSource>>& sources,
                                            const MergePlan& plan) {
  std::vector<MergedMaps::Part> parts(sources.size());
  std::set<int> before;
  for (const std::size_t number : plan.order) {
    const MapSource& source = *sources[number];
    std::set<int> own;
    for (const Node& node : source.map.nodes) own.insert(plan.kept(plan.firstNode[number] + node.id));
    parts[number] = {std::ranges::any_of(own, [&before](int id) { return before.contains(id); }),
                     plan.toMerged[number].has_value(), source.hasPoses()};
    before.merge(own);
  }
  parts.erase(parts.begin());
  return parts;
}

/// Gives people's corrections of an aligned map to the merged one. They may contradict those of the maps
/// before.
void giveCorrections(const MapSource& source, const cv::Affine3d& toMerged, NewMap& merged,
                     const fs::path& file, std::vector<std::string>& conflicts) {
  const auto isCalledElse = [&](const char* what, const std::string& name, const std::string& known) {
    if (known.empty() || known == name) return false;
    conflicts.push_back(fmt::format("{} calls {} \"{}\" that is called \"{}\" already: that is kept",
                                    file.string(), what, printable(name), known));
    return true;
  };
  WorldMap own{source.map};
  source.layers->read(own);
  for (AreaEdit edit : source.layers->edits()) {
    if (!own.plan) break;
    const WorldMap now = merged.world().read();
    if (!now.plan) break;
    for (cv::Point2d* at : {&edit.from, &edit.to}) {
      const cv::Point3d point = toMerged * own.plan->floor.point({at->x, at->y, 0});
      *at = now.plan->floor.position({point.x, point.y, point.z});
    }
    if (edit.kind == AreaEdit::Kind::name) {
      const WorldArea* area = now.findArea(areaAt(*now.plan, edit.from, 0));
      if (area != nullptr && isCalledElse("an area", edit.name, area->givenName)) continue;
    }
    try {
      merged.world().edit(edit);
    } catch (const Error& e) {  // it cuts or joins nothing here
      if (e.code() != ErrorCode::invalidInput) throw;
    }
  }
  for (ObjectEdit edit : source.layers->objectEdits()) {
    edit.center = toMerged * edit.center;
    if (edit.kind == ObjectEdit::Kind::name) {
      const WorldMap now = merged.world().read();
      const WorldObject* known = now.findObject(objectOf(edit, now.objects));
      if (known != nullptr && isCalledElse("an object", edit.name, known->givenName)) continue;
    }
    merged.world().edit(edit);
  }
}

}  // namespace

MergedMaps mergeMaps(std::span<const fs::path> maps, const fs::path& wanted, ExistingMap existing,
                     Progress& progress, ShareWork share) {
  if (maps.size() < 2) fail(ErrorCode::invalidInput, "give two maps or more to merge");
  if (!share.run)
    share.run = [&progress](std::size_t pieces, const std::function<std::string(std::size_t)>& work) {
      std::vector<std::string> results(pieces);
      progress.begin("comparing maps", pieces, 0);
      inParallel(pieces, 0, progress, "stopped; nothing was changed",
                 [&](std::size_t piece) { results[piece] = work(piece); });
      progress.end();
      return results;
    };
  if (!share.leads) {
    linkMaps(maps, share, {});
    return {};
  }
  fs::path output = wanted;
  std::optional<MapStore> old;
  if (fs::exists(wanted)) {
    if (existing == ExistingMap::refuse)
      fail(ErrorCode::fileExists, "{} exists; give another name, or --overwrite", wanted.string());
    output = fs::canonical(wanted);  // what a link leads to
    old.emplace(MapStore::open(output, MapStore::Access::write));
  }
  std::vector<std::unique_ptr<MapSource>> sources;
  for (const fs::path& map : maps) {
    auto source = std::make_unique<MapSource>(map);
    for (const auto& before : sources) requireMergeable(*before, *source);
    sources.push_back(std::move(source));
  }
  const MergePlan plan = planMerge(
      sources, linkMaps(maps, share, [&](std::size_t number) { return sources[number]->store.frameCount(); }),
      progress);
  const std::vector<Part> parts = partsOf(sources, plan.order);
  NewMap merged(output, *sources.front(), parts);
  progress.begin("merging", framesOf(parts), 0);
  for (const Part& part : parts)
    merged.replay(part, plan.toMerged[part.number], plan.firstNode[part.number], progress);
  merged.mergePlaces(sources, plan);
  merged.finish();
  merged.takeBudgetsOf(sources);
  MergedMaps done{parts.size(), framesOf(parts), merged.places(), partsOfMerged(sources, plan),
                  goneOptionsIn(sources.front()->store)};
  for (const std::size_t number : plan.order)
    if (number != plan.order.front() && plan.toMerged[number])
      giveCorrections(*sources[number], *plan.toMerged[number], merged, maps[number], done.conflicts);
  merged.takeCameraOf(*sources[plan.order.back()]);
  progress.end();
  sources.clear();
  merged.move(output, old);
  return done;
}

std::vector<std::string> undoDrive(const fs::path& file, std::size_t drive, Progress& progress) {
  // no other process writes it now
  std::optional<MapStore> writer(MapStore::open(file, MapStore::Access::write));
  const fs::path map = fs::canonical(file);  // what a link leads to
  std::vector<std::unique_ptr<MapSource>> sources;
  sources.push_back(std::make_unique<MapSource>(map));
  const std::size_t drives = sources.front()->map.drives.size();
  if (drive >= drives)
    fail(ErrorCode::unknownName, "{} has no drive {}; it has {}, numbered from 0", map.string(), drive,
         drives);
  if (drives == 1)
    fail(ErrorCode::insufficientData, "{} has no other drive; remove the file instead", map.string());
  const std::vector<Part> parts = partsOf(sources, {0}, drive);
  NewMap without(map, *sources.front(), parts);
  without.takeBudgetsOf(sources);
  progress.begin("mapping the other drives", framesOf(parts), 0);
  for (const Part& part : parts) without.map(part, progress);
  without.finish();
  if (drive + 1 < drives) without.takeCameraOf(*sources.front());
  progress.end();
  std::vector<std::string> gone = goneOptionsIn(sources.front()->store);
  sources.clear();
  without.move(map, writer);
  return gone;
}

}  // namespace estancia
