// The `estancia` command.
// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include "command_line.hpp"
#include "common.hpp"
#include "estancia/version.hpp"
#include "experiment.hpp"
#include "live.hpp"

int main(int argc, char** argv) {
  using namespace estancia::apps;
  if (argc > 1 && std::string_view(argv[1]) == "experiment") becomeLaboratory(argv + 2);
  prepareProgram();

  CLI::App app("Estancia turns a robot's images into a map in words that can be asked and driven.",
               "estancia");
  app.set_version_flag("--version", estancia::version());
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  addExamples(app,
              "  estancia map ~/photos -o home.estancia\n"
              "  estancia ask home.estancia \"coffee\"\n"
              "  estancia route home.estancia --from 0 --to \"coffee\"\n"
              "  estancia report home.estancia -o home.html");
  addCheckCommand(app);
  addLabelCommand(app);
  addOdometryCommand(app);
  addFilterCommand(app);
  addMapCommand(app);
  addLiveCommand(app);
  addDrivesCommand(app);
  addMergeMapsCommand(app);
  addChangesCommand(app);
  addCompactCommand(app);
  addZonesCommand(app);
  addAreasCommand(app);
  addNameCommand(app);
  addClassifyCommand(app);
  addRecognizeCommand(app);
  addObjectsCommand(app);
  addAskCommand(app);
  addRouteCommand(app);
  addLocalizeCommand(app);
  addExplainCommand(app);
  addEvaluateCommand(app);
  addExportCommand(app);
  addReportCommand(app);
  addMcpCommand(app);
  addExperimentCommand(app);
  addCompareCommand(app);
  addModelsCommand(app);
  addCacheCommand(app);
  addOptionsCommand(app);
  addGenerateCommand(app);
  return runProgram(app, argc, argv);
}
