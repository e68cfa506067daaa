// estancia map: images, with depth or without → places, zones, areas and objects.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <map>
#include <memory>
#include <optional>

#include "common.hpp"
#include "described.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world/sequence_layers.hpp"
#include "estancia/world_file/world_options.hpp"
#include "known_object_arguments.hpp"
#include "labeling.hpp"
#include "map_faults.hpp"
#include "map_names.hpp"
#include "skipped.hpp"
#include "tracked.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

struct MapArguments {
  explicit MapArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  ModelArguments model;
  MapperOptions mapper;
  MapBudget budget;
  WorldOptions world;
  DeclaredOptions declared;
  std::string output, roomClassifier, objectModel;
  KnownObjectArguments objects;
  /// Rooms to predict by name.
  std::vector<std::string> rooms;
  bool goOn = false, overwrite = false, posesInMap = false, json = false;
};

/// Names the places of the finished map by a classifier.
void classifyRooms(const MapArguments& arguments, const RoomClassifier& classifier,
                   const Sequence* sequence) {
  const auto later = [&arguments, sequence](const std::exception& why) {
    return fmt::format("{}; the map is in {}, name its places by `estancia classify name {} {}{}`",
                       why.what(), arguments.output, arguments.roomClassifier, arguments.output,
                       sequence == nullptr ? "" : " " + arguments.sequence.path);
  };
  try {
    FeatureSource describing(arguments.model);
    nameRooms(arguments.output, classifier, sequence, describing);
  } catch (const Interrupted& e) {
    throw Interrupted(later(e));
  } catch (const Error& e) {
    throw Error(e.code(), later(e));
  }
}

/// Names them by the rooms' names alone, unless raw words are wanted. Returns whether they are.
bool nameRoomsWithoutExample(const MapArguments& arguments, const WorldOptions& options) {
  if (!arguments.rooms.empty()) {
    nameRoomsByNames(arguments.output, arguments.rooms);
    return true;
  }
  return options.areas.naming.words == NamingOptions::Words::wordNet && renewRoomsByNames(arguments.output);
}

/// Printed when all work is done, since progress bars would come in between.
struct Summary {
  Json json;
  std::string text;
};

void addRooms(const MapArguments& arguments, Summary& summary) {
  std::map<std::string, std::size_t> places;
  for (const Place& place : placesOf(readMap(arguments.output)))
    if (const RoomProbability* room = place.predictedRoom()) ++places[room->room];
  summary.json["predicted_rooms"] = places;
  for (const auto& [room, count] : places)
    summary.text += fmt::format("  {:<24} {}\n", room, counted(count, "place"));
}

/// How the camera was tracked, if it was, and what was wrong with the drive.
struct Odometry {
  std::optional<RgbdTrajectory> trajectory;
  MapLevel level;
  DriveFaults faults;
};

/// Adds the map's upward direction to the summary.
void addLevel(const MapLevel& level, Summary& summary) {
  if (!level.byPlanes)
    spdlog::warn(
        "no floor, table or walls were seen that tell which way is up: the camera is taken for upright; "
        "heights, and what stands on what, may be off");
  else
    summary.text += fmt::format(
        "  leveled by floor, tables and walls; the first camera was tilted by {:.1f}°\n", level.tilt);
  summary.json["leveled_by"] = level.byPlanes ? "planes" : "camera";
  summary.json["first_camera_tilt"] = level.tilt;
}

Summary summaryOf(const MapArguments& arguments, const RgbdTrajectory& odometry, const MapLevel& level) {
  std::optional<TopologicalMap> map;
  const auto nameOf = [&](std::size_t frame) {
    if (!map) map = readMap(arguments.output);
    return map->frames.at(frame).name;
  };
  warnOfUntracked(odometry, nameOf, "a steady motion");
  const std::size_t untracked = odometry.lost.size() + odometry.bridged.size();
  Summary summary;
  summary.text =
      fmt::format("  tracked {} of {} by RGB-D odometry, {} closed\n", odometry.poses.size() - untracked,
                  counted(odometry.poses.size(), "frame"), counted(odometry.loops.size(), "loop"));
  addCounts(summary.json, odometry);
  addLevel(level, summary);
  addUntracked(summary.json, odometry, nameOf);
  return summary;
}

Summary summaryOf(const MapArguments& arguments, const MapRun& map, std::size_t skipped,
                  const Odometry& odometry) {
  const MappingSession& session = *map.session();
  const Mapper& mapper = session.mapper();
  std::string text =
      fmt::format("{}: {}, {}, {} (τ_join {:.3g}, τ_revisit {:.3g})\n", printable(arguments.output),
                  counted(session.frames(), "frame"), counted(mapper.nodes(), "place"),
                  counted(mapper.transitions().size(), "transition"), mapper.thresholds().join,
                  mapper.thresholds().revisit);
  Json json{{"map", arguments.output},
            {"frames", session.frames()},
            {"new_frames", session.frames() - map.framesBefore()},
            {"skipped", skipped},
            {"nodes", mapper.nodes()},
            {"transitions", mapper.transitions().size()},
            {"tau_join", mapper.thresholds().join},
            {"tau_revisit", mapper.thresholds().revisit}};
  if (const Json faults = faultsOf(odometry.faults); !faults.empty()) json["faults"] = faults;
  if (odometry.trajectory) {
    Summary tracked = summaryOf(arguments, *odometry.trajectory, odometry.level);
    json["odometry"] = std::move(tracked.json);
    text += tracked.text;
  }
  return {std::move(json), std::move(text)};
}

/// Why there are no areas and objects although there is depth, or although they were asked for.
void sayWhatIsMissing(const Sequence& sequence, const WorldOptions& options) {
  const bool asked = options.layers && (options.layers->areas || options.layers->objects);
  if (options.layers && !asked) return;
  const std::string what = !sequence.hasDepth()     ? "depth images"
                           : !sequence.intrinsics() ? "the camera of the depth images; give --intrinsics"
                                                    : "";
  if (what.empty()) return;
  if (asked)
    throw Error(ErrorCode::insufficientData,
                fmt::format("areas and objects need {}",
                            sequence.hasDepth() ? what : "depth, and " + sequence.name() + " has none"));
  if (sequence.hasDepth()) spdlog::info("no areas and objects without {}", what);
}

/// Reports faults of the drive. Returns how the camera was tracked.
Odometry odometryOf(const WorldMapper* mapper) {
  if (mapper == nullptr) return {};
  warnOfFaults(mapper->faults());
  if (const std::size_t views = mapper->viewsTooFar(); views > 0)
    spdlog::warn(
        "{} too far from the others for a floor plan and left out of it; `estancia check` looks at the poses",
        views == 1 ? "1 view is" : fmt::format("{} views are", views));
  return {mapper->odometry(), mapper->level().value_or(MapLevel{}), mapper->faults()};
}

struct Added {
  std::size_t skipped = 0;
  Odometry odometry;
};

/// The given options; for all others a continued map keeps its own.
WorldOptions worldOptions(const MapArguments& arguments, MapRun& map) {
  WorldOptions options = arguments.world;
  if (!map.session()) return options;
  if (const auto kept = WorldMapper::optionsOf(map.start())) {
    options = *kept;
    arguments.declared.applyTo(declare(options));
  }
  return options;
}

SequenceLayers layersOf(const WorldOptions& options, Labeling& labeling, const ObjectNamers& namers,
                        MapRun& map, Skipped& withoutDepth) {
  const auto started = [&namers](WorldMapper& mapper, bool camera) {
    namers.giveTo(mapper);
    if (camera && !mapper.tracks() && (mapper.layers().areas || mapper.layers().objects))
      spdlog::info("no areas and objects: the map was begun without odometry; map anew to have them");
  };
  SequenceLayers layers(labeling.sequence(), labeling.labeler(), map,
                        {.change = [options](WorldOptions& kept) { kept = options; },
                         .started = started,
                         .withoutDepth = [&withoutDepth](const std::string& why) { withoutDepth.add(why); }});
  sayWhatIsMissing(labeling.sequence(), options);
  return layers;
}

/// Adds the labeled frames from `first` on.
Added addFrames(const MapArguments& arguments, Labeling& labeling, std::size_t first, bool images,
                const ObjectNamers& namers, MapRun& map) {
  if (map.session())
    for (const std::string& gone : WorldMapper::goneOptionsOf(map.start())) spdlog::warn("{}", gone);
  Skipped withoutDepth("no depth");
  SequenceLayers layers = layersOf(worldOptions(arguments, map), labeling, namers, map, withoutDepth);
  const auto finish = [&layers] {
    layers.finish();
    return odometryOf(layers.mapper());
  };
  try {
    const std::size_t skipped =
        labeling.forEach(first, "mapping", [&](const LabeledFrame& frame) { layers.add(frame, images); });
    return {skipped, finish()};
  } catch (const Interrupted& e) {
    if (!map.session()) throw;
    finish();
    throw Interrupted(
        fmt::format("{}; they are kept in {}, go on with --continue", e.what(), arguments.output));
  }
}

/// The rooms of a map that is continued are predicted by the classifier that is given, and of all frames.
void warnOfMissingRooms(const MapArguments& arguments, std::size_t newFrames) {
  const TopologicalMap map = readMap(arguments.output);
  if (newFrames == 0 || !map.predictions) return;
  const std::string file = printable(arguments.output);
  if (map.predictions->areByName) {
    spdlog::warn("{} have no room, the others have; run `estancia classify name {}`",
                 counted(newFrames, "new frame"), file);
    return;
  }
  spdlog::warn(
      "{} are not named by the room classifier that named the places of {} before; run `estancia classify "
      "name CLASSIFIER {}{}`",
      counted(newFrames, "new frame"), file, file,
      isDescriptorFile(arguments.sequence.path) ? "" : " " + printable(arguments.sequence.path));
}

void run(const MapArguments& arguments) {
  const bool images = !isDescriptorFile(arguments.sequence.path);
  const auto classifier = openRoomClassifier(arguments.roomClassifier, arguments.sequence);
  if (!arguments.rooms.empty()) requireRoomNames(arguments.rooms);
  const ObjectNamers namers(arguments.objects.files(), arguments.objectModel);
  std::optional<MapRun> map(std::in_place, arguments.output,
                            arguments.goOn        ? MapRun::Existing::resume
                            : arguments.overwrite ? MapRun::Existing::replace
                                                  : MapRun::Existing::refuse);
  map->changeBudget([&arguments](MapBudget& budget) { arguments.declared.applyTo(declare(budget)); });
  const std::optional<Vocabulary> words = map->vocabulary();
  Labeling labeling(arguments.sequence, arguments.model, words ? &*words : nullptr);
  const Sequence& sequence = labeling.sequence();
  const std::size_t first = map->begin(
      sequence, labeling.vocabulary(), labeling.identity(),
      [&arguments](MapperOptions& options) {
        if (!arguments.declared.preset().empty()) options = MapperOptions::thesis();
        arguments.declared.applyTo(declare(options));
      },
      arguments.posesInMap);
  const Added added = addFrames(arguments, labeling, first, images, namers, *map);
  Summary summary = summaryOf(arguments, *map, added.skipped, added.odometry);
  const std::size_t newFrames = map->session()->frames() - map->framesBefore();
  const WorldOptions options = worldOptions(arguments, *map);
  map.reset();  // the rooms are written into its file
  summary.text += namers.addNames(arguments.output, summary.json);
  if (classifier) classifyRooms(arguments, *classifier, images ? &sequence : nullptr);
  if (classifier || nameRoomsWithoutExample(arguments, options))
    addRooms(arguments, summary);
  else if (arguments.goOn)
    warnOfMissingRooms(arguments, newFrames);
  if (arguments.json)
    print(summary.json);
  else
    fmt::print("{}", summary.text);
}

}  // namespace

void addMapCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("map", "Turn a sequence of images into a topological map");
  auto arguments = std::make_shared<MapArguments>(*command);
  arguments->sequence.addTo(arguments->declared);
  arguments->sequence.addDepthTo(arguments->declared);
  addOutputOption(*command, arguments->output, "The map file, NAME.estancia")->required();
  arguments->model.addTo(arguments->declared, "The model that labels the images");
  arguments->objects.addTo(
      *command,
      "Cloud of a known object: FILE or NAME=FILE; its name and pose are added to the objects that it is; "
      "may be given repeatedly");
  command
      ->add_option("--object-model", arguments->objectModel,
                   "Shape classifier, of `estancia objects train`: its classes are added to the objects")
      ->type_name("FILE");
  addRoomClassifierOption(*command, arguments->roomClassifier);
  addRoomsByNameOption(*command, arguments->rooms);
  command->add_flag(
      "--continue", arguments->goOn,
      "Go on with the map: where an earlier run stopped in this sequence, or with another drive, "
      "whose start is not known");
  addPosesInMapOption(*command, arguments->posesInMap);
  addOverwriteOption(*command, arguments->overwrite)
      ->description("Replace an existing map, from the first image that is mapped")
      ->excludes("--continue");
  arguments->declared.add(declare(arguments->mapper),
                          {"distance", "tau-join", "tau-revisit", "transition-images"});
  arguments->declared.add(declare(arguments->budget), {"memory", "file-budget"});
  arguments->declared.add(declare(arguments->world), {"layers", "areas.naming.words"});
  arguments->declared.addPreset(
      {{"thesis", "the choices of Rangel's thesis (chapter 4)"}},
      [&mapper = arguments->mapper](const std::string&) { mapper = MapperOptions::thesis(); });
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia map ~/photos -o home.estancia\n"
              "  estancia map drive.mp4 -o drive.estancia --poses drive.txt\n"
              "  estancia map ~/photos -o home.estancia --continue\n"
              "  estancia map ~/evening -o home.estancia --continue\n"
              "  estancia map ~/month -o home.estancia --continue --file-budget 500\n"
              "  estancia map ~/photos -o home.estancia --room-classifier rooms.classifier\n"
              "  estancia map ~/photos -o home.estancia --rooms-by-name kitchen,bedroom,bathroom,office\n"
              "  estancia map ~/drive -o home.estancia --object mug.pcd --object-model home.objects");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
