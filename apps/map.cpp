// estancia map: images → topological map.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <map>
#include <optional>

#include "common.hpp"
#include "described.hpp"
#include "estancia/core/error.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/io/image_writer.hpp"
#include "estancia/report/text.hpp"
#include "estancia/stats/distance.hpp"
#include "estancia/topology/places.hpp"
#include "estancia/topology/session.hpp"
#include "labeling.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;
using report::counted;

struct Arguments {
  SequenceArguments sequence;
  ModelArguments model;
  std::string output, roomClassifier;
  std::string distance, preset;
  double tauJoin = 0, tauRevisit = 0;
  std::size_t blur = 0;
  bool goOn = false, overwrite = false, json = false;
};

/// `options` changed by what the command line says.
MapperOptions mapperOptions(MapperOptions options, const Arguments& arguments, const CLI::App& command) {
  if (arguments.preset == "thesis") options = MapperOptions::thesis();
  if (!arguments.distance.empty()) options.distance = arguments.distance;
  if (command.count("--tau-join") > 0) options.tauJoin = arguments.tauJoin;
  if (command.count("--tau-revisit") > 0) options.tauRevisit = arguments.tauRevisit;
  if (command.count("--blur") > 0) options.transitionImages = arguments.blur;
  return options;
}

/// Names the places of the finished map.
std::map<std::string, std::size_t> placesPerRoom(const Arguments& arguments, const RoomClassifier& classifier,
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
    throw Error(later(e));
  }
  std::map<std::string, std::size_t> places;
  for (const Place& place : placesOf(readMap(arguments.output)))
    if (!place.predicted.empty()) ++places[place.predicted.front().room];
  return places;
}

void run(const Arguments& arguments, const CLI::App& command) {
  const MapperOptions options = mapperOptions({}, arguments, command);
  getDistance(options.distance);
  const bool images = !isDescriptorFile(arguments.sequence.path);
  const auto classifier = openRoomClassifier(arguments.roomClassifier, arguments.sequence);
  if (fs::exists(arguments.output) && !arguments.goOn && !arguments.overwrite)
    throw Error(
        ErrorCode::fileExists,
        fmt::format("{} exists; continue it with --continue, replace it with --overwrite", arguments.output));
  std::optional<Vocabulary> words;
  const bool goesOn = arguments.goOn && fs::exists(arguments.output);
  if (goesOn) words = readMap(arguments.output).vocabulary;
  Labeling labeling(arguments.sequence, arguments.model, words ? &*words : nullptr);
  const Sequence& sequence = labeling.sequence();
  std::optional<MappingSession> session;
  std::size_t first = 0;
  if (goesOn) {
    session = MappingSession::resume(arguments.output, labeling.vocabulary(), labeling.identity());
    const MapperOptions& kept = session->mapper().options();
    if (mapperOptions(kept, arguments, command) != kept)
      throw Error(ErrorCode::mismatch, fmt::format("{} was made with other settings, which it keeps: leave "
                                                   "out --distance, --tau-join, --tau-revisit, "
                                                   "--blur and --preset, or map anew",
                                                   arguments.output));
    first = firstUnmapped(readMap(arguments.output), sequence);
  }
  const std::size_t before = session ? session->frames() : 0;
  const auto add = [&](const LabeledFrame& frame) {
    if (!session)  // an old map goes only once there is something to put in its place
      session = MappingSession::create(arguments.output, labeling.vocabulary(), labeling.identity(), options,
                                       arguments.overwrite ? ExistingMap::replace : ExistingMap::refuse);
    const auto image = [&] {
      return encodeImage(frame.image.empty() ? sequence.image(frame.index) : frame.image);
    };
    session->add(sequence.frame(frame.index), frame.descriptor,
                 images ? MappingSession::Image(image) : MappingSession::Image());
  };
  std::size_t skipped = 0;
  try {
    skipped = labeling.forEach(first, "mapping", add);
  } catch (const Interrupted& e) {
    if (!session) throw;
    session->finish();
    throw Interrupted(
        fmt::format("{}; they are kept in {}, go on with --continue", e.what(), arguments.output));
  }
  session->finish();

  const Mapper& mapper = session->mapper();
  nlohmann::ordered_json json{{"map", arguments.output},
                              {"frames", session->frames()},
                              {"new_frames", session->frames() - before},
                              {"skipped", skipped},
                              {"nodes", mapper.nodes()},
                              {"transitions", mapper.transitions().size()},
                              {"tau_join", mapper.thresholds().join},
                              {"tau_revisit", mapper.thresholds().revisit}};
  if (!arguments.json)
    fmt::print("{}: {}, {}, {} (τ_join {:.3g}, τ_revisit {:.3g})\n", arguments.output,
               counted(session->frames(), "frame"), counted(mapper.nodes(), "place"),
               counted(mapper.transitions().size(), "transition"), mapper.thresholds().join,
               mapper.thresholds().revisit);
  session.reset();  // the rooms are written into its file
  if (classifier) {
    const auto places = placesPerRoom(arguments, *classifier, images ? &sequence : nullptr);
    json["predicted_rooms"] = places;
    for (const auto& [room, count] : places)
      if (!arguments.json) fmt::print("  {:<24} {}\n", room, counted(count, "place"));
  }
  if (arguments.json) print(json);
}

}  // namespace

void addMapCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("map", "Turn a sequence of images into a topological map");
  arguments->sequence.addTo(*command);
  command->add_option("-o,--output", arguments->output, "The map file, NAME.estancia")->required();
  arguments->model.addTo(*command, "What labels the images");
  addRoomClassifierOption(*command, arguments->roomClassifier);
  command->add_flag("--continue", arguments->goOn, "Go on with the map where an earlier run stopped");
  command->add_flag("--overwrite", arguments->overwrite, "Replace an existing map")->excludes("--continue");
  std::string distances = "Distance of an image to a place:";
  for (const Distance& distance : baseDistances())
    distances += fmt::format("\n{} ({})", distance.name, distance.explanation);
  distances += "\nall but the weighted ones also as NAME-sigma; default: standardized-clr";
  const auto mapping = "Mapping";
  command->add_option("--distance", arguments->distance, distances)->group(mapping);
  command
      ->add_option("--tau-join", arguments->tauJoin,
                   "Stay within this distance; default: found by the run itself")
      ->check(positive())
      ->group(mapping);
  command
      ->add_option("--tau-revisit", arguments->tauRevisit,
                   "Return to another place within this distance; default: 0.4 · τ_join")
      ->check(positive())
      ->group(mapping);
  command->add_option("--blur", arguments->blur, "The first and last K images of a stay count less")
      ->group(mapping);
  command->add_option("--preset", arguments->preset, "thesis: the choices of Rangel's thesis (chapter 4)")
      ->check(CLI::IsMember({"thesis"}))
      ->group(mapping);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia map ~/photos -o home.estancia\n"
              "  estancia map drive.mp4 -o drive.estancia --poses drive.txt\n"
              "  estancia map ~/photos -o home.estancia --continue\n"
              "  estancia map ~/photos -o home.estancia --room-classifier rooms.classifier");
  command->callback([arguments, command] { run(*arguments, *command); });
}

}  // namespace estancia::apps
