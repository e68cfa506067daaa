// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/recognizer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>

#include "estancia/cloud/bounds.hpp"
#include "estancia/cloud/viewpoint.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/recognition/grouping.hpp"
#include "estancia/recognition/pose_candidates.hpp"

namespace estancia {
namespace {

/// The points that were measured. Throws Error unless they are enough, and 32 bits distinguish neighbors.
PointCloud measuredPoints(const std::string& name, const PointCloud& cloud) {
  constexpr std::size_t minPoints = 10;
  PointCloud finite;
  finite.viewpoint = cloud.viewpoint;
  const bool normals = cloud.normals.size() == cloud.points.size();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!isMeasured(cloud.points[i])) continue;
    finite.points.push_back(cloud.points[i]);
    if (normals) finite.normals.push_back(cloud.normals[i]);
    if (!cloud.colors.empty()) finite.colors.push_back(cloud.colors[i]);
  }
  if (finite.points.size() < minPoints)
    fail(ErrorCode::insufficientData,
         "{}: {} of its {} points are finite and not at 0, 0, 0; recognition needs {} or more", name,
         finite.points.size(), cloud.points.size(), minPoints);
  const Bounds<float> box = boundsOf(finite.points);
  const double middle = cv::norm((box.low + box.high) / 2), extent = cv::norm(box.high - box.low);
  constexpr double maxDistance = 1e5;  // extents: 32 bits have 7 digits, of which two are left
  if (extent > 0 && middle > maxDistance * extent)
    fail(ErrorCode::invalidInput,
         "{}: {:.4g} m from its origin, the 32-bit coordinates of a cloud of {:.4g} m are too coarse; "
         "subtract an offset (of a map's projection, say) before the cloud is written",
         name, middle, extent);
  finite.width = finite.points.size();
  finite.height = 1;
  return finite;
}

/// A PreparedModel or PreparedScene of the filtered cloud.
template <class Prepared, class... More>
std::shared_ptr<const Prepared> prepared(const std::string& name, const PointCloud& cloud,
                                         const RecognitionOptions& options, const FilterOptions& filter,
                                         Progress& progress, const More&... more) {
  std::vector<StageReport> stages;
  StageLog log(&stages);
  PointCloud raw = measuredPoints(name, cloud), left = filterCloud(raw, filter, progress);
  log.add("filter", fmt::format("{}: {} of {} points", filter.method, left.points.size(), raw.points.size()));
  left = measuredPoints(name, left);
  return std::make_shared<const Prepared>(name, std::move(raw), std::move(left), options, std::move(stages),
                                          more...);
}

/// Position of the sensor: as given, else as determined by the cloud's grid.
std::optional<cv::Point3d> sensorOf(const PointCloud& cloud, const RecognitionOptions& options) {
  return options.viewpoint || cloud.viewpoint ? std::nullopt : viewpointOfGrid(cloud);
}

void requireSameUnits(const PreparedModel& model, const PreparedScene& scene) {
  constexpr double maxRatio = 5, minRatio = 0.001;  // ratio of the model's extent to the scene's
  constexpr double minPoints = 5;                   // points of the scene across the model
  const double ratio = model.extent() / scene.surface().extent();
  if (ratio > maxRatio || ratio < minRatio || model.extent() < minPoints * scene.resolution())
    fail(ErrorCode::mismatch,
         "{} measures {:.4g} m and {} {:.4g} m, with points {:.4g} m apart; if {} in millimeters, give {} mm",
         model.name(), model.extent(), scene.name(), scene.surface().extent(), scene.resolution(),
         ratio > maxRatio ? "the object is" : "the scene is",
         ratio > maxRatio ? "--object-unit" : "--scene-unit");
}

/// A plane can slide and turn in itself, so its pose is undefined.
void requireShape(const std::string& name, const OrientedPoints& points) {
  constexpr double flat = 0.005;  // share of the scatter of normals; (sine of 4°)²
  cv::Matx33d scatter = cv::Matx33d::zeros();
  for (const cv::Point3f& n : points.normals) {
    const cv::Vec3d v(n.x, n.y, n.z);
    scatter += v * v.t();
  }
  cv::Vec3d values;  // descending
  cv::eigen(scatter, values);
  if (values[1] < flat * cv::trace(scatter))
    fail(ErrorCode::invalidInput,
         "{} is planar, so its pose is undefined; give a cloud that shows more of the object", name);
}

/// One model in one scene, both described at the same scales.
struct Pair {
  const RecognitionOptions& options;
  const PreparedModel& model;
  const PreparedModel::Described& modelSurface;
  const PreparedScene& scene;
  const PreparedScene::Described& sceneSurface;

  bool byEvidence() const { return options.verification == "evidence"; }
};

/// ICP with the coarse points of the model (thesis 2.4.6), and of the best poses with the fine ones. Most
/// inliers first, distinct ones.
std::vector<PoseHypothesis> refineClassical(const Pair& p, std::vector<PoseHypothesis> poses) {
  constexpr double minCosine = 0.985;  // cosine of 10°
  constexpr std::size_t maxFine = 20;
  constexpr int rounds = 15;
  const PreparedScene::Described& scene = p.sceneSurface;
  const DenseModel& dense = p.modelSurface.dense;
  const RecognitionScales& scales = scene.scales;
  const cv::Point3d middle = meanOf(dense.coarse.points);
  const auto refined = [&](std::vector<PoseHypothesis> hypotheses, const OrientedPoints& points,
                           const Surface& surface, double reach, double minDistance) {
    inParallel(hypotheses.size(), p.options.threads, Progress::none(), "stopped while poses were refined",
               [&](std::size_t i) {
                 PoseHypothesis& h = hypotheses[i];
                 h.pose = refinePose(points, surface, h.pose, reach, rounds);
                 h.counts = countInliers(points, surface, scene.view, h.pose, scales.tolerance);
               });
    std::stable_sort(
        hypotheses.begin(), hypotheses.end(),
        [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.counts.inliers > b.counts.inliers; });
    return distinctPoses(std::move(hypotheses), middle, minDistance, minCosine);
  };
  poses = distinctPoses(std::move(poses), middle, scales.consistency / 2, minCosine);
  poses =
      refined(std::move(poses), dense.coarse, *scene.coarse, 2 * scales.consistency, scales.consistency / 2);
  if (poses.size() > maxFine) poses.resize(maxFine);
  return refined(std::move(poses), dense.fine, *scene.surface, 2 * scales.tolerance, scales.consistency);
}

/// The poses that the verification of `options`, "global" or "inliers", accepts (thesis 2.4.7).
std::vector<PoseHypothesis> verifyClassical(const Pair& p, const std::vector<PoseHypothesis>& poses) {
  const PreparedScene::Described& scene = p.sceneSurface;
  std::vector<bool> accepted;
  if (p.options.verification == "inliers") {
    for (const PoseHypothesis& h : poses) accepted.push_back(isAccepted(h.counts, p.options.accept));
  } else {
    std::vector<cv::Affine3d> hypotheses;
    for (const PoseHypothesis& h : poses) hypotheses.push_back(h.pose);
    const OrientedPoints points = spreadPointsBy(*p.modelSurface.surface, scene.scales.tolerance);
    accepted =
        verifyGlobally(points, *scene.coarse, scene.view, scene.parts, hypotheses, scene.scales.tolerance);
  }
  std::vector<PoseHypothesis> kept;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (accepted[i]) kept.push_back(poses[i]);
  return kept;
}

std::vector<Match> match(const Pair& p) {
  return matchDescriptors(p.modelSurface.features.descriptors, p.sceneSurface.features.descriptors,
                          p.options.matchEach == "scene" ? MatchEach::scene : MatchEach::model,
                          p.options.neighbors, p.options.matchDistance, p.options.threads);
}

std::vector<PoseHypothesis> group(const Pair& p, const std::vector<Match>& matches) {
  const RecognitionOptions& o = p.options;
  const SurfaceFeatures &model = p.modelSurface.features, &scene = p.sceneSurface.features;
  const RecognitionScales& scales = p.sceneSurface.scales;
  if (o.grouping == "local-frames")
    return posesFromLocalFrames(model, scene, matches, p.modelSurface.dense, p.sceneSurface.dense(), scales,
                                o.maxHypotheses, o.threads);
  std::vector<PoseHypothesis> poses;
  for (const Hypothesis& h :
       groupMatches(model, scene, matches, o.grouping, scales.consistency, o.minMatches, o.threads))
    poses.push_back({.pose = h.pose, .matches = h.matches.size(), .score = {}, .evidence = 0, .counts = {}});
  return poses;
}

std::vector<PoseHypothesis> refine(const Pair& p, std::vector<PoseHypothesis> poses) {
  if (poses.size() > p.options.maxHypotheses) poses.resize(p.options.maxHypotheses);
  return p.byEvidence() ? refineDense(std::move(poses), p.modelSurface.dense, p.sceneSurface.dense(),
                                      p.sceneSurface.scales, p.options.threads)
                        : refineClassical(p, std::move(poses));
}

/// The instances that are or may be accepted as long as no other explains their surface, at places of their
/// own.
Instances verifyAlone(const Pair& p, const std::vector<PoseHypothesis>& poses) {
  const double apart = p.model.extent() / 4;
  if (p.byEvidence())
    return instancesOf(poses, p.model.center(), apart, FalseAlarmModel::maybe(p.options.falseAlarmRate));
  return {distinctPoses(verifyClassical(p, poses), meanOf(p.modelSurface.dense.coarse.points), apart,
                        anyRotation),
          {}};
}

/// The number of those that are sure, as long as no other explains their surface.
std::size_t instancesAlone(const Pair& p, const Instances& found) {
  if (!p.byEvidence()) return found.poses.size();
  return static_cast<std::size_t>(std::ranges::count_if(found.poses, [&](const PoseHypothesis& h) {
    return found.falseAlarms.rate(h.evidence) <= p.options.falseAlarmRate;
  }));
}

int percent(double share) {
  return static_cast<int>(std::lround(100 * share));
}

std::string supportOfBest(const std::vector<PoseHypothesis>& poses) {
  return poses.empty() ? "" : fmt::format(", the best {} % supported", percent(poses[0].score.supported));
}

std::string inliersOfBest(const std::vector<PoseHypothesis>& poses) {
  if (poses.empty()) return "";
  const InlierCounts& counts = poses[0].counts;
  return fmt::format(", the best confirmed by {} of {} points, {:.2f} of what should be seen", counts.inliers,
                     counts.facing, counts.confidence());
}

/// Describes the best pose, accepted or not: "; best pose 0.19 of 0.25 needed, where wrong poses reach 0.12:
/// 41 % supported, 12 % seen through".
std::string comparison(const std::vector<PoseHypothesis>& poses, const FalseAlarmModel& falseAlarms,
                       double rate) {
  if (poses.empty()) return "";
  const PoseScore& a = poses[0].score;
  return fmt::format(
      "; best pose {:.2f} of {:.2f} needed, where wrong poses reach {:.2f}: false alarm rate {:.1e} of {:g} "
      "allowed; {} % supported ({} % outlined), {} % seen through, {} % elsewhere, {} % hidden, {} % turned "
      "away",
      poses[0].evidence, falseAlarms.evidenceOf(rate), falseAlarms.chance(),
      falseAlarms.rate(poses[0].evidence), rate, percent(a.supported), percent(a.outlined),
      percent(a.seenThrough + a.behind), percent(a.mismatched), percent(a.occluded), percent(1 - a.facing));
}

Detection detectionOf(const PoseCandidates& of, const PoseHypothesis& h) {
  return {.model = of.model->name(),
          .pose = of.scene->fromView() * h.pose,
          .inliers = h.counts.inliers,
          .confidence = h.counts.confidence(),
          .center = of.model->center()};
}

Detection detectionOf(const PoseCandidates& of, const PoseHypothesis& h, double evidence) {
  const double rate = of.falseAlarms.rate(evidence);
  Detection detection = detectionOf(of, h);
  detection.inliers = h.score.points;
  detection.confidence = 1 - rate;
  detection.falseAlarmRate = rate;
  return detection;
}

}  // namespace

Recognizer::Recognizer(RecognitionOptions options) : options_(std::move(options)) {
  validate(options_);
}

void Recognizer::addModel(const std::string& name, const PointCloud& cloud) {
  models_.push_back(prepareModel(name, cloud));
}

std::vector<Detection> Recognizer::detect(const PointCloud& scene, Progress& progress,
                                          std::vector<Detection>* maybe) const {
  const auto prepared = prepareScene("scene", scene, progress);
  std::vector<PoseCandidates> candidates;
  for (const auto& model : models_) candidates.push_back(search(*model, *prepared));
  return verify(candidates, maybe);
}

std::shared_ptr<const PreparedModel> Recognizer::prepareModel(const std::string& name,
                                                              const PointCloud& cloud,
                                                              Progress& progress) const {
  return prepared<PreparedModel>(name, cloud, options_, options_.modelFilter, progress);
}

std::shared_ptr<const PreparedScene> Recognizer::prepareScene(const std::string& name,
                                                              const PointCloud& cloud,
                                                              Progress& progress) const {
  return prepared<PreparedScene>(name, cloud, options_, options_.sceneFilter, progress,
                                 sensorOf(cloud, options_));
}

std::shared_ptr<const PreparedScene> Recognizer::prepareScene(const std::string& name,
                                                              const PointCloud& cloud,
                                                              const PointCloud& filtered) const {
  return std::make_shared<const PreparedScene>(name, measuredPoints(name, cloud),
                                               measuredPoints(name, filtered), options_,
                                               std::vector<StageReport>{}, sensorOf(cloud, options_));
}

PoseCandidates Recognizer::search(const PreparedModel& model, const PreparedScene& scene,
                                  std::vector<StageReport>* stages) const {
  requireSameUnits(model, scene);
  StageLog log(stages);
  const RecognitionScales scales = scene.scalesFor(model);
  const auto sceneSurface = scene.describedFor(scales);
  if (scales != scene.scales()) log.append(sceneSurface->stages, "scene's ");
  const auto modelSurface = model.describedFor(scales);
  log.append(modelSurface->stages);
  log.add("model", fmt::format("{} keypoints", modelSurface->features.size()));
  requireShape(model.name(), modelSurface->dense.coarse);

  const Pair pair{options_, model, *modelSurface, scene, *sceneSurface};
  const std::vector<Match> matches = match(pair);  // thesis 2.4.4
  log.add("matching", fmt::format("each of the {} keypoints of the {} with {}: {} matches",
                                  options_.matchEach == "scene" ? sceneSurface->features.size()
                                                                : modelSurface->features.size(),
                                  options_.matchEach, options_.neighbors, matches.size()));
  std::vector<PoseHypothesis> poses = group(pair, matches);  // 2.4.5
  log.add("grouping",
          options_.grouping == "local-frames"
              ? fmt::format("local-frames: {} poses{}", poses.size(), supportOfBest(poses))
              : fmt::format("{}, {:.4g} m: {} poses, {} matches agree on the first", options_.grouping,
                            scales.consistency, poses.size(), poses.empty() ? 0 : poses[0].matches));
  poses = refine(pair, std::move(poses));  // 2.4.6
  log.add("refinement", fmt::format("{} different poses{}", poses.size(),
                                    pair.byEvidence() ? supportOfBest(poses) : inliersOfBest(poses)));
  Instances instances = verifyAlone(pair, poses);  // 2.4.7
  log.add("verification",
          fmt::format(
              "{}: {} instances{}", options_.verification, instancesAlone(pair, instances),
              pair.byEvidence() ? comparison(poses, instances.falseAlarms, options_.falseAlarmRate) : ""));
  return {&model,
          &scene,
          modelSurface,
          sceneSurface,
          std::move(instances.poses),
          std::move(poses),
          instances.falseAlarms};
}

std::vector<Detection> Recognizer::verify(const std::vector<PoseCandidates>& candidates,
                                          std::vector<Detection>* maybe) const {
  std::vector<Detection> detections;
  if (options_.verification == "evidence") {
    const auto verified = verifyTogether(candidates, options_.falseAlarmRate, options_.threads);
    const auto add = [&](const std::vector<VerifiedInstance>& instances, std::vector<Detection>& to) {
      for (const VerifiedInstance& v : instances) {
        const PoseCandidates& of = candidates[v.candidates];
        to.push_back(detectionOf(of, of.instances[v.instance], v.evidence));
      }
    };
    add(verified.sure, detections);
    if (maybe != nullptr) add(verified.maybe, *maybe);
  } else {
    for (const PoseCandidates& of : candidates)
      for (const PoseHypothesis& h : of.instances) detections.push_back(detectionOf(of, h));
  }
  std::stable_sort(detections.begin(), detections.end(),
                   [](const Detection& a, const Detection& b) { return a.confidence > b.confidence; });
  return detections;
}

std::vector<Detection> Recognizer::find(const PreparedModel& model, const PreparedScene& scene,
                                        std::vector<StageReport>* stages) const {
  std::vector<PoseCandidates> candidates;
  candidates.push_back(search(model, scene, stages));
  return verify(candidates);
}

}  // namespace estancia
