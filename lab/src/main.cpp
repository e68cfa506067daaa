// estancia experiment: configuration files in, tables and a page out.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "estancia/apps/command_line.hpp"
#include "estancia/apps/declared_options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/findings/findings_page.hpp"
#include "estancia/findings/result_table.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/processes/work_queue.hpp"
#include "runner/experiment.hpp"
#include "runner/run_files.hpp"

namespace estancia::experiments {
namespace {

using namespace apps;

struct ExperimentArguments {
  explicit ExperimentArguments(CLI::App& command) : declared(command, OtherGroups::skip) {}
  std::vector<std::string> configs, models;
  std::string output;
  LabelerOptions labeler;
  bool noCache = false;
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
  const ExperimentRun experiment{folder, arguments.models, arguments.labeler,
                                 arguments.noCache ? nullptr : &cache, processes.queue.get()};
  const auto begin = std::chrono::steady_clock::now();
  const auto program = [&] { findings = runExperiment(configs, experiment, *processes.progress); };
  processes.queue != nullptr ? processes.queue->together(program) : program();
  if (!processes.speaks()) return;
  for (const std::string& note : findings.notes) spdlog::warn("{}", note);
  writeFindingsPage(folder / "report.html", findings);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  writeRunFiles(experiment, configs, findings, seconds.count());
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

void addRunCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("run", "Run an experiment; several files are run as one");
  auto a = std::make_shared<ExperimentArguments>(*command);
  std::string kinds = "The experiment (TOML), of one of the types";
  for (const auto& [type, explanation] : experimentTypes())
    kinds += fmt::format("\n  {}: {}", type, explanation);
  command->add_option("CONFIG", a->configs, kinds)->required();
  command
      ->add_option(
          "-o,--output", a->output,
          "Folder for report.html, findings.md, results.csv, run.json and what is needed to resume after "
          "Ctrl-C; experiments of several types have a folder each in it\nDefault: CONFIG's name (of several "
          "files, their folder's), here")
      ->type_name("FOLDER");
  command->add_option("--models", a->models, "Only these models, by name or folder, with commas between them")
      ->type_name("NAME")
      ->delimiter(',');
  a->declared.add(declare(a->labeler), {"engine", "precision", "reduced-images"});
  command->add_flag("--no-cache", a->noCache, "Label every image again; leave the label cache alone");
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia experiment run lab/experiments/model-choice.toml\n"
              "  estancia experiment run lab/experiments/model-choice.toml -o choice --models "
              "inception-v3,places365\n"
              "  estancia experiment run lab/experiments/objects/*.toml -o objects\n"
              "  mpirun -n 8 estancia experiment run lab/experiments/recognition/thesis.toml -o thesis");
  command->callback([a] { run(*a); });
}

}  // namespace
}  // namespace estancia::experiments

int main(int argc, char** argv) {
  using namespace estancia;
  apps::prepareProgram();
  CLI::App app("Run experiments: compare models on your sequences", "estancia experiment");
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  apps::addExamples(app, "  estancia experiment run lab/experiments/model-choice.toml");
  experiments::addRunCommand(app);
  return apps::runProgram(app, argc, argv);
}
