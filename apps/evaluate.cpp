// estancia evaluate: how good are a map or zones, and how well does one find one's way in it?
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>

#include "estancia/core/error.hpp"
#include "estancia/query/accuracy.hpp"
#include "estancia/query/quality.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/world_query/evaluate_world.hpp"
#include "estancia/zones/measure.hpp"
#include "estancia/zones/zones.hpp"
#include "localization.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;

struct EvaluateArguments {
  explicit EvaluateArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  LocalizationArguments localization;
  DeclaredOptions declared;
  std::string truth, classes;
  std::optional<double> originalExtent;
  bool json = false;
};

/// What is measured, and where the images of SEQ are.
struct Evaluation {
  std::vector<Measure> measures;
  std::vector<LocalizationSummary::Place> places = {};
  /// The true positions of the images are unknown.
  bool lacksTruth = false;
};

Evaluation evaluateLocalization(const EvaluateArguments& arguments) {
  const AdmissibleImages admissible =
      arguments.truth.empty() ? AdmissibleImages{} : readAdmissibleImages(arguments.truth);
  std::vector<Frame> frames;
  std::vector<std::size_t> numbers;
  std::vector<Localization> answers;
  Localizer localizer(arguments.localization.map, arguments.localization.localizer);
  localize(arguments.localization, localizer, arguments.sequence, "localizing",
           [&](std::size_t number, const Frame& frame, const Localization& answer) {
             frames.push_back(frame);
             numbers.push_back(number);
             answers.push_back(answer);
           });
  const LocalizationAccuracy accuracy = measureLocalization(
      localizer.map(), frames, numbers, answers, admissible, arguments.localization.localizer.filter,
      zonesOfFrames(arguments.localization.zones, localizer.map()));
  LocalizationSummary summary = summarizeLocalization(answers);
  std::vector<Measure> measures = measuresOf(accuracy);
  const bool lacksTruth =
      std::ranges::none_of(measures.begin() + 1, measures.end(), [](const Measure& m) { return !!m.value; });
  const std::vector<Measure> more = measuresOf(summary);
  measures.insert(measures.begin() + 1, more.begin(), more.end());
  return {std::move(measures), std::move(summary.places), lacksTruth};
}

Json toJson(const Evaluation& evaluation) {
  Json json = apps::toJson(evaluation.measures);
  for (const auto& place : evaluation.places)
    json["places"].push_back(
        {{"node", place.node}, {"frames", place.frames}, {"median_confidence", place.medianConfidence}});
  return json;
}

void printPlaces(const std::vector<LocalizationSummary::Place>& places) {
  constexpr std::size_t shown = 10;
  fmt::print("\n{:<10} {:>7}   median confidence\n", "place", "images");
  for (std::size_t i = 0; i < std::min(shown, places.size()); ++i)
    fmt::print("{:<10} {:>7}   {:.3f}\n", places[i].node, places[i].frames, places[i].medianConfidence);
  if (places.size() > shown) fmt::print("… and {} more; --json tells all\n", places.size() - shown);
}

/// The rooms that the mapped images see; none where no drive's folder is given.
template <class Frames>
std::vector<std::string> roomsSeenBy(const Frames& frames, const std::string& folder) {
  if (folder.empty()) return {};
  std::vector<std::string> images;
  for (const Frame& frame : frames) images.push_back(frame.name);
  return io::roomsSeen(folder, images);
}

std::vector<Measure> measuresOfZones(const EvaluateArguments& arguments) {
  if (!arguments.sequence.path.empty())
    throw Error(ErrorCode::unsupportedFile,
                fmt::format("{} holds zones, in which no images can be localized; give a map for that",
                            arguments.localization.map));
  const Zones zones = readZones(arguments.localization.map);
  return measuresOf(evaluate(zones, roomsSeenBy(zones.frames, arguments.truth)));
}

/// --classes are of the things in the truth.
void requireThings(const EvaluateArguments& arguments) {
  const auto file = std::filesystem::path(arguments.truth) / "instances.csv";
  if (!arguments.classes.empty() && !std::filesystem::exists(file))
    throw Error(ErrorCode::fileNotFound,
                fmt::format("{} is not there: no thing has one of the --classes; leave them out to measure "
                            "rooms and trajectory, or give the folder of a drive with its things",
                            file.string()));
}

std::vector<Measure> measuresOfMap(const EvaluateArguments& arguments) {
  const TopologicalMap map = readMap(arguments.localization.map);
  if (arguments.truth.empty()) return measuresOf(evaluate(map, {}, arguments.originalExtent));
  const ThingClasses classes =
      arguments.classes.empty() ? ThingClasses{} : readThingClasses(arguments.classes);
  requireThings(arguments);
  const std::vector<std::string> seen = roomsSeenBy(map.frames, arguments.truth);
  std::vector<Measure> measures = measuresOf(evaluate(map, seen, arguments.originalExtent));
  const WorldAccuracy accuracy = evaluateWorld(arguments.localization.map, arguments.truth, seen, classes);
  for (const std::string& doubt : accuracy.doubts) spdlog::warn("{}", doubt);
  for (Measure& more : measuresOf(accuracy)) measures.push_back(std::move(more));
  return measures;
}

Evaluation evaluationOf(const EvaluateArguments& arguments) {
  if (isZoneFile(arguments.localization.map)) return {measuresOfZones(arguments)};
  if (!arguments.sequence.path.empty()) return evaluateLocalization(arguments);
  return {measuresOfMap(arguments)};
}

/// --truth is a table about SEQ, or the folder of the drive that was mapped.
void requireFittingTruth(const EvaluateArguments& arguments) {
  const bool folder = std::filesystem::is_directory(arguments.truth),
             sequence = !arguments.sequence.path.empty();
  if (arguments.truth.empty() || folder != sequence) return;
  throw Error(
      ErrorCode::invalidOption,
      sequence ? fmt::format("--truth {} is a folder, the truth about a mapped drive; to judge where the "
                             "images of SEQ are found, give a CSV query,refs",
                             arguments.truth)
               : fmt::format("--truth {} is a file, the truth about SEQ, the images to localize; give SEQ, "
                             "too, or the folder of the mapped drive with its home.json",
                             arguments.truth));
}

void run(const EvaluateArguments& arguments) {
  const SequenceArguments& given = arguments.sequence;
  const SequenceOptions& how = given.options;
  if (given.path.empty() &&
      !(how.poses.empty() && how.rooms.empty() && how.split.empty() && how.only.empty()))
    throw Error(ErrorCode::invalidOption,
                "--poses, --rooms, --split and --only describe SEQ, the images to localize; give SEQ, too");
  requireFittingTruth(arguments);
  if (!arguments.classes.empty() &&
      (arguments.truth.empty() || !given.path.empty() || isZoneFile(arguments.localization.map)))
    throw Error(ErrorCode::invalidOption,
                "--classes are of the things in a map; give the map and --truth, the folder of its drive");
  if (arguments.originalExtent && (!given.path.empty() || isZoneFile(arguments.localization.map)))
    throw Error(ErrorCode::invalidOption,
                "--original-extent is of the score of a map; give a map alone, or leave it out");
  if (arguments.originalExtent && !(*arguments.originalExtent >= 0.001 && *arguments.originalExtent <= 1e6))
    throw Error(ErrorCode::invalidOption, "--original-extent is a length from 0.001 to 1000000 m");
  const bool localized = !arguments.sequence.path.empty();
  const Evaluation evaluation = evaluationOf(arguments);
  if (arguments.json) {
    apps::print(toJson(evaluation));
    return;
  }
  const std::size_t known = apps::print(evaluation.measures);
  if (localized) printPlaces(evaluation.places);
  if (evaluation.lacksTruth)
    fmt::print(
        "\nWhether this is right is not known: give poses (--poses FILE) or rooms (--rooms FILE) of SEQ, or "
        "--truth FILE, a CSV query,refs with the frames of the map that count as right.\n");
  if (!localized && known < evaluation.measures.size())
    fmt::print("Give the sequence rooms and poses to learn more.\n");
}

}  // namespace

void addEvaluateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "evaluate", "Measure a map or zones, or with SEQ how well its images are localized in the map");
  auto arguments = std::make_shared<EvaluateArguments>(*command);
  arguments->localization.addTo(arguments->declared);
  command->get_option("MAP")->description("The map file, or a file of zones");
  arguments->sequence.addTo(arguments->declared, false);
  command
      ->add_option(
          "--truth", arguments->truth,
          "Of SEQ: a CSV query,refs, for each image the map's frames that count as right. Without "
          "SEQ: the folder of the mapped drive with home.json, for the rooms that its images see, its "
          "poses, and with instances.csv for its things")
      ->check(CLI::ExistingPath);
  command
      ->add_option(
          "--classes", arguments->classes,
          "Of the things in the folder of --truth: a TOML file with their classes (fixture, furniture, "
          "…) and the labels that name them")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  command
      ->add_option("--original-extent", arguments->originalExtent,
                   "Extent X of the plan in the original program's score; by default the diagonal of the box "
                   "around all poses. 31.1725 on its author's plan of KTH-IDOL2")
      ->type_name("METERS");
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia evaluate home.estancia\n"
              "  estancia evaluate home.estancia --truth ~/drive\n"
              "  estancia evaluate home.estancia --truth ~/drive --classes things.toml\n"
              "  estancia evaluate home.estancia ~/today --rooms today.csv --json");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
