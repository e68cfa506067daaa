// estancia experiment: given to the laboratory, a program of its own.
// SPDX-License-Identifier: Apache-2.0
#include "experiment.hpp"

#include <unistd.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include "common.hpp"
#include "estancia/core/error.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;
constexpr const char* laboratory = "estancia-lab";

}  // namespace

void becomeLaboratory(char** arguments) {
  std::vector<char*> words{const_cast<char*>(laboratory)};
  while (*arguments != nullptr) words.push_back(*arguments++);
  words.push_back(nullptr);
  std::error_code unreadable;
  const fs::path folder = fs::read_symlink("/proc/self/exe", unreadable).parent_path();
  for (const fs::path& place : {folder, folder / "../libexec/estancia"})
    if (place.is_absolute()) execv((place / laboratory).c_str(), words.data());
  execvp(laboratory, words.data());
}

void addExperimentCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "experiment", "Run experiments: compare models on your sequences (package estancia-lab)");
  command->prefix_command();
  addExamples(
      *command,
      "  # by the program estancia-lab, beside this one, in ../libexec/estancia from there, or on PATH\n"
      "  estancia experiment run lab/experiments/model-choice.toml\n"
      "  estancia experiment run --help   # all its options, where it is installed");
  command->callback([] {
    throw Error(ErrorCode::missingDependency,
                "experiments are run by the program estancia-lab, which is not here; install the package "
                "estancia-lab (in the source: script/lab builds it, see lab/README.md)");
  });
}

}  // namespace estancia::apps
