// estancia generate: shell completion, man pages and the reference, from the declarations of the commands.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "command_tree.hpp"
#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;

/// Where pages go.
struct PageFolder {
  std::string path;
  bool overwrite = false;
};

void writeInto(const PageFolder& pages, const std::string& name, const std::string& text) {
  const fs::path folder = pages.path;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error(ErrorCode::fileUnwritable, fmt::format("{}: the folder cannot be made ({}); choose another",
                                                       folder.string(), error.message()));
  requireReplaceable(folder / name, pages.overwrite, nullptr, "page");
  writeWhole(folder / name, text);
}

void writeManPages(const CLI::App& app, const PageFolder& folder) {
  for (const auto& [name, command] : commandsOf(app)) {
    std::string file = name;
    std::replace(file.begin(), file.end(), ' ', '-');
    writeInto(folder, file + ".1", manPage(name, *command));
  }
}

}  // namespace

void addGenerateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("generate", "Write shell completion, man pages or the reference");
  command->require_subcommand(1);
  addExamples(*command,
              "  source <(estancia generate bash)\n"
              "  estancia generate man -o ~/.local/share/man/man1");
  const auto script = [&](const char* shell, std::string (*text)(const CLI::App&)) {
    CLI::App* one = command->add_subcommand(shell, fmt::format("Print the completion of {}", shell));
    addExamples(*one, fmt::format("  source <(estancia generate {})", shell));
    one->callback([&app, text] { fmt::print("{}", text(app)); });
  };
  script("bash", bashCompletion);
  script("zsh", zshCompletion);
  const auto pages = [&](const char* name, const char* what, std::function<void(const PageFolder&)> write) {
    auto folder = std::make_shared<PageFolder>();
    CLI::App* one = command->add_subcommand(name, fmt::format("Write {} into a folder", what));
    one->add_option("-o,--output", folder->path, "The folder")->required()->type_name("FOLDER");
    addOverwriteOption(*one, folder->overwrite);
    addExamples(*one, fmt::format("  estancia generate {} -o {}", name, name));
    one->callback([folder, write] { write(*folder); });
  };
  pages("man", "the man pages", [&app](const PageFolder& folder) { writeManPages(app, folder); });
  pages("reference", "the reference of commands and parameters (Markdown)", [&app](const PageFolder& folder) {
    writeInto(folder, "command.md", commandReference(app));
    writeInto(folder, "parameters.md", optionReference());
  });
}

}  // namespace estancia::apps
