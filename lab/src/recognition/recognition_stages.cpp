// SPDX-License-Identifier: Apache-2.0
#include "recognition/recognition_stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "estancia/cloud/resolution.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/recognition/pose_candidates.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "recognition/pose_error.hpp"

namespace estancia::experiments {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The clouds are filtered before the recognizer sees them.
RecognitionOptions optionsOf(const RecognitionUnit& unit) {
  RecognitionOptions options = RecognitionOptions::preset(unit.preset);
  options.keypoints = unit.keypoint;
  options.descriptor = unit.descriptor;
  options.modelFilter = options.sceneFilter = {};
  options.threads = 1;
  return options;
}

std::string describe(const RecognitionOptions& o) {
  return fmt::format("{} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {}", o.surface, o.keypoints,
                     o.descriptor, o.grouping, o.verification, o.normalRadius, o.normalNeighbors,
                     o.keypointSpacing, o.sceneKeypointSpacing, o.descriptorRadius, o.consistency,
                     o.tolerance, o.colorTolerance, o.matchEach, o.neighbors, o.matchDistance, o.minMatches,
                     o.maxHypotheses, o.accept, o.falseAlarmRate);
}

/// Filters like the preset: it may need fewer signals of a neural gas.
FilterOptions filterOf(const std::string& preset, const std::string& method, std::size_t points) {
  FilterOptions filter = RecognitionOptions::preset(preset).sceneFilter;
  filter.method = method;
  filter.points = points;
  return filter;
}

std::string describe(const cv::Affine3d& pose) {
  std::string text;
  for (const double value : pose.matrix.val) text += fmt::format(" {}", value);
  return text;
}

/// Why `work` found nothing that it could describe; "" when it is done.
template <class Work>
std::string problemOf(const Work& work) {
  try {
    work();
    return "";
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& problem) {
    return problem.what();
  }
}

PointCloud movedBy(const cv::Affine3d& frame, PointCloud cloud) {
  for (cv::Point3f& p : cloud.points) p = frame * cv::Point3d(p);
  for (cv::Point3f& n : cloud.normals) n = cv::Vec3f(frame.rotation() * cv::Vec3d(n.x, n.y, n.z));
  return cloud;
}

/// Makes what the search needs of both; the scene may be described again for a model of another size.
void describe(const PreparedModel& model, const PreparedScene& scene) {
  const RecognitionScales scales = scene.scalesFor(model);
  scene.describedFor(scales);
  model.describedFor(scales);
}

}  // namespace

struct RecognitionStages::Entry {
  std::once_flag made;
  std::shared_ptr<const PreparedModel> model;  // null where it cannot be described …
  std::string problem;                         // … and why
};

/// Models are prepared when they are first needed.
struct RecognitionStages::Recipe {
  Recipe(const std::string& name, const RecognitionOptions& options, std::size_t entries)
      : preset(name), recognizer(options), models(entries) {}

  std::string preset;
  Recognizer recognizer;
  std::vector<Entry> models;  // [filter · models + model]
};

RecognitionStages::RecognitionStages(const RecognitionExperimentOptions& options, const ModelPairs& pairs,
                                     const std::filesystem::path& folder)
    : options_(options),
      pairs_(pairs),
      clouds_(folder / "filtered", std::uint64_t{options.keptMegabytes} << 20) {
  for (const ModelPairs::Model& model : pairs.models) {
    Model read{readCloud(model.file), sha256OfFile(model.file), {}, {}};
    try {
      read.center = centerOf(read.cloud);
    } catch (const Error& problem) {
      throw Error(problem.code(), fmt::format("{}: {}", model.file.string(), problem.what()));
    }
    models_.push_back(std::move(read));
  }
  for (const RecognitionExperimentOptions::Symmetry& symmetry : options.symmetries) {
    const auto model = std::find_if(pairs.models.begin(), pairs.models.end(),
                                    [&](const auto& m) { return m.name == symmetry.model; });
    if (model == pairs.models.end())
      throw Error(ErrorCode::unknownName, fmt::format("a symmetry of {}, which is no model of {}",
                                                      symmetry.model, options.pairs.string()));
    Model& turned = models_[static_cast<std::size_t>(model - pairs.models.begin())];
    const auto turns = turnsAround(symmetry.point ? cv::Point3d(*symmetry.point) : turned.center,
                                   symmetry.axis, symmetry.fold);
    turned.symmetries.insert(turned.symmetries.end(), turns.begin(), turns.end());
  }
  for (const ModelPairs::Scene& scene : pairs.scenes) sceneDigests_.push_back(sha256OfFile(scene.file));
}

RecognitionStages::~RecognitionStages() = default;

std::string RecognitionStages::inputs(const RecognitionUnit& unit) const {
  std::string text = describe(optionsOf(unit)) + "\n" + sceneDigests_[unit.scene] + "\n" +
                     FilteredClouds::describe(filterOf(unit.preset, unit.sceneFilter, unit.size)) + "\n" +
                     fmt::format("{} {} {}{}\n", options_.translation, options_.rotation, options_.elsewhere,
                                 options_.depthNoise ? " depth noise" : "");
  for (const std::string& filter : options_.modelFilters)
    text += FilteredClouds::describe(filterOf(unit.preset, filter, options_.modelPoints)) + "\n";
  for (const Model& model : models_) {
    text += model.digest + "\n";
    for (const cv::Affine3d& symmetry : model.symmetries) text += describe(symmetry) + "\n";
  }
  for (const ModelPairs::Pair& pair : pairs_.pairs)
    if (pair.scene == unit.scene)
      for (const cv::Affine3d& pose : pair.poses) text += std::to_string(pair.model) + describe(pose) + "\n";
  return sha256(text);
}

std::shared_ptr<RecognitionStages::Recipe> RecognitionStages::recipeOf(const RecognitionUnit& unit) {
  const std::lock_guard lock(mutex_);
  auto& known = recipes_[fmt::format("{}\n{}\n{}", unit.preset, unit.keypoint, unit.descriptor)];
  std::shared_ptr<Recipe> recipe = known.lock();
  if (recipe == nullptr)
    known = recipe = std::make_shared<Recipe>(unit.preset, optionsOf(unit),
                                              options_.modelFilters.size() * pairs_.models.size());
  latest_ = recipe;  // the next unit mostly wants the same
  return recipe;
}

bool RecognitionStages::isCorrect(const RecognitionTask& task, std::size_t model,
                                  const cv::Affine3d& pose) const {
  for (const ModelPairs::Pair& pair : pairs_.pairs) {
    if (pair.scene != task.unit.scene || pair.model != model) continue;
    for (const cv::Affine3d& truth : pair.poses)
      if (experiments::isCorrect(poseError(pose, truth, models_[model].center, models_[model].symmetries),
                                 options_.translation, options_.rotation))
        return true;
  }
  return false;
}

cv::Affine3d RecognitionStages::frameOf(const RecognitionUnit& unit) const {
  return options_.elsewhere ? randomFrame(unit.scene + 1) : cv::Affine3d::Identity();
}

PointCloud RecognitionStages::withNoise(PointCloud cloud, const RecognitionUnit& unit) const {
  constexpr double across = 0.0014;  // noise of a Kinect: withDepthNoise()
  return options_.depthNoise ? withDepthNoise(std::move(cloud), unit.noise, across, unit.seed)
                             : withGaussianNoise(std::move(cloud), unit.noise, unit.seed);
}

void RecognitionStages::look(const RecognitionTask& task, RecognitionFound& found) {
  const RecognitionUnit& unit = task.unit;
  const ModelPairs::Scene& shown = pairs_.scenes[unit.scene];
  PointCloud noisy = readCloud(shown.file);
  if (unit.noise > 0) noisy = withNoise(std::move(noisy), unit);
  const auto filtered =
      clouds_.get(fmt::format("{} {}{} {}", sceneDigests_[unit.scene], unit.noise,
                              options_.depthNoise ? " at 1 m" : "", unit.noise > 0 ? unit.seed : 0),
                  filterOf(unit.preset, unit.sceneFilter, unit.size), [&] { return noisy; });
  found.filterSeconds = filtered.seconds;

  const auto recipe = recipeOf(unit);
  const auto start = Clock::now();
  std::shared_ptr<const PreparedScene> scene;
  const std::string problem = problemOf([&] {
    const cv::Affine3d frame = frameOf(unit);
    scene =
        recipe->recognizer.prepareScene(shown.name, movedBy(frame, noisy), movedBy(frame, filtered.cloud));
  });
  found.describeSeconds = secondsSince(start);
  // Models of one filter are verified together.
  std::vector<std::vector<PoseCandidates>> candidates(options_.modelFilters.size());
  std::map<std::pair<std::size_t, std::string>, std::size_t> searchOf;  // search of filter and model
  for (std::size_t s = 0; s < found.searches.size(); ++s) {
    RecognitionSearch& search = found.searches[s];
    if (interrupted()) throw Interrupted("");
    const auto preparing = Clock::now();
    const Entry& entry = modelOf(*recipe, search);
    search.problem = problem.empty() ? entry.problem : problem;
    if (search.problem.empty()) search.problem = problemOf([&] { describe(*entry.model, *scene); });
    if (!search.problem.empty()) continue;
    search.modelSeconds = secondsSince(preparing);
    const auto looking = Clock::now();
    std::vector<PoseCandidates>& together = candidates[search.modelFilter];
    search.problem = problemOf([&] { together.push_back(recipe->recognizer.search(*entry.model, *scene)); });
    search.seconds = secondsSince(looking);
    if (search.problem.empty()) searchOf[{search.modelFilter, pairs_.models[search.model].name}] = s;
  }
  for (std::size_t filter = 0; filter < candidates.size(); ++filter) {
    const auto verifying = Clock::now();
    const std::vector<Detection> detections = recipe->recognizer.verify(candidates[filter]);
    const double seconds =
        secondsSince(verifying) / static_cast<double>(std::max<std::size_t>(candidates[filter].size(), 1));
    for (const auto& [place, s] : searchOf)
      if (place.first == filter) found.searches[s].seconds += seconds;
    for (const Detection& detection : detections) {
      RecognitionSearch& search = found.searches[searchOf.at({filter, detection.model})];
      const bool correct = isCorrect(task, search.model, frameOf(unit).inv() * detection.pose);
      if (!search.verified) search.correct = correct;
      search.verified = true;
      (correct ? search.right : search.extra) += 1;
    }
  }
  for (RecognitionSearch& search : found.searches) {  // several at one true pose
    const std::size_t poses = posesOf(task, search.model);
    if (search.right > poses) search.extra += search.right - poses;
  }
}

std::size_t RecognitionStages::posesOf(const RecognitionTask& task, std::size_t model) const {
  std::size_t count = 0;
  for (const ModelPairs::Pair& pair : pairs_.pairs)
    if (pair.scene == task.unit.scene && pair.model == model) count += pair.poses.size();
  return count;
}

const RecognitionStages::Entry& RecognitionStages::modelOf(Recipe& recipe, const RecognitionSearch& search) {
  const Model& model = models_[search.model];
  Entry& entry = recipe.models[search.modelFilter * pairs_.models.size() + search.model];
  std::call_once(entry.made, [&] {
    const auto filtered =
        clouds_.get(model.digest,
                    filterOf(recipe.preset, options_.modelFilters[search.modelFilter], options_.modelPoints),
                    [&] { return model.cloud; });
    entry.problem = problemOf([&] {
      entry.model = recipe.recognizer.prepareModel(pairs_.models[search.model].name, filtered.cloud);
    });
  });
  return entry;
}

RecognitionFound RecognitionStages::recognize(const RecognitionTask& task) {
  RecognitionFound found;
  for (std::size_t filter = 0; filter < options_.modelFilters.size(); ++filter)
    for (const std::size_t model : task.models) {
      RecognitionSearch search;
      search.modelFilter = filter;
      search.model = model;
      found.searches.push_back(search);
    }
  look(task, found);
  return found;
}

}  // namespace estancia::experiments
