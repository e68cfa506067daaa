#include "estancia/experiment/experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <variant>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/experiment/grid.hpp"
#include "estancia/experiment/model_choice.hpp"
#include "estancia/experiment/place_tasks.hpp"
#include "estancia/experiment/scenes.hpp"
#include "estancia/experiment/zone_tables.hpp"

namespace estancia {
namespace {

/// What a configuration asks for, read and checked.
using Experiment = std::function<Findings(Grid& grid, const ExperimentRun& run, Progress& progress)>;

template <auto readOptions, auto findings>
Experiment prepare(ConfigFile& config) {
  return [options = readOptions(config)](Grid& grid, const ExperimentRun& run, Progress& progress) {
    return findings(options, grid, run, progress);
  };
}

struct Kind {
  const char* type;
  const char* explanation;
  GridColumns (*columns)();
  bool cellsLabel;  ///< then they are computed one by one: the threads belong to the network
  Experiment (*read)(ConfigFile& config);
};

constexpr Kind kKinds[] = {
    {"model-choice", "which model's words tell places apart (thesis 4.5.2)", modelChoiceColumns, false,
     prepare<readModelChoice, chooseModel>},
    {"places", "places mapped, found again, and rooms told apart", placeTasksColumns, true,
     prepare<readPlaceTasks, comparePlaceTasks>},
    {"scenes", "rooms named by every descriptor with every classifier (thesis 3.5)", scenesColumns, false,
     prepare<readScenes, compareScenes>},
    {"zones", "zones against rooms, by model, distance, linkage and cut (thesis 5.5)", zoneTablesColumns,
     false, prepare<readZoneTables, compareZones>},
};

template <class T>
void addNew(std::vector<T>& to, const std::vector<T>& from) {
  for (const T& one : from)
    if (std::find(to.begin(), to.end(), one) == to.end()) to.push_back(one);
}

}  // namespace

Findings runExperiment(const std::vector<std::filesystem::path>& configs, const ExperimentRun& run,
                       Progress& progress) {
  std::vector<std::pair<std::string, const Kind*>> kinds;
  for (const Kind& kind : kKinds) kinds.emplace_back(kind.type, &kind);
  const Kind* chosen = nullptr;
  std::vector<Experiment> experiments;
  for (const auto& file : configs) {
    ConfigFile config(file);
    const auto choose = [&](const toml::node& node) {
      const Kind* kind = config.choice(node, kinds);
      if (chosen != nullptr && kind != chosen)
        config.fail(node, fmt::format("{} is of the type {}; run experiments of different types one by one",
                                      configs.front().string(), chosen->type));
      chosen = kind;
    };
    config.read({{"type", true, "the kind of experiment, as \"model-choice\"", choose}},
                ConfigFile::Others::skip);
    experiments.push_back(chosen->read(config));
  }
  if (experiments.empty()) throw Error("no experiment is named");

  Grid grid(run.folder, chosen->columns(), chosen->cellsLabel ? 1 : run.labeler.threads);
  Findings all;
  for (const Experiment& experiment : experiments) {
    Findings findings = experiment(grid, run, progress);
    all.title = findings.title;
    all.summary += (all.summary.empty() ? "" : " ") + findings.summary;
    addNew(all.facts, findings.facts);
    addNew(all.notes, findings.notes);
    for (Findings& part : findings.apart) all.apart.push_back(std::move(part));
    for (auto& section : findings.sections) {
      // What all of them print beside their own, as the thesis' tables, comes once and last.
      if (const auto* table = std::get_if<ResultTable>(&section))
        std::erase_if(all.sections, [table](const auto& known) {
          const auto* other = std::get_if<ResultTable>(&known);
          return other != nullptr && *other == *table;
        });
      all.sections.push_back(std::move(section));
    }
  }
  grid.writeCsv();
  return all;
}

std::vector<std::pair<std::string, std::string>> experimentTypes() {
  std::vector<std::pair<std::string, std::string>> types;
  for (const Kind& kind : kKinds) types.emplace_back(kind.type, kind.explanation);
  return types;
}

}  // namespace estancia
