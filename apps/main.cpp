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
  addMapCommand(app);
  addAskCommand(app);
  addRouteCommand(app);
  addLocalizeCommand(app);
  addExplainCommand(app);
  addEvaluateCommand(app);
  addExportCommand(app);
  addReportCommand(app);
  addModelsCommand(app);

  try {
    app.parse(argc, argv);
    return success;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help, --version
    return complain(fmt::format(
        "{}; see {} --help", e.what(),
        app.get_subcommands().empty() ? "estancia" : "estancia " + app.get_subcommands()[0]->get_name()));
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
