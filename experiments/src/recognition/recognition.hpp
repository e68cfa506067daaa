// Known objects looked for in noisy scenes, by every filter, keypoint detector and descriptor
// (thesis 2.5, 2.6: Tables 2.2 to 2.17). docs/measured/recognition.md shows the tables that it makes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "experiments/src/findings/findings.hpp"
#include "experiments/src/recognition/model_pairs.hpp"
#include "experiments/src/runner/experiment.hpp"
#include "experiments/src/runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct RecognitionExperimentOptions {
  /// An object that looks the same after a turn by 360°/fold.
  struct Symmetry {
    std::string model;
    cv::Vec3d axis;
    std::optional<cv::Vec3d> point;  ///< on the axis [m, in the model's frame]; none: the model's center
    int fold = 360;
  };

  std::filesystem::path pairs;  ///< see readModelPairs()
  ModelPairsOptions columns;
  std::vector<std::string> scenes;  ///< only these; none: all
  std::vector<std::string> presets{"default"};
  std::vector<std::string> modelFilters{"none"}, sceneFilters{"none"};
  std::size_t modelPoints = 5000;         ///< that filters leave of a model
  std::vector<std::size_t> sizes{20000};  ///< points that filters leave of a scene
  std::vector<double> noises{0};          ///< standard deviations [m]
  std::vector<std::uint64_t> seeds{1};    ///< of the noise
  std::vector<std::string> keypoints{"uniform"}, descriptors{"shot"};

  /// Where models are looked for in vain.
  enum class Absent {
    all,    ///< every model in every scene where its object is not
    some,   ///< absentCount of these
    object  ///< one model of each object in every scene where that is not
  };
  Absent absent = Absent::all;
  std::size_t absentCount = 0;
  std::uint64_t absentSeed = 1;  ///< of the choice

  double translation = 0.02;  ///< of a correct pose, at most: at the model's center [m] …
  double rotation = 15;       ///< … and [degrees]
  std::vector<Symmetry> symmetries;
  std::size_t keptMegabytes = 4096;  ///< of filtered clouds in the experiment's folder
};

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
  std::size_t size = 0;  ///< points that the filter leaves; 0: all
  double noise = 0;
  std::uint64_t seed = 1;
  std::size_t scene = 0;
};

/// What a unit finds of one model: of a filter, in a scene that holds it or does not.
struct RecognitionSearch {
  std::size_t modelFilter = 0, model = 0;
  bool verified = false;    ///< an instance was found
  bool correct = false;     ///< the best one lies where the model does
  std::string problem;      ///< why it could not be looked for, as nothing could be described; else ""
  double seconds = 0;       ///< without what the scene takes …
  double modelSeconds = 0;  ///< … and what the model does, where it is not yet described for such a scene
};

struct RecognitionFound {
  double filterSeconds = 0, describeSeconds = 0;  ///< of the scene
  std::vector<RecognitionSearch> searches;        ///< in the order that they were asked for
};

/// What a unit looks for, models filter by filter.
struct RecognitionTask {
  RecognitionUnit unit;
  std::vector<std::size_t> models;  ///< that the scene holds, and those that it does not
};

/// What recognizes, and says all that a unit's findings depend on: units of other inputs are found anew.
class RecognitionWork {
 public:
  virtual ~RecognitionWork() = default;
  virtual std::string inputs(const RecognitionUnit& unit) const = 0;
  /// Called by several threads at once. Throws what ends the experiment.
  virtual RecognitionFound recognize(const RecognitionTask& task) = 0;
};

/// The same with other means of recognition.
Findings compareRecognitionBy(const RecognitionExperimentOptions& options, const ModelPairs& pairs,
                              RecognitionWork& work, Grid& grid, const ExperimentRun& run,
                              Progress& progress);

/// The models that are looked for in each scene where their objects are not.
std::vector<std::vector<std::size_t>> absentModels(const ModelPairs& pairs,
                                                   const RecognitionExperimentOptions& options);

}  // namespace estancia::experiments
