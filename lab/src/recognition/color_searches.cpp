// SPDX-License-Identifier: Apache-2.0
#include "recognition/color_searches.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <opencv2/core.hpp>

#include "estancia/cloud/color_lab.hpp"
#include "estancia/cloud/filter.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/error.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "estancia/segmentation/clusters.hpp"
#include "recognition/pose_error.hpp"

namespace estancia::experiments {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

RecognitionOptions optionsOf(const ColorRecognitionOptions::Condition& condition,
                             const ColorRecognitionOptions& options) {
  RecognitionOptions recognition;
  recognition.descriptor = condition.descriptor;
  recognition.colorTolerance = condition.colorTolerance;
  recognition.sceneFilter.method = condition.sceneFilter;
  recognition.sceneFilter.points = options.points;
  recognition.sceneFilter.gng.colorWeight = condition.colorWeight;
  recognition.threads = 1;  // cells are taken side by side
  return recognition;
}

/// Counts of a part of the searches.
struct Counts {
  double pairs = 0, found = 0, right = 0, correct = 0, lookAlike = 0, absent = 0, falsePositives = 0,
         failed = 0, seconds = 0;

  void addTo(CellResults& results, const std::string& part) const {
    for (const auto& [measure, value] : {std::pair{"pairs", pairs},
                                         {"found", found},
                                         {"right", right},
                                         {"correct", correct},
                                         {"look_alikes", lookAlike},
                                         {"absent", absent},
                                         {"false_positives", falsePositives},
                                         {"failed", failed},
                                         {"seconds", seconds / std::max(1.0, pairs + absent)}})
      results.push_back({measure, part, value});
  }
};

/// Models and scenes of a condition, each prepared once.
class Searcher {
 public:
  Searcher(const ColorCases& cases, const ColorRecognitionOptions::Condition& condition,
           const ColorRecognitionOptions& options)
      : cases_(cases), options_(options), recognizer_(optionsOf(condition, options)) {}

  /// Adds a search to the counts of its parts.
  void search(const ColorCases::Search& search, const std::vector<Counts*>& parts) {
    std::vector<Detection> detections;
    bool failed = false;
    const auto& scene = sceneOf(search.scene);
    const auto start = Clock::now();
    try {
      detections = recognizer_.find(*modelOf(search.model), *scene);
    } catch (const Interrupted&) {
      throw;
    } catch (const Error&) {
      failed = true;  // for example a plane, whose pose is undefined
    }
    const double seconds = secondsSince(start);
    for (Counts* counts : parts) {
      counts->failed += failed ? 1 : 0;
      counts->seconds += seconds;
      if (search.truth.empty()) {
        ++counts->absent;
        counts->falsePositives += detections.empty() ? 0 : 1;
        continue;
      }
      ++counts->pairs;
      if (!detections.empty()) score(search, detections.front().pose, *counts);
    }
  }

  double sceneSeconds() const {
    return sceneSeconds_ / static_cast<double>(std::max<std::size_t>(scenes_, 1));
  }

 private:
  const std::shared_ptr<const PreparedScene>& sceneOf(std::size_t scene) {
    if (latest_ && latestNumber_ == scene) return latest_;
    const auto start = Clock::now();
    latest_ = recognizer_.prepareScene(cases_.scenes[scene].name, cases_.scenes[scene].cloud);
    latestNumber_ = scene;
    sceneSeconds_ += secondsSince(start);
    ++scenes_;
    return latest_;
  }

  const std::shared_ptr<const PreparedModel>& modelOf(std::size_t model) {
    auto& prepared = models_[model];
    if (!prepared) prepared = recognizer_.prepareModel(cases_.models[model].name, cases_.models[model].cloud);
    return prepared;
  }

  /// Which thing was found is that which is nearest to the detection.
  void score(const ColorCases::Search& search, const cv::Affine3d& pose, Counts& counts) const {
    const ColorCases::Model& model = cases_.models[search.model];
    const cv::Point3d center = centerOf(model.cloud);
    ++counts.found;
    double nearest = std::numeric_limits<double>::infinity();
    bool correct = false;
    for (const cv::Affine3d& truth : search.truth) {
      const PoseError error = poseError(pose, truth, center, model.symmetries);
      correct |= isCorrect(error, options_.translation, options_.rotation);
      nearest = std::min(nearest, cv::norm(pose * center - truth * center));
    }
    double other = std::numeric_limits<double>::infinity();
    for (const cv::Point3d& lookAlike : search.lookAlikes)
      other = std::min(other, cv::norm(pose * center - lookAlike));
    constexpr double near = 0.05;  // [m]
    counts.correct += correct ? 1 : 0;
    counts.right += nearest < near && nearest < other ? 1 : 0;
    counts.lookAlike += other < near && other < nearest ? 1 : 0;
  }

  const ColorCases& cases_;
  const ColorRecognitionOptions& options_;
  Recognizer recognizer_;
  std::map<std::size_t, std::shared_ptr<const PreparedModel>> models_;
  std::shared_ptr<const PreparedScene> latest_;
  std::size_t latestNumber_ = 0, scenes_ = 0;
  double sceneSeconds_ = 0;
};

double square(double v) {
  return v * v;
}

}  // namespace

CellResults searchWith(const ColorCases& cases, const ColorRecognitionOptions::Condition& condition,
                       const ColorRecognitionOptions& options) {
  // By scene, each of which is prepared once.
  std::vector<std::size_t> order(cases.searches.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return cases.searches[a].scene < cases.searches[b].scene;
  });
  Searcher searcher(cases, condition, options);
  std::map<std::string, Counts> counts;
  for (const std::size_t i : order) {
    if (interrupted()) throw Interrupted("");
    const ColorCases::Search& search = cases.searches[i];
    if (i % 2 == 0) {
      searcher.search(search, {&counts["choose"]});
    } else {
      searcher.search(search, {&counts["report"], &counts["report, " + cases.models[search.model].group]});
    }
  }
  CellResults results{{"scene_seconds", "", searcher.sceneSeconds()}};
  for (const auto& [part, count] : counts) count.addTo(results, part);
  return results;
}

CellResults gasErrors(const DriveCasesOptions& drive, double weight, std::size_t neurons) {
  constexpr std::size_t frames = 5, every = 7;  // every n-th of the true points
  DriveCasesOptions withoutNoise = drive;
  withoutNoise.noise = 0;
  const std::vector<PointCloud> noisy = framesOfDrive(drive, frames),
                                clean = framesOfDrive(withoutNoise, frames);
  FilterOptions filter;
  filter.method = "gng";
  filter.points = neurons;
  filter.gng.colorWeight = weight;
  double offsets = 0, counted = 0, colors = 0, points = 0, seconds = 0;
  for (std::size_t f = 0; f < noisy.size(); ++f) {
    const auto start = Clock::now();
    const PointCloud gas = filterCloud(noisy[f], filter);
    seconds += secondsSince(start) / static_cast<double>(noisy.size());
    const PointCloud truth = finitePoints(clean[f]);
    const Neighbors surface(truth.points), network(gas.points);
    const auto normals =
        estimateNormals(truth.points, surface, {.radius = 3 * spacingOf(surface), .threads = 1});
    std::vector<Neighbor> buffer;
    for (const cv::Point3f& p : gas.points) {
      const std::uint32_t i = surface.nearest(p, 1, buffer)[0].index;
      if (!isFinite(normals[i])) continue;
      offsets += square(static_cast<double>(normals[i].dot(p - truth.points[i])));
      ++counted;
    }
    for (std::size_t i = 0; i < truth.points.size(); i += every) {
      const std::uint32_t n = network.nearest(truth.points[i], 1, buffer)[0].index;
      colors += square(cv::norm(labOf(truth.colors[i]) - labOf(gas.colors[n])));
      ++points;
    }
  }
  return {{"offset", "", std::sqrt(offsets / std::max(counted, 1.0))},
          {"color_difference", "", std::sqrt(colors / std::max(points, 1.0))},
          {"seconds", "", seconds}};
}

}  // namespace estancia::experiments
