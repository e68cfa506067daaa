#include "estancia/recognition/prepared.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/cloud/mls_surface.hpp"
#include "estancia/cloud/noise.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/error.hpp"
#include "estancia/recognition/keypoints.hpp"
#include "estancia/recognition/scales.hpp"
#include "estancia/recognition/verify.hpp"
#include "estancia/recognition/viewpoint.hpp"

namespace estancia {
namespace {

bool isMean(const RecognitionOptions& options) {
  return options.surface == "mean";
}

/// A length that would silently find nothing, or everything, is likely to be in other units.
void requireLengths(const std::string& name, const RecognitionScales& scales, double extent,
                    double resolution) {
  const auto require = [&](double length, const char* what, double least, double good) {
    if (length >= least && length <= extent / 2) return;
    throw Error(
        fmt::format("{}: a {} of {:.4g} m does not fit a cloud that measures {:.4g} m and whose points lie "
                    "{:.4g} m apart; is it in other units? Then scale it; else about {:.4g} m would do",
                    name, what, length, extent, resolution, std::min(good, extent / 3)));
  };
  if (scales.normalRadius > 0) require(scales.normalRadius, "normal radius", resolution, 8 * resolution);
  require(scales.keypointSpacing, "keypoint spacing", resolution / 10, 5 * resolution);
  require(scales.consistency, "consistency", resolution / 10, 5 * resolution);
  require(scales.tolerance, "tolerance", resolution / 10, 3 * resolution);
}

/// The surface that was asked for, then its keypoints and descriptors. `raw`: what a mean surface averages.
DescribedSurface describedSurface(const std::string& name, const PointCloud& raw,
                                  const std::vector<cv::Point3f>& seeds, const PointCloud& filtered,
                                  double perPoint, const Orientation& orientation,
                                  const RecognitionOptions& options, const RecognitionScales& scales) {
  DescribedSurface described;
  StageAccount account(&described.stages);
  if (isMean(options)) {
    if (options.normalRadius > 0 || options.keypointSpacing > 0 || options.tolerance > 0)
      requireLengths(name, scales, extentOf(raw.points), scales.spacing);
    MlsOptions smoothing = smoothingFor(scales);
    smoothing.perPoint = perPoint;
    smoothing.away = orientation.outwards;
    if (orientation.outwards) smoothing.viewpoint = orientation.middle;
    smoothing.threads = options.threads;
    described.surface =
        std::make_unique<const Surface>(name, projectMls(seeds, raw, smoothing), options.threads);
    account.add("mean surface",
                fmt::format("of {} points over {:.4g} m, normals {:.4g} m: {} points {:.4g} m apart",
                            raw.points.size(), smoothing.width, smoothing.radius, described.surface->size(),
                            smoothing.spacing));
  } else {
    PointCloud oriented = filtered;
    const Neighbors neighbors(filtered.points, options.threads);
    if (scales.normalRadius > 0)
      requireRadius(name, filtered.points, neighbors, scales.normalRadius, "normal radius");
    requireLengths(name, scales, extentOf(filtered.points), resolutionOf(neighbors));
    oriented.normals = estimateNormals(
        filtered.points, neighbors,
        {.radius = scales.normalRadius, .neighbors = options.normalNeighbors, .threads = options.threads});
    described.surface = std::make_unique<const Surface>(name, oriented, options.threads);
    account.add("normals",
                fmt::format("{}: {} of {} points",
                            scales.normalRadius > 0 ? fmt::format("radius {:.4g} m", scales.normalRadius)
                                                    : fmt::format("{} neighbors", options.normalNeighbors),
                            described.surface->size(), filtered.points.size()));
  }
  const auto keypoints =
      findKeypoints(*described.surface, options.keypoints, scales.keypointSpacing, options.threads);
  account.add("keypoints", fmt::format("{}, {:.4g} m: {} of {} points", options.keypoints,
                                       scales.keypointSpacing, keypoints.size(), described.surface->size()));
  described.features = describe(*described.surface, keypoints, options.descriptor, scales.descriptorRadius,
                                options.threads, isMean(options) ? FrameSigns::normal : FrameSigns::majority);
  account.add("descriptors",
              fmt::format("{}, {:.4g} m: {} of {} keypoints", options.descriptor, scales.descriptorRadius,
                          described.features.size(), keypoints.size()));
  return described;
}

/// Several draws of a cloud with noise, one after the other.
PointCloud withDraws(const PointCloud& cloud, double noise, std::size_t draws) {
  constexpr std::uint64_t seed = 7;
  PointCloud all;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    const PointCloud one = withGaussianNoise(cloud, noise, seed + draw);
    all.points.insert(all.points.end(), one.points.begin(), one.points.end());
    all.normals.insert(all.normals.end(), one.normals.begin(), one.normals.end());
  }
  all.width = all.points.size();
  all.height = 1;
  return all;
}

}  // namespace

PreparedModel::PreparedModel(std::string name, PointCloud raw, PointCloud filtered,
                             RecognitionOptions options, std::vector<StageReport> stages)
    : name_(std::move(name)),
      cloud_(std::move(filtered)),
      options_(std::move(options)),
      extent_(extentOf(cloud_.points)),
      center_(meanOf(cloud_.points)),
      stages_(std::move(stages)) {
  if (!isMean(options_)) return;
  StageAccount account(&stages_);
  raw_ = std::move(raw);
  const Neighbors neighbors(raw_.points, options_.threads);
  noise_ = estimateNoise(neighbors, options_.threads);
  const double spacing = spacingOf(neighbors);
  orientation_ = {!RangeImage(raw_.points, spacing).known(), center_};
  account.add("model", fmt::format("{}; noise {:.4g} m, points {:.4g} m apart",
                                   orientation_.outwards ? "shows several sides" : "seen from the origin",
                                   noise_, spacing));
}

std::shared_ptr<const PreparedModel::Described> PreparedModel::describedFor(
    const RecognitionScales& scene) const {
  constexpr std::size_t manyKept = 8;
  RecognitionScales scales = scene;
  if (!isMean(options_)) scales.unit = scales.noise = scales.spacing = 0;  // which then play no part
  const std::lock_guard lock(mutex_);
  for (const auto& [known, described] : described_)
    if (known == scales) return described;
  auto fresh = std::make_shared<Described>();
  DenseModel& tried = fresh->tried;
  if (isMean(options_)) {
    // The model as the scene's noise would show it, so that averages are like with like. Several draws, for
    // the features are to be those of the noise, not of one draw of it.
    constexpr std::size_t manyDraws = 3;
    constexpr double hidden = 0.5;  // units, up to which noise is averaged away
    const double added = scales.noise > hidden * scales.unit && scales.noise > noise_
                             ? std::sqrt(scales.noise * scales.noise - noise_ * noise_)
                             : 0;
    const std::size_t draws = added > 0 ? manyDraws : 1;
    const std::vector<cv::Point3f> seeds =
        cloud_.points == raw_.points ? std::vector<cv::Point3f>() : cloud_.points;
    static_cast<DescribedSurface&>(*fresh) =
        describedSurface(name_, withDraws(raw_, added, draws), seeds, cloud_, 1 / static_cast<double>(draws),
                         orientation_, options_, scales);
    tried.few = spreadPointsBy(*fresh->surface, 9 * scales.unit);
    tried.many = spreadPointsBy(*fresh->surface, 4.5 * scales.unit);
    tried.closed = orientation_.outwards;
    balanceNormals(tried.few);
    balanceNormals(tried.many);
  } else {
    constexpr std::size_t fewPoints = 300, manyPoints = 1000;
    static_cast<DescribedSurface&>(*fresh) =
        describedSurface(name_, cloud_, {}, cloud_, 1, orientation_, options_, scales);
    tried.few = spreadPoints(*fresh->surface, fewPoints);
    tried.many = spreadPoints(*fresh->surface, manyPoints);
  }
  tried.center = center_;
  if (described_.size() >= manyKept) described_.erase(described_.begin());
  described_.emplace_back(scales, fresh);
  return fresh;
}

PreparedScene::PreparedScene(std::string name, PointCloud raw, PointCloud filtered,
                             RecognitionOptions options, std::vector<StageReport> stages)
    : name_(std::move(name)),
      raw_(std::move(raw)),
      filtered_(filtered.points == raw_.points ? PointCloud() : std::move(filtered)),
      options_(std::move(options)),
      stages_(std::move(stages)) {
  StageAccount account(&stages_);
  if (!options_.viewpoint && raw_.viewpoint)
    options_.viewpoint = cv::Point3d(raw_.viewpoint->x, raw_.viewpoint->y, raw_.viewpoint->z);
  if (options_.viewpoint) {
    const cv::Affine3d toView = viewFrom(*options_.viewpoint, raw_);
    fromView_ = toView.inv();
    raw_ = transformed(std::move(raw_), toView);
    filtered_ = transformed(std::move(filtered_), toView);
  }
  const Neighbors neighbors(raw_.points, options_.threads);
  resolution_ = resolutionOf(neighbors);
  spacing_ = spacingOf(neighbors);
  noise_ = estimateNoise(neighbors, options_.threads);
  if (!(spacing_ > 0))
    throw Error(fmt::format("{}: its {} points lie all at one place, or nearly; they show no surface", name_,
                            raw_.points.size()));
  scales_ = estancia::scalesFor(options_, resolution_, spacing_, noise_);
  account.add("noise",
              fmt::format("{:.4g} m across the surface, points {:.4g} m apart, {:.4g} m from the nearest",
                          noise_, spacing_, resolution_));
  described_ = describe(scales_);
  stages_.insert(stages_.end(), described_->stages.begin(), described_->stages.end());
}

RecognitionScales PreparedScene::scalesFor(const PreparedModel& model) const {
  return isMean(options_) ? estancia::scalesFor(options_, resolution_, spacing_, noise_, model.extent())
                          : scales_;
}

std::shared_ptr<const PreparedScene::Described> PreparedScene::describedFor(
    const RecognitionScales& scales) const {
  constexpr std::size_t manyKept = 4;
  if (scales == scales_) return described_;
  const std::lock_guard lock(mutex_);
  for (const auto& known : others_)
    if (known->scales == scales) return known;
  if (others_.size() >= manyKept) others_.erase(others_.begin());
  others_.push_back(describe(scales));
  return others_.back();
}

std::shared_ptr<const PreparedScene::Described> PreparedScene::describe(
    const RecognitionScales& scales) const {
  auto fresh = std::make_shared<Described>();
  const PointCloud& left = filtered_.points.empty() ? raw_ : filtered_;
  RecognitionScales own = scales;
  if (options_.sceneKeypointSpacing > 0 && options_.keypoints == "uniform")
    own.keypointSpacing = options_.sceneKeypointSpacing;
  static_cast<DescribedSurface&>(*fresh) =
      describedSurface(name_, raw_, filtered_.points, left, 1, {}, options_, own);
  fresh->scales = scales;
  StageAccount account(&fresh->stages);
  const Surface& surface = *fresh->surface;
  const bool evidence = options_.verification == "evidence";
  if (evidence || options_.grouping == "local-frames")
    fresh->field = NearestField(surface.points(), scales.tolerance, 4 * scales.tolerance, options_.threads);
  if (!evidence) {
    OrientedPoints spread = spreadPointsBy(surface, scales.tolerance);
    PointCloud thin;
    thin.points = std::move(spread.points);
    thin.normals = std::move(spread.normals);
    fresh->coarse = std::make_unique<const Surface>(name_, thin, options_.threads);
    if (options_.verification == "global")
      fresh->parts = smoothPartsOf(*fresh->coarse, 2 * scales.tolerance, options_.threads);
  }
  // The averaged surface has a wider spacing, and no noise.
  fresh->view = isMean(options_) ? RangeImage(surface.points(), 1.8 * scales.unit)
                                 : RangeImage(raw_.points, resolution_);
  account.add("view", fresh->view.known() ? "seen from the origin" : "no view from the origin");
  return fresh;
}

}  // namespace estancia
