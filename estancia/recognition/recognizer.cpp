#include "estancia/recognition/recognizer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/core.hpp>

#include "estancia/core/error.hpp"
#include "estancia/recognition/grouping.hpp"
#include "estancia/recognition/keypoints.hpp"
#include "estancia/recognition/matching.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/verify.hpp"

namespace estancia {
namespace {

using DescribedModel = PreparedModel::Described;
using DescribedScene = PreparedScene::Described;

/// Tells what each stage kept, and how long it took.
class Account {
 public:
  explicit Account(std::vector<StageReport>* stages) : stages_(stages) {}

  void add(const std::string& stage, std::string detail) {
    const auto now = std::chrono::steady_clock::now();
    if (stages_)
      stages_->push_back({stage, std::move(detail), std::chrono::duration<double>(now - last_).count()});
    last_ = now;
  }

 private:
  std::vector<StageReport>* stages_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

template <class Known>
void requireKnown(const std::string& what, const std::string& name, const Known& known) {
  std::string names;
  for (const auto& [one, explanation] : known) {
    if (one == name) return;
    names += (names.empty() ? "" : ", ") + one;
  }
  throw Error(fmt::format("no {} is called '{}'; known are {}", what, name, names));
}

using Names = std::vector<std::pair<std::string, std::string>>;

void require(const RecognitionOptions& o) {
  requireKnown("keypoint detector", o.keypoints, keypointMethods());
  requireKnown("descriptor of a surface", o.descriptor, descriptorMethods());
  Names groupings = groupingMethods();
  groupings.emplace_back("local-frames", "each match is a pose by its two local frames");
  requireKnown("grouping", o.grouping, groupings);
  requireKnown("surface", o.surface, Names{{"filtered", ""}, {"mean", ""}});
  requireKnown("verification", o.verification, Names{{"global", ""}, {"inliers", ""}, {"evidence", ""}});
  requireKnown("side of matching", o.matchEach, Names{{"scene", ""}, {"model", ""}});
  for (const double length : {o.normalRadius, o.keypointSpacing, o.sceneKeypointSpacing, o.descriptorRadius,
                              o.consistency, o.tolerance})
    if (!(length >= 0) || !std::isfinite(length))
      throw Error(fmt::format(
          "a length of recognition is {} m; give a positive one, or 0 to follow the scene", length));
  if (o.normalRadius > 0 && o.normalNeighbours > 0)
    throw Error("normals need the radius or the number of the points around; give one of the two");
  if (!(o.matchDistance >= 0) || !std::isfinite(o.matchDistance))
    throw Error(fmt::format("descriptors cannot match within {}; give a positive distance, or 0 for any",
                            o.matchDistance));
  if (o.neighbours == 0 || o.hypotheses == 0)
    throw Error("recognition without any match or hypothesis finds nothing; allow at least one");
  if (!(o.accept >= 0 && o.accept <= 1))
    throw Error(fmt::format("no share of a model is {}; give one in [0, 1]", o.accept));
}

PointCloud finitePoints(const std::string& name, const PointCloud& cloud) {
  constexpr std::size_t few = 10;
  PointCloud left;
  left.viewpoint = cloud.viewpoint;
  const bool normals = cloud.normals.size() == cloud.points.size();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const cv::Point3f& p = cloud.points[i];
    if (!isFinite(p)) continue;
    left.points.push_back(p);
    if (normals) left.normals.push_back(cloud.normals[i]);
  }
  if (left.points.size() < few)
    throw Error(fmt::format("{}: {} of its {} points are finite; too few to be described", name,
                            left.points.size(), cloud.points.size()));
  left.width = left.points.size();
  left.height = 1;
  return left;
}

PointCloud filtered(const std::string& name, const PointCloud& cloud, const FilterOptions& options,
                    std::vector<StageReport>& stages, Progress& progress) {
  Account account(&stages);
  PointCloud left = filterCloud(cloud, options, progress);
  account.add("filter",
              fmt::format("{}: {} of {} points", options.method, left.points.size(), cloud.points.size()));
  return finitePoints(name, left);
}

void requireSameUnits(const PreparedModel& model, const PreparedScene& scene) {
  constexpr double largest = 5, smallest = 0.001;  // an object of the scene's size is odd enough
  constexpr double fewest = 10;                    // points across that show an object
  const double ratio = model.extent() / scene.surface().extent();
  if (ratio > largest || ratio < smallest || model.extent() < fewest * scene.resolution())
    throw Error(
        fmt::format("{} measures {:.4g} m and {} {:.4g} m, its points {:.4g} m apart: are they in different "
                    "units? Scale one of them{}",
                    model.name(), model.extent(), scene.name(), scene.surface().extent(), scene.resolution(),
                    ratio > 300 && ratio < 3000 ? ", millimetres by 0.001" : ""));
}

/// Planes slide and turn in themselves; whatever pose was found would mean nothing.
void requireShape(const std::string& name, const OrientedPoints& points) {
  constexpr double flat = 0.005;  // of the normals' scatter; (sine of 4°)²
  cv::Matx33d scatter = cv::Matx33d::zeros();
  for (const cv::Point3f& n : points.normals) {
    const cv::Vec3d v(n.x, n.y, n.z);
    scatter += v * v.t();
  }
  cv::Vec3d values;  // descending
  cv::eigen(scatter, values);
  if (values[1] < flat * cv::trace(scatter))
    throw Error(fmt::format(
        "{} is flat: its points do not tell how it lies; take a cloud that shows more of it", name));
}

struct Candidate {
  cv::Affine3d pose;
  Evidence evidence;
};

/// Same place within half a keypoint spacing or so and turned by less than 10°: one is enough.
void dropTwins(std::vector<Candidate>& candidates, const cv::Point3d& middle, double distance) {
  constexpr double alike = 0.985;  // cosine of 10°
  std::vector<Candidate> left;
  for (Candidate& c : candidates) {
    const bool twin = std::any_of(left.begin(), left.end(), [&](const Candidate& l) {
      const cv::Matx33d turn = l.pose.rotation().t() * c.pose.rotation();
      return cv::norm(l.pose * middle - c.pose * middle) < distance && (cv::trace(turn) - 1) / 2 > alike;
    });
    if (!twin) left.push_back(std::move(c));
  }
  candidates = std::move(left);
}

cv::Point3d middleOf(const OrientedPoints& points) {
  cv::Point3d sum;
  for (const cv::Point3f& p : points.points) sum += cv::Point3d(p);
  return sum / static_cast<double>(points.points.size());
}

std::vector<Candidate> candidatesOf(const std::vector<TriedPose>& poses, const DescribedModel& model,
                                    const DescribedScene& scene, const RecognitionOptions& options) {
  const RecognitionLengths& lengths = scene.lengths;
  const cv::Point3d middle = middleOf(model.tried.few);
  std::vector<Candidate> candidates;
  for (const TriedPose& p : poses) candidates.push_back({p.pose, {}});
  dropTwins(candidates, middle, lengths.consistency / 2);
  Progress silent;
  const auto each = [&](const auto& work) {
    inParallel(candidates.size(), options.threads, silent, "stopped while poses were refined",
               [&](std::size_t i) { work(candidates[i]); });
  };
  each([&](Candidate& c) {
    c.pose = refinePose(model.tried.few, *scene.coarse, c.pose, 2 * lengths.consistency, 15);
    c.evidence = examine(model.tried.few, *scene.coarse, scene.view, c.pose, lengths.tolerance);
  });
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.evidence.inliers > b.evidence.inliers;
  });
  dropTwins(candidates, middle, lengths.consistency / 2);
  constexpr std::size_t promising = 20;
  if (candidates.size() > promising) candidates.resize(promising);
  each([&](Candidate& c) {
    c.pose = refinePose(model.tried.many, *scene.surface, c.pose, 2 * lengths.tolerance, 15);
    c.evidence = examine(model.tried.many, *scene.surface, scene.view, c.pose, lengths.tolerance);
  });
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.evidence.inliers > b.evidence.inliers;
  });
  dropTwins(candidates, middle, lengths.consistency);
  return candidates;
}

void keepVerified(std::vector<Candidate>& candidates, const DescribedModel& model,
                  const DescribedScene& scene, const RecognitionOptions& options) {
  if (options.verification == "inliers") {
    std::erase_if(candidates, [&](const Candidate& c) { return !isThere(c.evidence, options.accept); });
    return;
  }
  std::vector<cv::Affine3d> poses;
  for (const Candidate& c : candidates) poses.push_back(c.pose);
  const OrientedPoints points = spreadPointsBy(*model.surface, scene.lengths.tolerance);
  const std::vector<bool> there =
      verifyGlobally(points, *scene.coarse, scene.view, scene.parts, poses, scene.lengths.tolerance);
  std::vector<Candidate> left;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (there[i]) left.push_back(candidates[i]);
  candidates = std::move(left);
}

/// An object is where no better instance of it is.
template <class Posed>
void dropOverlapping(std::vector<Posed>& candidates, const cv::Point3d& middle, double extent) {
  std::vector<Posed> left;
  for (Posed& c : candidates)
    if (std::none_of(left.begin(), left.end(), [&](const Posed& l) {
          return cv::norm(l.pose * middle - c.pose * middle) < extent / 4;
        }))
      left.push_back(std::move(c));
  candidates = std::move(left);
}

int percent(double share) {
  return static_cast<int>(std::lround(100 * share));
}

std::string toldOf(const std::vector<TriedPose>& poses) {
  return poses.empty() ? "" : fmt::format(", the best {} % supported", percent(poses[0].agreement.supported));
}

/// Of the best pose, accepted or not: "; best pose 0.19 of 0.25 needed: 41 % supported, 12 % seen through".
std::string comparison(const TriedPose& pose, double accept) {
  const PoseAgreement& a = pose.agreement;
  return fmt::format(
      "; best pose {:.2f} of {:.2f} needed: {} % supported, {} % seen through, {} % elsewhere, "
      "{} % hidden, {} % turned away",
      pose.score, accept, percent(a.supported), percent(a.seenThrough + a.behind), percent(a.elsewhere),
      percent(a.occluded), percent(1 - a.facing));
}

/// Rises with the evidence from 0 to 1, is 0.5 where it is just enough.
double confidenceOf(double score, double accept) {
  return score > 0 ? score * score / (score * score + accept * accept) : 0;
}

}  // namespace

Recognizer::Recognizer(RecognitionOptions options) : options_(std::move(options)) {
  require(options_);
}

std::shared_ptr<const PreparedModel> Recognizer::prepareModel(const std::string& name,
                                                              const PointCloud& cloud) const {
  Progress silent;
  std::vector<StageReport> stages;
  PointCloud raw = finitePoints(name, cloud);
  PointCloud left = filtered(name, raw, options_.modelFilter, stages, silent);
  return std::make_shared<const PreparedModel>(name, std::move(raw), std::move(left), options_,
                                               std::move(stages));
}

std::shared_ptr<const PreparedScene> Recognizer::prepareScene(const std::string& name,
                                                              const PointCloud& cloud,
                                                              Progress& progress) const {
  std::vector<StageReport> stages;
  PointCloud raw = finitePoints(name, cloud);
  PointCloud left = filtered(name, raw, options_.sceneFilter, stages, progress);
  return std::make_shared<const PreparedScene>(name, std::move(raw), std::move(left), options_,
                                               std::move(stages));
}

std::shared_ptr<const PreparedScene> Recognizer::prepareScene(const std::string& name,
                                                              const PointCloud& cloud,
                                                              const PointCloud& filtered) const {
  return std::make_shared<const PreparedScene>(name, finitePoints(name, cloud), finitePoints(name, filtered),
                                               options_, std::vector<StageReport>{});
}

std::vector<Instance> Recognizer::find(const PreparedModel& model, const PreparedScene& scene,
                                       std::vector<StageReport>* stages) const {
  requireSameUnits(model, scene);
  Account account(stages);
  const RecognitionLengths lengths = scene.lengthsFor(model);
  const auto there = scene.describedFor(lengths);
  if (stages && lengths != scene.lengths())
    for (const StageReport& s : there->stages) stages->push_back({"scene's " + s.stage, s.detail, s.seconds});
  const auto described = model.describedFor(lengths);
  if (stages) stages->insert(stages->end(), described->stages.begin(), described->stages.end());
  account.add("model", fmt::format("{} keypoints", described->features.size()));
  requireShape(model.name(), described->tried.few);

  const bool eachScene = options_.matchEach == "scene";
  const auto matches = matchDescriptors(described->features.descriptors, there->features.descriptors,
                                        eachScene ? MatchEach::scene : MatchEach::model, options_.neighbours,
                                        options_.matchDistance, options_.threads);
  account.add("matching", fmt::format("each of the {} keypoints of the {} with {}: {} matches",
                                      eachScene ? there->features.size() : described->features.size(),
                                      eachScene ? "scene" : "model", options_.neighbours, matches.size()));
  const DenseLengths dense{lengths.unit, lengths.noise, lengths.spacing, lengths.tolerance};
  std::vector<TriedPose> poses;
  if (options_.grouping == "local-frames") {
    poses = posesOfFrames(described->features, there->features, matches, described->tried, there->dense(),
                          dense, options_.hypotheses, options_.threads);
    account.add("grouping", fmt::format("local-frames: {} poses{}", poses.size(), toldOf(poses)));
  } else {
    const auto hypotheses = groupMatches(described->features, there->features, matches, options_.grouping,
                                         lengths.consistency, options_.minimalMatches, options_.threads);
    account.add("grouping", fmt::format("{}, {:.4g} m: {} poses, {} matches agree on the first",
                                        options_.grouping, lengths.consistency, hypotheses.size(),
                                        hypotheses.empty() ? 0 : hypotheses.front().matches.size()));
    for (const Hypothesis& h : hypotheses)
      if (poses.size() < options_.hypotheses) poses.push_back({h.pose, {}, 0});
  }
  std::vector<Instance> instances;
  if (options_.verification == "evidence") {
    poses = refinePoses(std::move(poses), described->tried, there->dense(), dense, options_.threads);
    account.add("refinement", fmt::format("{} different poses{}", poses.size(), toldOf(poses)));
    const std::string best = poses.empty() ? "" : comparison(poses[0], options_.accept);
    std::erase_if(poses, [&](const TriedPose& p) { return p.score < options_.accept || !(p.score > 0); });
    dropOverlapping(poses, model.centre(), model.extent());
    for (const TriedPose& p : poses)
      instances.push_back({model.name(), scene.fromView() * p.pose, p.agreement.points,
                           confidenceOf(p.score, options_.accept), model.centre()});
    account.add("verification", fmt::format("evidence: {} instances{}", instances.size(), best));
    return instances;
  }
  std::vector<Candidate> candidates = candidatesOf(poses, *described, *there, options_);
  account.add("refinement",
              fmt::format("{} different poses{}", candidates.size(),
                          candidates.empty()
                              ? ""
                              : fmt::format(", the best confirmed by {} of {} points, {:.2f} of what "
                                            "should be seen",
                                            candidates[0].evidence.inliers, candidates[0].evidence.facing,
                                            candidates[0].evidence.confidence())));
  keepVerified(candidates, *described, *there, options_);
  dropOverlapping(candidates, middleOf(described->tried.few), model.extent());
  account.add("verification", fmt::format("{}: {} instances", options_.verification, candidates.size()));
  for (const Candidate& c : candidates)
    instances.push_back({model.name(), scene.fromView() * c.pose, c.evidence.inliers, c.evidence.confidence(),
                         model.centre()});
  return instances;
}

}  // namespace estancia
