// SPDX-License-Identifier: Apache-2.0
#include "runner/subjects.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <set>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/plus_names.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;

std::unique_ptr<Sequence> openImages(const SequenceSource& source) {
  if (isDescriptorFile(source.path))
    throw Error(ErrorCode::unsupportedFile,
                fmt::format("{} holds labels already; models are compared on images", source.path.string()));
  return openSequence(source.path, source.options);
}

std::string digestOf(const SequenceSource& source) {
  const auto sequence = openImages(source);
  std::string all;
  for (std::size_t i = 0; i < sequence->size(); ++i) {
    const Frame& frame = sequence->frame(i);
    all += frame.name + '\n' + frame.room + '\n' + sequence->fingerprint(i) + '\n';
    if (const auto& p = frame.pose)
      all += fmt::format("{} {} {} {} {} {} {}\n", p->x, p->y, p->z, p->qx, p->qy, p->qz, p->qw);
  }
  return sha256(all);
}

std::vector<ConfigFile::Key> sourceKeys(ConfigFile& config, SequenceSource& source, bool pathRequired) {
  // Without the paths, which are read as anywhere(), and without what experiments find out themselves.
  const std::set<std::string> used{"type",          "split", "max_pose_gap", "views",
                                   "field_of_view", "turn",  "exposure",     "rounds"};
  auto keys = keysOf(config, declare(source.options));
  std::erase_if(keys, [&](const ConfigFile::Key& key) { return !used.contains(key.name); });
  keys.push_back(
      {"path", pathRequired, "where the images are", [&](auto& n) { source.path = config.anywhere(n); }});
  keys.push_back({"poses", false, "", [&](auto& n) { source.options.poses = config.anywhere(n); }});
  return keys;
}

namespace {

OptionGroup declare(NamedDrive& drive) {
  OptionGroup group("drive", "Images of a drive.");
  group.add("name", &drive.name, "What to call it");
  group.add("optional", &drive.optional, "Leave out, with a note, when it is not there");
  return group;
}

}  // namespace

NamedDrive readNamedDrive(ConfigFile& config, const toml::table& table,
                          const std::vector<ConfigFile::Key>& more) {
  NamedDrive drive;
  std::vector<std::string> only;
  auto own =
      together(sourceKeys(config, drive.images, true), requiring("name", keysOf(config, declare(drive))));
  own.push_back({"only", false, "only images of these rooms",
                 each(config, only, [&config](auto& n) { return config.text(n); })});
  config.read(table, together(own, more));
  drive.images.options.only = only;
  return drive;
}

void readDrives(ConfigFile& config, std::vector<std::string>& models, const std::string& what,
                const std::function<void(const toml::table&)>& read) {
  const toml::array* drives = nullptr;
  config.read({{"type", true, "the kind of experiment", [](auto&) {}},
               {"models", false, "the models to compare",
                each(config, models, [&config](const toml::node& n) { return config.text(n); })},
               {"drive", true, "[[drive]] names " + what, [&](auto& n) { drives = &config.list(n); }}});
  for (const toml::node& node : *drives) read(config.subtable(node));
}

std::vector<NamedDrive> presentDrives(const std::vector<NamedDrive>& drives,
                                      std::vector<std::string>& notes) {
  std::vector<NamedDrive> present;
  std::set<std::string> names;
  for (const NamedDrive& drive : drives) {
    if (!names.insert(drive.name).second)
      throw Error(ErrorCode::invalidInput,
                  fmt::format("two drives are called {}; tell them apart by `name`", drive.name));
    if (drive.optional && !fs::exists(drive.images.path))
      notes.push_back(fmt::format("{} is not there and was left out", drive.images.path.string()));
    else
      present.push_back(drive);
  }
  if (present.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("none of the images is there; unpack {}, or name a `path` of yours",
                            drives.empty() ? "some" : drives.front().images.path.string()));
  return present;
}

namespace {

/// Throws Error when there is no such model, or it is described wrongly.
std::string nameOf(const std::string& model) {
  std::string names;  // several at work together
  for (const std::string& each : splitAtPlus(model))
    names += (names.empty() ? "" : "+") + readModelSpec(getModelFolder(each)).name;
  return names;
}

}  // namespace

std::vector<Candidate> modelsToCompare(const std::vector<std::string>& configured, const ExperimentRun& run,
                                       std::vector<std::string>& notes) {
  std::vector<Candidate> models;
  for (const std::string& model : run.models.empty() ? configured : run.models)
    models.push_back({model, nameOf(model)});
  if (models.empty())
    for (const InstalledModel& installed : installedModels()) {
      const std::string name = installed.folder.filename().string();
      if (installed.spec && (installed.spec->type == "recorded" || installed.spec->type == "human"))
        notes.push_back(
            fmt::format("the model {} was left out: it knows only the images that it was made for", name));
      else if (installed.spec)
        models.push_back({name, name});
      else
        notes.push_back(fmt::format("the model {} was left out: {}", name, installed.problem));
    }
  if (models.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("there are no models in {}; run script/bootstrap, or name folders by `models`",
                            modelHome().string()));
  std::set<std::string> names;
  for (const Candidate& model : models)
    if (!names.insert(model.name).second)
      throw Error(ErrorCode::invalidInput, fmt::format("two models are called {}", model.name));
  return models;
}

void addWhatIsThere(const std::vector<std::string>& names, const std::function<void(const std::string&)>& add,
                    std::vector<std::string>& notes) {
  std::vector<std::string> missing;
  std::string first;
  for (const std::string& name : names) try {
      add(name);
    } catch (const Error& problem) {
      if (missing.empty()) first = problem.what();
      missing.push_back(name);
    }
  if (!missing.empty()) notes.push_back(fmt::format("left out: {}; {}", fmt::join(missing, ", "), first));
}

void refuseModels(const ExperimentRun& run, const std::string& what) {
  if (!run.models.empty())
    throw Error(ErrorCode::invalidOption,
                fmt::format("--models names networks ({}), which {} has none of; leave it out",
                            run.models.front(), what));
}

}  // namespace estancia::experiments
