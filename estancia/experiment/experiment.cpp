#include "estancia/experiment/experiment.hpp"

#include "estancia/core/config.hpp"
#include "estancia/experiment/model_choice.hpp"
#include "estancia/experiment/place_tasks.hpp"

namespace estancia {
namespace {

struct Kind {
  const char* type;
  const char* explanation;
  Findings (*run)(ConfigFile& config, const ExperimentRun& run, Progress& progress);
};

constexpr Kind kKinds[] = {
    {"model-choice", "which model's words tell places apart (thesis 4.5.2)",
     [](ConfigFile& config, const ExperimentRun& run, Progress& progress) {
       return chooseModel(readModelChoice(config), run, progress);
     }},
    {"places", "places mapped, found again, and rooms told apart",
     [](ConfigFile& config, const ExperimentRun& run, Progress& progress) {
       return comparePlaceTasks(readPlaceTasks(config), run, progress);
     }},
};

}  // namespace

Findings runExperiment(const std::filesystem::path& file, const ExperimentRun& run, Progress& progress) {
  ConfigFile config(file);
  std::vector<std::pair<std::string, const Kind*>> kinds;
  for (const Kind& kind : kKinds) kinds.emplace_back(kind.type, &kind);
  const Kind* chosen = nullptr;
  config.read({{"type", true, "the kind of experiment, as \"model-choice\"",
                [&](auto& node) { chosen = config.choice(node, kinds); }}},
              ConfigFile::Others::skip);
  return chosen->run(config, run, progress);
}

std::vector<std::pair<std::string, std::string>> experimentTypes() {
  std::vector<std::pair<std::string, std::string>> types;
  for (const Kind& kind : kKinds) types.emplace_back(kind.type, kind.explanation);
  return types;
}

}  // namespace estancia
