#include "experiments/src/runner/subjects.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "estancia/core/error.hpp"
#include "estancia/core/plus_names.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/label/model.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;

std::unique_ptr<Sequence> openImages(const SequenceSource& source) {
  if (isDescriptorFile(source.path))
    throw Error(fmt::format("{} holds words already; models are compared on images", source.path.string()));
  return openSequence(source.path, source.options);
}

std::vector<ConfigFile::Key> sourceKeys(ConfigFile& config, SequenceSource& source, bool pathRequired) {
  SequenceOptions& how = source.options;
  const auto whole = [&config](int& value, int most) {
    return [&config, &value, most](auto& n) { value = static_cast<int>(config.integer(n, 1, most)); };
  };
  const auto number = [&config](double& value, double least, double most) {
    return [&config, &value, least, most](auto& n) { value = config.number(n, least, most); };
  };
  return {
      {"path", pathRequired, "where the images are", [&](auto& n) { source.path = config.anywhere(n); }},
      {"type", false, "how to read them", [&](auto& n) { how.type = config.text(n); }},
      {"split", false, "train, test …", [&](auto& n) { how.split = config.text(n); }},
      {"poses", false, "a trajectory", [&](auto& n) { how.poses = config.anywhere(n); }},
      {"max_pose_gap", false, "[s]", number(how.maxPoseGap, 0, 1e9)},
      {"views", false, "of a panorama", whole(how.views, 360)},
      {"field_of_view", false, "[degrees]", number(how.fieldOfView, 10, 150)},
      {"turn", false, "[degrees]", number(how.turn, -360, 360)},
      {"exposure", false, "[EV]", number(how.exposure, -20, 20)},
      {"rounds", false, "of the tour", whole(how.rounds, 1000)},
  };
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
    throw Error(fmt::format("there are no models in {}; run script/bootstrap, or name folders by `models`",
                            modelHome().string()));
  std::set<std::string> names;
  for (const Candidate& model : models)
    if (!names.insert(model.name).second) throw Error(fmt::format("two models are called {}", model.name));
  return models;
}

}  // namespace estancia::experiments
