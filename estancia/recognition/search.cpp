#include "estancia/recognition/search.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "estancia/recognition/classical_search.hpp"
#include "estancia/recognition/different_poses.hpp"
#include "estancia/recognition/grouping.hpp"
#include "estancia/recognition/matching.hpp"

namespace estancia {
namespace {

using DescribedModel = PreparedModel::Described;
using DescribedScene = PreparedScene::Described;

int percent(double share) {
  return static_cast<int>(std::lround(100 * share));
}

std::string toldOf(const std::vector<TriedPose>& poses) {
  return poses.empty() ? "" : fmt::format(", the best {} % supported", percent(poses[0].agreement.supported));
}

/// Of the best pose, accepted or not: "; best pose 0.19 of 0.25 needed: 41 % supported, 12 % seen through".
std::string comparison(const TriedPose& pose, double accept) {
  const PoseScore& a = pose.agreement;
  return fmt::format(
      "; best pose {:.2f} of {:.2f} needed: {} % supported, {} % seen through, {} % elsewhere, "
      "{} % hidden, {} % turned away",
      pose.score, accept, percent(a.supported), percent(a.seenThrough + a.behind), percent(a.mismatched),
      percent(a.occluded), percent(1 - a.facing));
}

/// Rises with the evidence from 0 to 1, is 0.5 where it is just enough.
double confidenceOf(double score, double accept) {
  return score > 0 ? score * score / (score * score + accept * accept) : 0;
}

/// One model in one scene, both described for the same lengths.
class Search {
 public:
  Search(const RecognitionOptions& options, const PreparedModel& model, const DescribedModel& described,
         const PreparedScene& scene, const DescribedScene& there, StageAccount& account)
      : options_(options),
        model_(model),
        described_(described),
        scene_(scene),
        there_(there),
        account_(account) {}

  std::vector<Detection> instances() const {
    std::vector<TriedPose> poses = grouped(matches());
    return options_.verification == "evidence" ? byEvidence(std::move(poses)) : byInliers(poses);
  }

 private:
  std::vector<Match> matches() const {
    const SurfaceFeatures &model = described_.features, &scene = there_.features;
    const bool eachScene = options_.matchEach == "scene";
    auto matches = matchDescriptors(model.descriptors, scene.descriptors,
                                    eachScene ? MatchEach::scene : MatchEach::model, options_.neighbors,
                                    options_.matchDistance, options_.threads);
    account_.add("matching", fmt::format("each of the {} keypoints of the {} with {}: {} matches",
                                         eachScene ? scene.size() : model.size(),
                                         eachScene ? "scene" : "model", options_.neighbors, matches.size()));
    return matches;
  }

  std::vector<TriedPose> grouped(const std::vector<Match>& matches) const {
    std::vector<TriedPose> poses;
    if (options_.grouping == "local-frames") {
      poses = posesOfFrames(described_.features, there_.features, matches, described_.tried, there_.dense(),
                            there_.scales, options_.hypotheses, options_.threads);
      account_.add("grouping", fmt::format("local-frames: {} poses{}", poses.size(), toldOf(poses)));
      return poses;
    }
    const double consistency = there_.scales.consistency;
    const auto hypotheses = groupMatches(described_.features, there_.features, matches, options_.grouping,
                                         consistency, options_.minimalMatches, options_.threads);
    account_.add("grouping", fmt::format("{}, {:.4g} m: {} poses, {} matches agree on the first",
                                         options_.grouping, consistency, hypotheses.size(),
                                         hypotheses.empty() ? 0 : hypotheses.front().matches.size()));
    for (const Hypothesis& h : hypotheses)
      if (poses.size() < options_.hypotheses) poses.push_back({h.pose, {}, 0});
    return poses;
  }

  std::vector<Detection> byEvidence(std::vector<TriedPose> poses) const {
    poses = refinePoses(std::move(poses), described_.tried, there_.dense(), there_.scales, options_.threads);
    account_.add("refinement", fmt::format("{} different poses{}", poses.size(), toldOf(poses)));
    const std::string best = poses.empty() ? "" : comparison(poses[0], options_.accept);
    std::erase_if(poses, [&](const TriedPose& p) { return p.score < options_.accept || !(p.score > 0); });
    std::vector<Detection> instances;
    for (const TriedPose& p : apart(std::move(poses), model_.center()))
      instances.push_back(instance(p.pose, p.agreement.points, confidenceOf(p.score, options_.accept)));
    account_.add("verification", fmt::format("evidence: {} instances{}", instances.size(), best));
    return instances;
  }

  std::vector<Detection> byInliers(const std::vector<TriedPose>& poses) const {
    std::vector<CandidatePose> candidates = candidatesOf(poses, described_, there_, options_);
    account_.add("refinement",
                 fmt::format("{} different poses{}", candidates.size(),
                             candidates.empty()
                                 ? ""
                                 : fmt::format(", the best confirmed by {} of {} points, {:.2f} of what "
                                               "should be seen",
                                               candidates[0].evidence.inliers, candidates[0].evidence.facing,
                                               candidates[0].evidence.confidence())));
    keepVerified(candidates, described_, there_, options_);
    std::vector<Detection> instances;
    for (const CandidatePose& c : apart(std::move(candidates), meanOf(described_.tried.few.points)))
      instances.push_back(instance(c.pose, c.evidence.inliers, c.evidence.confidence()));
    account_.add("verification", fmt::format("{}: {} instances", options_.verification, instances.size()));
    return instances;
  }

  /// An object is where no better instance of it is.
  template <class Posed>
  std::vector<Posed> apart(std::vector<Posed> poses, const cv::Point3d& middle) const {
    return differentPoses(std::move(poses), middle, model_.extent() / 4, anyTurn);
  }

  Detection instance(const cv::Affine3d& pose, std::size_t inliers, double confidence) const {
    return {model_.name(), scene_.fromView() * pose, inliers, confidence, model_.center()};
  }

  const RecognitionOptions& options_;
  const PreparedModel& model_;
  const DescribedModel& described_;
  const PreparedScene& scene_;
  const DescribedScene& there_;
  StageAccount& account_;
};

}  // namespace

std::vector<Detection> detectionsOf(const RecognitionOptions& options, const PreparedModel& model,
                                    const DescribedModel& described, const PreparedScene& scene,
                                    const DescribedScene& there, StageAccount& account) {
  return Search(options, model, described, scene, there, account).instances();
}

}  // namespace estancia
