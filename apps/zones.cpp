// estancia zones: images → areas that name themselves.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "common.hpp"
#include "described.hpp"
#include "estancia/classify/zero_shot_rooms.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/room_words.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/zones/measure.hpp"
#include "estancia/zones/naming.hpp"
#include "estancia/zones/zone_stream.hpp"
#include "estancia/zones/zones.hpp"
#include "labeling.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using report::counted;

struct ZonesArguments {
  explicit ZonesArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  ModelArguments model;
  ZoneOptions options;
  ZoneStreamOptions streaming;
  DeclaredOptions declared;
  std::string output, roomClassifier;
  /// Rooms to predict by name.
  std::vector<std::string> rooms;
  bool stream = false, overwrite = false, json = false;
};

/// Memory of the clustering, known before any image is labeled; and whether it fits.
void sayMemory(std::size_t images, std::size_t labels) {
  requireClusteringMemory(images, labels);
  const double mebibytes = static_cast<double>(clusteringMemory(images, labels)) / (1 << 20);
  spdlog::info(
      "zones of {} in {} take {} of memory", counted(images, "image"), counted(labels, "word"),
      mebibytes < 1024 ? fmt::format("{:.0f} MiB", mebibytes) : fmt::format("{:.1f} GiB", mebibytes / 1024));
}

/// Zones while the images come, and what is printed of them.
class PrintingStream {
 public:
  PrintingStream(const Vocabulary& words, const ZonesArguments& arguments)
      : zones_(words, arguments.options, arguments.streaming), json_(arguments.json) {}

  void add(const Frame& frame, DescriptorView descriptor) {
    const int zone = zones_.add(descriptor);
    if (json_) print({{"image", frame.name}, {"zone", zone}, {"zones", zones_.zoneCount()}});
    if (zone == last_) return;
    last_ = zone;
    if (json_) return;
    fmt::print("{}: zone {} ({}), one of {}\n", frame.name, zone, zones_.nameOf(zone), zones_.zoneCount());
  }

  ZoneStream& zones() { return zones_; }

 private:
  ZoneStream zones_;
  bool json_;
  int last_ = -1;
};

bool isMap(const ZonesArguments& arguments) {
  return isMapFile(arguments.sequence.path) || arguments.sequence.path.ends_with(".estancia");
}

/// The words of all images. With --stream the zones follow as they come, else the memory is asked for first.
DescriptorSequence recordingOf(const ZonesArguments& arguments, std::optional<PrintingStream>& stream) {
  const auto begin = [&](std::size_t images, const Vocabulary& words) {
    if (arguments.stream)
      stream.emplace(words, arguments);
    else
      sayMemory(images, words.size());
  };
  const std::string& path = arguments.sequence.path;
  if (isMap(arguments)) {
    if (!arguments.model.model.empty())
      throw Error(ErrorCode::invalidOption, fmt::format("{} holds labels already; leave out --model", path));
    if (const auto& given = arguments.sequence.options;
        !given.poses.empty() || !given.rooms.empty() || !given.split.empty() || !given.only.empty())
      throw Error(
          ErrorCode::invalidOption,
          fmt::format("{} knows its frames, their poses and rooms; leave out --poses, --rooms, --split and "
                      "--only",
                      path));
    DescriptorSequence recording = readMapDescriptors(path);
    begin(recording.frames.size(), recording.vocabulary);
    for (std::size_t i = 0; stream && i < recording.frames.size(); ++i)
      stream->add(recording.frames[i], recording.descriptors.row(i));
    return recording;
  }
  Labeling labeling(arguments.sequence, arguments.model);
  begin(labeling.sequence().size(), labeling.vocabulary());
  DescriptorSequence recording{
      labeling.vocabulary(), labeling.identity(), {}, DescriptorMatrix(labeling.vocabulary().size())};
  try {
    labeling.forEach(0, stream ? nameBesideResults("labeling") : "labeling", [&](const LabeledFrame& frame) {
      recording.frames.push_back(labeling.sequence().frame(frame.index));
      recording.descriptors.append(frame.descriptor);
      if (stream) stream->add(recording.frames.back(), frame.descriptor);
    });
  } catch (const Interrupted& e) {
    if (stream && !recording.frames.empty()) {
      writeZones(stream->zones().finish(recording), arguments.output);
      throw Interrupted(fmt::format("{}; the zones until then are in {}", e.what(), arguments.output));
    }
    if (arguments.model.noCache || isDescriptorFile(path)) throw;
    throw Interrupted(fmt::format("{}; their labels are kept in the cache: run it again to go on", e.what()));
  }
  return recording;
}

Zones clustered(const DescriptorSequence& recording, const ZoneOptions& options) {
  const auto progress = makeStderrProgress();
  try {
    return findZones(recording, options, *progress);
  } catch (const Interrupted& e) {
    throw Interrupted(fmt::format("{}; run it again, nothing is labeled twice", e.what()));
  }
}

/// Names the zones by the answers of `classifier` for their images.
void name(Zones& zones, const DescriptorSequence& recording, const RoomClassifier& classifier,
          const ZonesArguments& arguments) {
  const std::string& path = arguments.sequence.path;
  const auto sequence = holdsNumbers(path) ? nullptr : arguments.sequence.openQuietly();
  FeatureSource describing(arguments.model);
  nameRooms(zones, describing.rooms(classifier, recording, sequence.get()));
}

/// Names them by the rooms' names alone, unless raw words are wanted.
void nameWithoutExample(Zones& zones, const DescriptorSequence& recording, const ZonesArguments& arguments,
                        const ZoneOptions& options) {
  const bool isListed = !arguments.rooms.empty();
  const bool isWanted = isListed || options.naming.words == NamingOptions::Words::wordNet;
  const WordGraph* graph = isWanted ? installedWordGraph() : nullptr;
  if (graph == nullptr) return;
  try {
    nameRooms(zones, predictRoomsByNames(*graph, recording.vocabulary, recording.descriptors,
                                         listedRooms(arguments.rooms)));
  } catch (const Error& e) {
    if (isListed || e.code() != ErrorCode::unknownName) throw;  // a WordNet without the common rooms
  }
}

double shareOf(const Zone& zone, const Zones& zones) {
  return static_cast<double>(zone.images.size()) / static_cast<double>(zones.frames.size());
}

void printJson(const std::string& file, const Zones& zones, const NamingOptions& naming,
               const std::vector<Measure>& measures, const std::optional<StreamAgreement>& exact) {
  constexpr std::size_t wordsOfZone = 10;
  Json json{{"file", file}};
  json.update(toJson(zones, wordsOfZone, *installedConcepts(zones.vocabulary, naming)));
  json["measures"] = toJson(measures);
  if (exact)
    json["exact"] = {{"images", exact->images},
                     {"zones", exact->zones},
                     {"ari", exact->agreement.adjustedRandIndex},
                     {"v_measure", exact->agreement.vMeasure}};
  print(json);
}

void printTable(const std::string& file, const Zones& zones, const std::vector<Measure>& measures,
                const std::optional<StreamAgreement>& exact) {
  fmt::print("{}: {} of {} ({}, {} linkage, cut at {:.3g}: {})\n\n", printable(file),
             counted(zones.zones.size(), "zone"), counted(zones.frames.size(), "image"), zones.distance,
             zones.linkage, zones.cut, zones.cutReason);
  fmt::print("zone  images   share  words\n");
  constexpr std::size_t shown = 40;
  for (const Zone& zone : zones.zones) {
    if (zone.id == shown) {
      fmt::print("… and {}; --json tells all\n", counted(zones.zones.size() - shown, "smaller one"));
      break;
    }
    const std::string room =
        zone.room.empty() ? "" : fmt::format("  ({}, {:.0f} %)", zone.room, 100 * zone.roomShare);
    const std::string taken = zone.predicted.empty() ? "" : "  taken for " + describeRooms(zone.predicted, 1);
    fmt::print("{:>4}  {:>6}  {:>4.1f} %  {}{}{}\n", zone.id, zone.images.size(), 100 * shareOf(zone, zones),
               describedName(zone), room, taken);
  }
  fmt::print("\n");
  print(measures);
  if (exact)
    fmt::print(
        "\nExact zones of {} of {} at once: {}; agreement with the stream's: ARI {:.3f}, V-measure "
        "{:.3f}\n",
        exact->images, counted(zones.frames.size(), "image"), exact->zones,
        exact->agreement.adjustedRandIndex, exact->agreement.vMeasure);
}

void run(const ZonesArguments& arguments) {
  ZoneOptions options = arguments.options;
  if (!options.reach && !arguments.stream && isMap(arguments)) options.reach = ZoneOptions::reachOfRun;
  validate(options);  // before anything is labeled
  comparisonFor(getDistance(options.distance), getLinkage(options.linkage));
  requireReplaceable(arguments.output, arguments.overwrite, isZoneFile, "zone file");
  if (!arguments.rooms.empty()) requireRoomNames(arguments.rooms);
  const auto classifier = openRoomClassifier(arguments.roomClassifier, arguments.sequence);
  std::optional<PrintingStream> stream;
  const DescriptorSequence recording = recordingOf(arguments, stream);
  Zones zones = stream ? stream->zones().finish(recording) : clustered(recording, options);
  if (classifier)
    name(zones, recording, *classifier, arguments);
  else
    nameWithoutExample(zones, recording, arguments, options);
  writeZones(zones, arguments.output);
  const std::vector<Measure> measures = measuresOf(evaluate(zones));
  std::optional<StreamAgreement> exact;
  if (stream)
    exact = compareWithExact(recording, stream->zones().zoneOf(), options, 5000, *makeStderrProgress());
  if (arguments.json)
    printJson(arguments.output, zones, arguments.options.naming, measures, exact);
  else
    printTable(arguments.output, zones, measures, exact);
}

}  // namespace

void addZonesCommand(CLI::App& app) {
  CLI::App* group =
      app.add_subcommand("zones", "Find semantic zones: the areas of a sequence, named by words");
  group->require_subcommand(1);
  addExamples(*group, "  estancia zones find ~/photos -o home.zones");
  CLI::App* command = group->add_subcommand("find", "Find the areas of a sequence, each named by its words");
  auto arguments = std::make_shared<ZonesArguments>(*command);
  arguments->sequence.addTo(arguments->declared);
  command->get_option("SEQ")->description(
      "Image folder, video file, data set, folder of panoramas, label file, or a map (*.estancia), whose "
      "labels are used");
  addOutputOption(*command, arguments->output, "The file of zones, NAME.zones")->required();
  // Rooms differ by their objects more than places do, and the detector adds these (docs/how-to/zones.md).
  arguments->model.byDefault = "inception-v3+coco-ssd";
  arguments->model.addTo(arguments->declared, "The model that labels the images");
  addRoomClassifierOption(*command, arguments->roomClassifier);
  addRoomsByNameOption(*command, arguments->rooms);
  command->add_flag(
      "--stream", arguments->stream,
      "Print when the zone changes while images come (with --json the zone of each), in time and memory "
      "that do not grow with their square; the file's zones are numbered by size in the end");
  addOverwriteOption(*command, arguments->overwrite);
  arguments->declared.add(declare(arguments->options),
                          {"distance", "linkage", "cut", "count", "naming.words"});
  arguments->declared.add(declare(arguments->streaming));
  arguments->declared.addPreset(
      {{"thesis", "the choices of Rangel's thesis (one network, ks, average linkage, cut 0.5)"}},
      [&options = arguments->options, &model = arguments->model](const std::string&) {
        options = ZoneOptions::thesis();
        model.byDefault = defaultModel;
      });
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia zones find ~/photos -o home.zones\n"
              "  estancia zones find home.estancia -o home.zones --count 8\n"
              "  estancia zones find drive.mp4 -o drive.zones --stream\n"
              "  estancia zones find images.labels -o thesis.zones --preset thesis\n"
              "  estancia zones find ~/photos -o home.zones --room-classifier rooms.classifier");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
