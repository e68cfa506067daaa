// Shared arguments: sequences, outputs, JSON, for all subcommands.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "command_line.hpp"
#include "declared_options.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia::apps {

/// SEQ and the options that define how to read it.
struct SequenceArguments {
  std::string path;
  SequenceOptions options;
  /// Adds SEQ and the group "sequence"; its `--rooms`, a table of true rooms, where those are of use.
  void addTo(DeclaredOptions& declared, bool required = true, bool withRooms = true);
  /// Adds flags for depth, for the commands that use it, to the same group.
  static void addDepthTo(DeclaredOptions& declared);
  /// Opens the sequence and logs its warnings.
  std::unique_ptr<Sequence> open() const;
  /// Opens the sequence without logging: for commands that open it again, or report warnings in their own
  /// way.
  std::unique_ptr<Sequence> openQuietly() const;
};

/// Throws Error when a command is about to replace one of its `inputs`, a map, a file of zones or a room
/// classifier, what is no file (a device, a pipe), or, unless `start` is "", a file that begins otherwise.
void requireNoData(const std::filesystem::path& output, const std::vector<std::string>& inputs,
                   std::string_view start = {});

/// For outputs that only `--overwrite` replaces, and only where the file there `isOurs` (nullptr: any file),
/// of the kind that is written, or is empty. Throws Error, before the long work begins, when it is in the way
/// or has no folder.
void requireReplaceable(const std::filesystem::path& output, bool overwrite,
                        bool (*isOurs)(const std::filesystem::path&), std::string_view what);

/// Both for an image (PNG) that a command draws, unless it is "".
void requireImage(const std::string& image, bool overwrite, const std::vector<std::string>& inputs);

/// Beginning of the generated pages.
constexpr std::string_view pageStart = "<!DOCTYPE html>\n";

/// Accepts whole numbers.
CLI::Validator wholeNumber(int least, int most = 1'000'000'000);

/// Adds `-o`, `--output`.
CLI::Option* addOutputOption(CLI::App& command, std::string& output, const std::string& help);

/// Adds `--overwrite`.
CLI::Option* addOverwriteOption(CLI::App& command, bool& overwrite);

/// Adds `--poses-in-map`.
void addPosesInMapOption(CLI::App& command, bool& posesInMap);

/// The name of work whose results are printed while it goes on: none where they go to the terminal, as they
/// show how far it is, and a bar of progress would stand among them.
std::string nameBesideResults(const std::string& work);

/// By their keys; null where unknown.
nlohmann::ordered_json toJson(const std::vector<Measure>& measures);

/// A table of those that are known on stdout. Returns how many that are.
std::size_t print(const std::vector<Measure>& measures);

// One file a subcommand.
void addCheckCommand(CLI::App& app);
void addLabelCommand(CLI::App& app);
void addOdometryCommand(CLI::App& app);
void addFilterCommand(CLI::App& app);
void addMapCommand(CLI::App& app);
void addZonesCommand(CLI::App& app);
void addDrivesCommand(CLI::App& app);
void addCompactCommand(CLI::App& app);
void addMergeMapsCommand(CLI::App& app);
void addChangesCommand(CLI::App& app);
void addAreasCommand(CLI::App& app);
void addNameCommand(CLI::App& app);
void addClassifyCommand(CLI::App& app);
void addRecognizeCommand(CLI::App& app);
void addObjectsCommand(CLI::App& app);
void addAskCommand(CLI::App& app);
void addRouteCommand(CLI::App& app);
void addLocalizeCommand(CLI::App& app);
void addEvaluateCommand(CLI::App& app);
void addExplainCommand(CLI::App& app);
void addExportCommand(CLI::App& app);
void addReportCommand(CLI::App& app);
void addMcpCommand(CLI::App& app);
void addExperimentCommand(CLI::App& app);
void addCompareCommand(CLI::App& app);
void addModelsCommand(CLI::App& app);
void addCacheCommand(CLI::App& app);
void addOptionsCommand(CLI::App& app);
void addGenerateCommand(CLI::App& app);

}  // namespace estancia::apps
