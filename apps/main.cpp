// The `estancia` command.
#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <exception>
#include <opencv2/core/utils/logger.hpp>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"

namespace {

/// OpenCV tells of failures through exceptions and return values, which we turn into sentences; keep it
/// silent.
void quietLibraries() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
}

void logToStderr() {
  auto logger = spdlog::stderr_color_mt("estancia");
  logger->set_pattern("%^%l%$: %v");
  spdlog::set_default_logger(std::move(logger));
}

int complain(const std::string& sentence) {
  std::fflush(stdout);
  std::fprintf(stderr, "error: %s\n", sentence.c_str());
  return estancia::apps::failure;
}

/// What is wrong with the command line, and where to read more.
std::string explainWrongWords(const CLI::App& app, const CLI::ParseError& error) {
  std::string name = "estancia", problem = error.what();
  const CLI::App* deepest = &app;
  while (!deepest->get_subcommands().empty()) {
    deepest = deepest->get_subcommands().front();
    name += " " + deepest->get_name();
  }
  if (deepest->get_require_subcommand_min() > 0 && !deepest->remaining().empty())
    problem = fmt::format("{} does not know \"{}\"", name, deepest->remaining().front());
  return fmt::format("{}; see {} --help", problem, name);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace estancia::apps;
  quietLibraries();
  logToStderr();
  estancia::catchInterrupts();

  CLI::App app("Estancia turns a robot's images into a map in words that can be asked and driven.",
               "estancia");
  app.set_version_flag("--version", ESTANCIA_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  addExamples(app,
              "  estancia map ~/pictures -o home.estancia\n"
              "  estancia ask home.estancia \"coffee\"\n"
              "  estancia route home.estancia --from 0 --to \"coffee\"\n"
              "  estancia report home.estancia -o home.html");
  addCheckCommand(app);
  addLabelCommand(app);
  addOdometryCommand(app);
  addFilterCommand(app);
  addMapCommand(app);
  addZonesCommand(app);
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
  addExperimentCommand(app);
  addCompareCommand(app);
  addModelsCommand(app);
  addCacheCommand(app);

  try {
    app.parse(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      return complain("the output could not be written to the end; check where it goes");
    return success;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help, --version
    return complain(explainWrongWords(app, e));
  } catch (const NoAnswer&) {
    return noAnswer;
  } catch (const estancia::Interrupted& e) {
    complain(e.what());
    return 130;  // as a shell reports SIGINT
  } catch (const std::bad_alloc&) {
    return complain("out of memory; use fewer or smaller images, or a smaller model");
  } catch (const std::exception& e) {
    return complain(e.what());
  }
}
