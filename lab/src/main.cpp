// estancia experiment: configuration files in, tables and a page out.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "common.hpp"
#include "estancia/core/progress.hpp"
#include "experiments/src/findings/findings_files.hpp"
#include "experiments/src/findings/findings_page.hpp"
#include "experiments/src/findings/result_table.hpp"
#include "experiments/src/runner/experiment.hpp"
#include "labeling.hpp"
#include "processes.hpp"

namespace estancia::apps {
namespace {

using namespace experiments;

struct ExperimentArguments {
  explicit ExperimentArguments(CLI::App& command) : declared(command) {}
  std::vector<std::string> configs, models;
  std::string output;
  ModelArguments labeling;
  bool json = false;
  DeclaredOptions declared;
};

nlohmann::ordered_json jsonOf(const Findings& findings) {
  nlohmann::ordered_json json{{"title", findings.title}, {"summary", findings.summary}};
  for (const auto& section : findings.sections) {
    const auto* table = std::get_if<ResultTable>(&section);
    if (table == nullptr) continue;  // curves are in results.csv
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const auto& row : table->rows) {
      nlohmann::ordered_json cells{{table->rowsAre, row.name}};
      for (std::size_t c = 0; c < table->columns.size(); ++c)
        cells[table->columns[c].name] =
            row.values[c] ? nlohmann::ordered_json(*row.values[c]) : nlohmann::ordered_json();
      rows.push_back(std::move(cells));
    }
    json["tables"].push_back({{"title", table->title}, {"rows", std::move(rows)}});
  }
  json["notes"] = findings.notes;
  return json;
}

void run(const ExperimentArguments& arguments) {
  namespace fs = std::filesystem;
  const std::vector<fs::path> configs(arguments.configs.begin(), arguments.configs.end());
  fs::path folder = arguments.output;
  if (folder.empty())
    folder = configs.size() == 1 ? configs[0].stem() : fs::absolute(configs[0]).parent_path().filename();
  const Processes processes = joinProcesses();
  LabelCache cache;
  Findings findings;
  const auto program = [&] {
    findings = runExperiment(configs,
                             {folder, arguments.models, arguments.labeling.options,
                              arguments.labeling.noCache ? nullptr : &cache, processes.queue.get()},
                             *processes.progress);
  };
  processes.queue != nullptr ? processes.queue->together(program) : program();
  if (!processes.speaks()) return;
  for (const std::string& note : findings.notes) spdlog::warn("{}", note);
  writeFindingsPage(folder / "report.html", findings);
  for (const Findings& part : findings.apart) writeFindingsFiles(folder / part.file, part);
  if (arguments.json) {
    print(jsonOf(findings));
  } else {
    fmt::print("{}\n", findings.summary);
    for (const auto& section : findings.sections)
      if (const auto* table = std::get_if<ResultTable>(&section))
        fmt::print("\n{}\n{}", table->title, textTable(*table));
  }
  spdlog::info("wrote {} and the results in its folder", (folder / "report.html").string());
}

}  // namespace

void addExperimentCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand("experiment", "Run experiments: compare models on your sequences");
  group->require_subcommand(1);
  addExamples(*group, "  estancia experiment run experiments/model-choice.toml");
  CLI::App* command = group->add_subcommand("run", "Run an experiment; several files are run as one");
  auto a = std::make_shared<ExperimentArguments>(*command);
  std::string kinds = "The experiment (TOML), of one of the types";
  for (const auto& [type, explanation] : experiments::experimentTypes())
    kinds += fmt::format("\n  {}: {}", type, explanation);
  command->add_option("CONFIG", a->configs, kinds)->required();
  command
      ->add_option(
          "-o,--output", a->output,
          "Folder for report.html, results.csv and what is needed to resume after Ctrl-C; experiments "
          "of several types have a folder each in it\nDefault: CONFIG's name (of several files, their "
          "folder's), here")
      ->type_name("FOLDER");
  command->add_option("--models", a->models, "Only these models, by name or folder, with commas between them")
      ->type_name("NAME")
      ->delimiter(',');
  a->labeling.addLabelerTo(a->declared);
  command->add_flag("--no-cache", a->labeling.noCache,
                    "Label every image again; leave the label cache alone");
  addJsonOption(*command, a->json);
  addExamples(
      *command,
      "  estancia experiment run experiments/model-choice.toml\n"
      "  estancia experiment run experiments/model-choice.toml -o choice --models inception-v3,places365\n"
      "  estancia experiment run experiments/objects/*.toml -o objects\n"
      "  mpirun -n 8 estancia experiment run experiments/recognition/thesis.toml -o thesis");
  command->callback([a] { run(*a); });
}

}  // namespace estancia::apps
