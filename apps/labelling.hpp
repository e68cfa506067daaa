// What every command that labels lets one choose.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "estancia/label/model.hpp"

namespace estancia::apps {

struct ModelArguments {
  std::string model = defaultModel;
  LabelerOptions options;

  /// Adds `--model`, explained by `what`, and how to run it.
  void addTo(CLI::App& command, const std::string& what);
  /// Adds only how to run it: `--engine`, `--threads`.
  void addOptionsTo(CLI::App& command);
  std::unique_ptr<Labeler> open() const;
};

}  // namespace estancia::apps
