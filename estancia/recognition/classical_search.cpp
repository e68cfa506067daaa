#include "estancia/recognition/classical_search.hpp"

#include <algorithm>
#include <utility>

#include "estancia/core/parallel.hpp"
#include "estancia/recognition/distinct_poses.hpp"

namespace estancia {

std::vector<PoseHypothesis> refineClassical(std::vector<PoseHypothesis> poses,
                                            const PreparedModel::Described& model,
                                            const PreparedScene::Described& scene,
                                            const RecognitionOptions& options) {
  constexpr double minCosine = 0.985;  // of 10°
  constexpr std::size_t maxFine = 20;
  constexpr int rounds = 15;
  const RecognitionScales& scales = scene.scales;
  const cv::Point3d middle = meanOf(model.dense.coarse.points);
  const auto refined = [&](std::vector<PoseHypothesis> hypotheses, const OrientedPoints& points,
                           const Surface& surface, double reach, double minDistance) {
    inParallel(hypotheses.size(), options.threads, Progress::none(), "stopped while poses were refined",
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
  poses = refined(std::move(poses), model.dense.coarse, *scene.coarse, 2 * scales.consistency,
                  scales.consistency / 2);
  if (poses.size() > maxFine) poses.resize(maxFine);
  return refined(std::move(poses), model.dense.fine, *scene.surface, 2 * scales.tolerance,
                 scales.consistency);
}

std::vector<PoseHypothesis> verifyClassical(const std::vector<PoseHypothesis>& poses,
                                            const PreparedModel::Described& model,
                                            const PreparedScene::Described& scene,
                                            const RecognitionOptions& options) {
  std::vector<bool> accepted;
  if (options.verification == "inliers") {
    for (const PoseHypothesis& h : poses) accepted.push_back(isAccepted(h.counts, options.accept));
  } else {
    std::vector<cv::Affine3d> hypotheses;
    for (const PoseHypothesis& h : poses) hypotheses.push_back(h.pose);
    const OrientedPoints points = spreadPointsBy(*model.surface, scene.scales.tolerance);
    accepted =
        verifyGlobally(points, *scene.coarse, scene.view, scene.parts, hypotheses, scene.scales.tolerance);
  }
  std::vector<PoseHypothesis> kept;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (accepted[i]) kept.push_back(poses[i]);
  return kept;
}

}  // namespace estancia
