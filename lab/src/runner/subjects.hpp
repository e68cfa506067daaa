// Experiment subjects: models to compare, and images to compare them on.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "estancia/core/config.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "runner/experiment.hpp"

namespace estancia::experiments {

/// Images to open: where, and how.
struct SequenceSource {
  std::filesystem::path path;
  SequenceOptions options;
};

/// Opens them. Throws Error when they are labels already (a recording): models cannot be compared on those.
std::unique_ptr<Sequence> openImages(const SequenceSource& source);

/// What identifies the images, their rooms and poses, without labeling them. Throws Error as openImages()
/// does.
std::string digestOf(const SequenceSource& source);

/// The keys that define where images are and how to open them.
std::vector<ConfigFile::Key> sourceKeys(ConfigFile& config, SequenceSource& source, bool pathRequired);

/// A drive of a configuration.
struct NamedDrive {
  /// What to call it.
  std::string name;
  SequenceSource images;
  /// Left out, with a note, when it is not there.
  bool optional = false;
};

/// Reads `name`, `optional`, `only` (rooms) and the keys of sourceKeys() from a table, with `more` keys
/// beside them.
NamedDrive readNamedDrive(ConfigFile& config, const toml::table& table,
                          const std::vector<ConfigFile::Key>& more = {});

/// Reads the configuration of an experiment that takes models and drives only: `read` takes each table
/// [[drive]], which names `what`.
void readDrives(ConfigFile& config, std::vector<std::string>& models, const std::string& what,
                const std::function<void(const toml::table&)>& read);

/// The drives that are there; the others are reported in `notes`. Throws Error when none is left
/// (insufficientData), or two have the same name (invalidInput).
std::vector<NamedDrive> presentDrives(const std::vector<NamedDrive>& drives, std::vector<std::string>& notes);

struct Candidate {
  /// For loadModel().
  std::string model;
  /// For people.
  std::string name;
};

/// The models of the command line, else those of the configuration, else all that are installed; omissions
/// are reported in `notes`. Throws Error when one is unknown or two have the same name.
std::vector<Candidate> modelsToCompare(const std::vector<std::string>& configured, const ExperimentRun& run,
                                       std::vector<std::string>& notes);

/// Calls `add` with each of `names`; those that it throws Error for are left out, and named in one note.
void addWhatIsThere(const std::vector<std::string>& names, const std::function<void(const std::string&)>& add,
                    std::vector<std::string>& notes);

/// For experiments without networks. Throws Error (invalidOption) when the command line names models, which
/// `what` has none of.
void refuseModels(const ExperimentRun& run, const std::string& what);

}  // namespace estancia::experiments
