// estancia evaluate: how good is a map, and how well does one find one's way in it?
#include <fmt/format.h>

#include "estancia/core/error.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/topology/accuracy.hpp"
#include "estancia/topology/quality.hpp"
#include "localization.hpp"

namespace estancia::apps {
namespace {

struct Arguments {
  SequenceArguments sequence;
  LocalizationArguments localization;
  std::string truth;
  bool json = false;
};

LocalizationAccuracy localizationAccuracy(const Arguments& arguments, const MapReader& reader) {
  const AdmissibleImages admissible =
      arguments.truth.empty() ? AdmissibleImages{} : readAdmissibleImages(arguments.truth);
  std::vector<Frame> frames;
  std::vector<std::size_t> numbers;
  std::vector<Localization> answers;
  localize(arguments.localization, reader, arguments.sequence,
           [&](std::size_t number, const Frame& frame, const Localization& answer) {
             frames.push_back(frame);
             numbers.push_back(number);
             answers.push_back(answer);
           });
  return measureLocalization(reader.map(), frames, numbers, answers, admissible);
}

void run(const Arguments& arguments) {
  const SequenceArguments& given = arguments.sequence;
  if (given.path.empty() &&
      !(given.options.poses.empty() && given.options.rooms.empty() && arguments.truth.empty()))
    throw Error("--poses, --rooms and --truth tell about SEQ, the images to find in the map; name it, too");
  const MapReader reader(arguments.localization.map);
  const bool localized = !arguments.sequence.path.empty();
  const std::vector<Measure> measures =
      localized ? measuresOf(localizationAccuracy(arguments, reader)) : measuresOf(evaluate(reader.map()));
  if (arguments.json) {
    nlohmann::ordered_json json;
    for (const Measure& measure : measures) {
      auto& value = json[measure.key];
      if (measure.value && measure.decimals == 0)
        value = static_cast<std::int64_t>(*measure.value);
      else if (measure.value)
        value = *measure.value;
    }
    print(json);
    return;
  }
  std::size_t known = 0;
  for (const Measure& measure : measures) {
    if (!measure.value) continue;
    fmt::print("{:<26} {:>8}   {}\n", measure.name, measure.text(), measure.explanation);
    ++known;
  }
  if (localized && known == 1) fmt::print("Give --truth, rooms or poses of the images to learn more.\n");
  if (!localized && known < measures.size()) fmt::print("Map with rooms and poses to learn more.\n");
}

}  // namespace

void addEvaluateCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("evaluate", "Measure a map, or with SEQ how well its images are found in the map");
  arguments->localization.addTo(*command);
  arguments->sequence.addTo(*command, false);
  command
      ->add_option("--truth", arguments->truth,
                   "CSV query,refs: for each image of SEQ the map's frames that count as right")
      ->check(CLI::ExistingFile);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia evaluate home.estancia\n"
              "  estancia evaluate home.estancia ~/today --rooms today.csv --json");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
