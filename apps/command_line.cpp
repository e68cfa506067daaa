// SPDX-License-Identifier: Apache-2.0
#include "command_line.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/ansicolor_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/words/installed_words.hpp"

namespace estancia::apps {
namespace {

/// Where stdin, stdout or stderr are closed, the next file that is opened would take its place, and what is
/// printed would be written into it. Uses of what stands there now fail as they would have.
void occupyStandardFiles() {
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    const bool isClosed = fcntl(file, F_GETFD) < 0;
    if (isClosed && open("/dev/null", file == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0) return;
  }
}

/// OpenCV reports failures through exceptions and return values, which we turn into sentences; keep it
/// silent.
void quietLibraries() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
}

/// A line of the log does not go on in a bar of progress, and what it quotes of others does not reach the
/// terminal as it is.
class SinkBesideProgress final : public spdlog::sinks::ansicolor_stderr_sink_mt {
 public:
  void log(const spdlog::details::log_msg& message) override {
    clearProgressLine();
    const std::string text = printable({message.payload.data(), message.payload.size()});
    spdlog::details::log_msg shown = message;
    shown.payload = text;
    spdlog::sinks::ansicolor_stderr_sink_mt::log(shown);
  }
};

void logToStderr() {
  auto logger = std::make_shared<spdlog::logger>("estancia", std::make_shared<SinkBesideProgress>());
  logger->set_pattern("%^%l%$: %v");
  spdlog::set_default_logger(std::move(logger));
}

/// A value that is "" has its own sentence: mostly it is a variable of a script that was never set.
void refuseEmptyArguments(CLI::App& app) {
  const CLI::Validator notEmpty(
      [](const std::string& text) { return text.empty() ? std::string("is empty; give one") : ""; }, "");
  for (CLI::Option* option : app.get_options())
    if (takesValue(*option) && option->get_type_name() != textOrNothing) option->check(notEmpty);
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; }))
    refuseEmptyArguments(*command);
}

/// One line on stderr with the error's code in brackets, and with --json an object on stdout, too.
int complain(ErrorCode code, const std::string& sentence, bool json) {
  const Error line(code, sentence);
  const std::string name(nameOf(code));
  if (json) print({{"error", {{"code", name}, {"message", line.what()}}}});
  std::fflush(stdout);
  std::fprintf(stderr, "error: %s [%s]\n", line.what(), name.c_str());
  if (code == ErrorCode::interrupted) return 130;  // the exit code that shells report for SIGINT
  return code == ErrorCode::noAnswer ? noAnswer : failure;
}

int complainOfOutput() {
  return complain(ErrorCode::fileUnwritable,
                  "the output could not be written completely; check where it goes", false);
}

bool isOption(const std::string& word) {
  return word.size() > 1 && word.front() == '-' && std::isdigit(static_cast<unsigned char>(word[1])) == 0;
}

/// What is wrong with the command line, and where to read more.
std::string explainWrongWords(const CLI::App& app, const CLI::ParseError& error) {
  std::string name = app.get_name(), problem = error.what();
  const CLI::App* deepest = &app;
  while (!deepest->get_subcommands().empty()) {
    deepest = deepest->get_subcommands().front();
    name += " " + deepest->get_name();
  }
  const std::vector<std::string> surplus = deepest->remaining();
  if (deepest->get_require_subcommand_min() > 0 && !surplus.empty())
    problem = fmt::format("{} does not know \"{}\"", name, surplus.front());
  else if (const auto option = std::ranges::find_if(surplus, isOption); option != surplus.end())
    problem = fmt::format("{} has no option {}", name, *option);
  else if (!surplus.empty())
    problem = fmt::format("{} has no place for \"{}\"", name, fmt::join(surplus, " "));
  else if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ConversionError))
    problem = fmt::format("{} is not a number that it takes", problem.substr(problem.find(": ") + 2));
  return fmt::format("{}; see {} --help", problem, name);
}

}  // namespace

bool takesValue(const CLI::Option& option) {
  return option.get_items_expected_max() > 0 && option.get_type_size_max() > 0;
}

void addExamples(CLI::App& command, const std::string& examples) {
  command.footer("Examples:\n" + examples);
}

void addJsonOption(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print JSON for machines on stdout");
}

void print(const nlohmann::ordered_json& json) {
  // Labels and file names may hold bytes that are no UTF-8: show them as such instead of failing.
  std::puts(json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

void prepareProgram() {
  occupyStandardFiles();
  quietLibraries();
  logToStderr();
  catchInterrupts();
}

int runProgram(CLI::App& app, int argc, char** argv) {
  refuseEmptyArguments(app);
  const bool json =
      std::any_of(argv, argv + argc, [](const char* word) { return std::string_view(word) == "--json"; });
  try {
    app.parse(argc, argv);
    if (const std::string problem = wordNetProblem(); !problem.empty()) spdlog::warn(problem);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) return complainOfOutput();
    return success;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {  // --help, --version
      app.exit(e);
      return std::cout.flush() ? success : complainOfOutput();
    }
    return complain(ErrorCode::invalidOption, explainWrongWords(app, e), json);
  } catch (const NoAnswer&) {
    return noAnswer;
  } catch (const Error& e) {
    return complain(e.code(), e.what(), json);
  } catch (const std::bad_alloc&) {
    return complain(ErrorCode::tooLarge, "out of memory; use fewer or smaller images, or a smaller model",
                    json);
  } catch (const std::filesystem::filesystem_error& e) {
    return complain(ErrorCode::fileUnreadable,
                    fmt::format("{}: cannot be used ({}); check its name and its folder", e.path1().string(),
                                e.code().message()),
                    json);
  } catch (const std::system_error& e) {
    if (std::ferror(stdout) != 0) return complainOfOutput();  // fmt reports this by an exception
    return complain(ErrorCode::invalidState, e.what(), json);
  } catch (const std::exception& e) {
    return complain(ErrorCode::invalidState, e.what(), json);
  }
}

}  // namespace estancia::apps
