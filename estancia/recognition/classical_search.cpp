#include "estancia/recognition/classical_search.hpp"

#include <algorithm>
#include <utility>

#include "estancia/core/parallel.hpp"
#include "estancia/recognition/different_poses.hpp"

namespace estancia {

std::vector<CandidatePose> candidatesOf(const std::vector<TriedPose>& poses,
                                        const PreparedModel::Described& model,
                                        const PreparedScene::Described& scene,
                                        const RecognitionOptions& options) {
  constexpr double alike = 0.985;  // cosine of 10°
  constexpr std::size_t promising = 20;
  constexpr int rounds = 15;
  const RecognitionScales& scales = scene.scales;
  const cv::Point3d middle = meanOf(model.tried.few.points);
  const auto refined = [&](std::vector<CandidatePose> candidates, const OrientedPoints& points,
                           const Surface& surface, double reach, double apart) {
    Progress silent;
    inParallel(candidates.size(), options.threads, silent, "stopped while poses were refined",
               [&](std::size_t i) {
                 CandidatePose& c = candidates[i];
                 c.pose = refinePose(points, surface, c.pose, reach, rounds);
                 c.evidence = examine(points, surface, scene.view, c.pose, scales.tolerance);
               });
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const CandidatePose& a, const CandidatePose& b) {
                       return a.evidence.inliers > b.evidence.inliers;
                     });
    return differentPoses(std::move(candidates), middle, apart, alike);
  };
  std::vector<CandidatePose> candidates;
  for (const TriedPose& p : poses) candidates.push_back({p.pose, {}});
  candidates = differentPoses(std::move(candidates), middle, scales.consistency / 2, alike);
  candidates = refined(std::move(candidates), model.tried.few, *scene.coarse, 2 * scales.consistency,
                       scales.consistency / 2);
  if (candidates.size() > promising) candidates.resize(promising);
  return refined(std::move(candidates), model.tried.many, *scene.surface, 2 * scales.tolerance,
                 scales.consistency);
}

void keepVerified(std::vector<CandidatePose>& candidates, const PreparedModel::Described& model,
                  const PreparedScene::Described& scene, const RecognitionOptions& options) {
  if (options.verification == "inliers") {
    std::erase_if(candidates, [&](const CandidatePose& c) { return !isThere(c.evidence, options.accept); });
    return;
  }
  std::vector<cv::Affine3d> poses;
  for (const CandidatePose& c : candidates) poses.push_back(c.pose);
  const OrientedPoints points = spreadPointsBy(*model.surface, scene.scales.tolerance);
  const std::vector<bool> there =
      verifyGlobally(points, *scene.coarse, scene.view, scene.parts, poses, scene.scales.tolerance);
  std::vector<CandidatePose> left;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (there[i]) left.push_back(candidates[i]);
  candidates = std::move(left);
}

}  // namespace estancia
