// Recognition experiment: known objects in noisy scenes, by filter, keypoint detector and descriptor
// (thesis 2.5, 2.6: Tables 2.2 to 2.17). docs/measured/recognition.md shows the tables that it makes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "recognition/clutter.hpp"
#include "recognition/model_pairs.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct RecognitionExperimentOptions {
  /// An object that looks the same after a turn by 360°/fold.
  struct Symmetry {
    std::string model;
    cv::Vec3d axis;
    /// On the axis [m, in the model's frame]; none: the model's center.
    std::optional<cv::Vec3d> point;
    int fold = 360;
  };

  /// See readModelPairs().
  std::filesystem::path pairs;
  ModelPairsOptions columns;
  /// Only these; none: all.
  std::vector<std::string> scenes;
  std::vector<std::string> presets{"default"};
  std::vector<std::string> modelFilters{"none"}, sceneFilters{"none"};
  /// Points that filters leave of a model.
  std::size_t modelPoints = 5000;
  /// Points that filters leave of a scene.
  std::vector<std::size_t> sizes{20000};
  /// Standard deviations of the noise [m]; at 1 m, of a depth camera's (withDepthNoise()), if `depthNoise`.
  std::vector<double> noises{0};
  bool depthNoise = false;
  /// Seeds of the noise.
  std::vector<std::uint64_t> seeds{1};
  std::vector<std::string> keypoints{"uniform"}, descriptors{"shot"};

  /// Where models are looked for in vain.
  enum class Absent {
    /// Every model in every scene where its object is not.
    all,
    /// absentCount of these.
    some,
    /// One model of each object in every scene where that is not.
    object
  };
  Absent absent = Absent::all;
  std::size_t absentCount = 0;
  /// Seed of the choice of absent models.
  std::uint64_t absentSeed = 1;

  /// Largest translation error of a correct pose, at the model's center [m].
  double translation = 0.02;
  /// Largest rotation error of a correct pose [degrees].
  double rotation = 15;
  std::vector<Symmetry> symmetries;
  /// The thesis' numbers beside: for its pairs (Tombari, Salti, Di Stefano's Kinect data set).
  bool thesisTables = false;
  /// Scenes that are made of the models of `pairs`, in place of its own.
  ClutterOptions clutter;
  /// Whether each scene is moved into a frame of its own, like a map's: the sensor's position is unknown.
  bool elsewhere = false;
  /// Size of the cache of filtered clouds in the experiment's folder.
  std::size_t keptMegabytes = 4096;
};

OptionGroup declare(RecognitionExperimentOptions& options);

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
RecognitionExperimentOptions readRecognition(ConfigFile& config);

/// model_filter,scene_filter,size,noise,keypoint,descriptor,pairs,verified,correct,false_positives,seconds,…,
/// preset
GridColumns recognitionColumns();

/// Runs the experiment. Throws Error when the pairs or a cloud cannot be read.
Findings compareRecognition(const RecognitionExperimentOptions& options, Grid& grid, const ExperimentRun& run,
                            Progress& progress);

/// One scene, made noisy and filtered and described in one way; all models are looked for in it.
struct RecognitionUnit {
  std::string preset, keypoint, descriptor, sceneFilter;
  /// Points that the filter leaves; 0: all.
  std::size_t size = 0;
  double noise = 0;
  std::uint64_t seed = 1;
  std::size_t scene = 0;
};

/// What a unit finds of one model: of a filter, in a scene that holds it or does not.
struct RecognitionSearch {
  std::size_t modelFilter = 0, model = 0;
  /// An instance was found.
  bool verified = false;
  /// The best one lies where the model does.
  bool correct = false;
  /// Instances at true poses, and others: of another model's surface, or of the same pose again.
  std::size_t right = 0, extra = 0;
  /// Why it could not be looked for, as nothing could be described; else "".
  std::string problem;
  /// Time of the search without filtering and describing the scene.
  double seconds = 0;
  /// Time of describing the model, where that is not yet done for such a scene.
  double modelSeconds = 0;
};

struct RecognitionFound {
  /// Times of the scene.
  double filterSeconds = 0, describeSeconds = 0;
  /// In the order of the task.
  std::vector<RecognitionSearch> searches;
};

/// What a unit looks for, models filter by filter.
struct RecognitionTask {
  RecognitionUnit unit;
  /// Models that the scene holds, then those that it does not.
  std::vector<std::size_t> models;
};

/// Performs recognition, and identifies all that a unit's findings depend on: units of other inputs are found
/// anew.
class RecognitionWork {
 public:
  virtual ~RecognitionWork() = default;
  virtual std::string inputs(const RecognitionUnit& unit) const = 0;
  /// Called by several threads at once. Throws what ends the experiment.
  virtual RecognitionFound recognize(const RecognitionTask& task) = 0;
};

/// Compares other means of recognition.
Findings compareRecognitionBy(const RecognitionExperimentOptions& options, const ModelPairs& pairs,
                              RecognitionWork& work, Grid& grid, const ExperimentRun& run,
                              Progress& progress);

/// The models that are looked for in each scene where their objects are not.
std::vector<std::vector<std::size_t>> absentModels(const ModelPairs& pairs,
                                                   const RecognitionExperimentOptions& options);

}  // namespace estancia::experiments
