// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/prepared.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "estancia/cloud/mls_surface.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/cloud/viewpoint.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/recognition/surface.hpp"
#include "estancia/recognition/verify.hpp"

namespace estancia {
namespace {

constexpr std::size_t maxKept = 8;  // descriptions of one model, and of one scene, at different scales

bool isMean(const RecognitionOptions& options) {
  return options.surface == "mean";
}

/// Scales that do not fit the cloud are probably in other units.
void requireScales(const std::string& name, const RecognitionScales& scales, double extent,
                   double resolution) {
  const auto require = [&](double length, const char* what, double min, double advised) {
    if (length >= min && length <= extent / 2) return;
    fail(ErrorCode::mismatch,
         "{}: a {} of {:.4g} m does not fit a cloud of {:.4g} m with points {:.4g} m apart; "
         "if it is in millimeters, give --object-unit or --scene-unit mm, else about {:.4g} m",
         name, what, length, extent, resolution, std::min(advised, extent / 3));
  };
  if (scales.normalRadius > 0) require(scales.normalRadius, "normal radius", resolution, 8 * resolution);
  require(scales.keypointSpacing, "keypoint spacing", resolution / 10, 5 * resolution);
  require(scales.consistency, "consistency", resolution / 10, 5 * resolution);
  require(scales.tolerance, "tolerance", resolution / 10, 3 * resolution);
}

/// The cloud in another frame: points, normals, viewpoint.
PointCloud transformed(PointCloud cloud, const cv::Affine3d& transform) {
  const cv::Matx33d turn = transform.rotation();
  for (cv::Point3f& p : cloud.points) p = transform * cv::Point3d(p);
  for (cv::Point3f& n : cloud.normals) n = turn * cv::Point3d(n);
  if (cloud.viewpoint) cloud.viewpoint = poseOf(transform * rigidOf(*cloud.viewpoint));
  return cloud;
}

/// The sensor at the origin: none, as its optical frame looks along z, unless it looked elsewhere.
std::optional<cv::Point3d> originOf(const PointCloud& cloud) {
  const bool along = std::ranges::all_of(cloud.points, [](const cv::Point3f& p) {
    return p.z > 0 && std::max(std::abs(p.x), std::abs(p.y)) <= 2 * p.z;  // 63° to either side
  });
  return along ? std::nullopt : std::optional(cv::Point3d());
}

/// A sensor's place, unless it is that of the origin within its error.
std::optional<cv::Point3d> awayFromOrigin(const cv::Point3d& sensor, const PointCloud& cloud) {
  constexpr double error = 0.05;  // error as a share of the distance to the points
  const bool away = cv::norm(sensor) > error * cv::norm(meanOf(cloud.points) - sensor);
  return away ? std::optional(sensor) : originOf(cloud);
}

/// Where the sensor of a cloud stood, as far as that follows from its points.
struct SensorPlace {
  std::optional<cv::Point3d> at = {};  ///< none: at the origin, looking along z
  PreparedScene::ViewKnown known = PreparedScene::ViewKnown::yes;
};

/// Whether a filter has made the points as dense far away as near the sensor: at points drawn from them, the
/// distances to their neighbors hardly differ. Measured: standard deviations of the logarithm of .05 to .25
/// behind voxel grids, .29 to .8 of what a sensor gave, or a random part of it.
bool isThinned(const std::vector<cv::Point3f>& points, const std::vector<cv::Point3f>& drawn, int threads) {
  constexpr double narrow = 0.275;
  const Neighbors neighbors(points, threads);
  std::vector<Neighbor> buffer;
  std::vector<double> logarithms;
  for (const cv::Point3f& p : drawn)
    if (const float squared = neighbors.nearest(p, 9, buffer).back().squared; squared > 0)
      logarithms.push_back(std::log(static_cast<double>(squared)) / 2);
  std::ranges::sort(logarithms);
  const std::size_t sixth = logarithms.size() / 6;  // what lies within a standard deviation is two thirds
  return logarithms.empty() || logarithms[logarithms.size() - 1 - sixth] - logarithms[sixth] < 2 * narrow;
}

/// By how evenly the points lie as seen from the sensor, if they are those that it measured: at the origin,
/// where they lie evenly from there; elsewhere, where they do and hide fewest of each other; else nowhere.
/// The origin is assumed for clouds that were thinned, and for few points.
SensorPlace sensorByDensity(const PointCloud& cloud, int threads) {
  constexpr std::size_t enough = 8000;
  const std::vector<cv::Point3f> drawn = drawnFrom(cloud.points, enough);
  if (unevenness(drawn, {}) <= even) return {originOf(cloud)};
  if (drawn.size() < enough || isThinned(cloud.points, drawn, threads))
    return {{}, PreparedScene::ViewKnown::assumed};
  const double spacing = spacingOf(Neighbors(drawn, threads));
  SensorPlace place{{}, PreparedScene::ViewKnown::no};
  double least = 0.05;
  for (const cv::Point3d& at : findViewpoints(cloud.points, threads)) {
    PointCloud seen;
    seen.points = drawn;
    const RangeImage view(transformed(std::move(seen), viewFrom(at, cloud.points)).points, spacing);
    if (!view.known() || view.hiddenShare() > least) continue;
    least = view.hiddenShare();
    place = {at};
  }
  return place;
}

/// A cloud on its way to a described surface.
struct Input {
  const std::string& name;
  const PointCloud& raw;                  ///< what a mean surface averages
  const std::vector<cv::Point3f>& seeds;  ///< seeds of a mean surface; empty: voxels of `raw`
  const PointCloud& filtered;             ///< the points of a filtered surface
  double perPoint = 1;                    ///< weight of a point of `raw`
  Orientation orientation = {};
};

/// Moving least squares over the raw points.
std::unique_ptr<const Surface> meanSurface(const Input& in, const RecognitionOptions& options,
                                           const RecognitionScales& scales, StageLog& log) {
  if (options.normalRadius > 0 || options.keypointSpacing > 0 || options.tolerance > 0)
    requireScales(in.name, scales, extentOf(in.raw.points), scales.spacing);
  MlsOptions smoothing = smoothingFor(scales);
  smoothing.perPoint = in.perPoint;
  smoothing.away = in.orientation.outwards;
  smoothing.viewpoint = in.orientation.outwards ? in.orientation.center : in.orientation.sensor;
  smoothing.threads = options.threads;
  const PointCloud smooth = projectMls(in.seeds, in.raw, smoothing);
  if (smooth.points.empty())
    fail(ErrorCode::insufficientData,
         "{}: its {} points show no surface within {:.4g} m of each other: they are too few, too far apart, "
         "or "
         "on a line; give a denser cloud, or a larger normal radius",
         in.name, static_cast<std::size_t>(static_cast<double>(in.raw.points.size()) * in.perPoint),
         smoothing.radius);
  auto surface = std::make_unique<const Surface>(in.name, smooth, options.threads);
  log.add("mean surface",
          fmt::format("of {} points over {:.4g} m, normals {:.4g} m: {} points {:.4g} m apart",
                      in.raw.points.size(), smoothing.width, smoothing.radius, surface->size(),
                      smoothing.spacing));
  return surface;
}

/// The filtered points with plane normals.
std::unique_ptr<const Surface> filteredSurface(const Input& in, const RecognitionOptions& options,
                                               const RecognitionScales& scales, StageLog& log) {
  PointCloud oriented = in.filtered;
  const Neighbors neighbors(oriented.points, options.threads);
  if (scales.normalRadius > 0)
    requireRadius(in.name, oriented.points, neighbors, scales.normalRadius, "normal radius");
  requireScales(in.name, scales, extentOf(oriented.points), resolutionOf(neighbors));
  oriented.normals = estimateNormals(
      in.filtered.points, neighbors,
      {.radius = scales.normalRadius, .neighbors = options.normalNeighbors, .threads = options.threads});
  auto surface = std::make_unique<const Surface>(in.name, oriented, options.threads);
  log.add("normals",
          fmt::format("{}: {} of {} points",
                      scales.normalRadius > 0 ? fmt::format("radius {:.4g} m", scales.normalRadius)
                                              : fmt::format("{} neighbors", options.normalNeighbors),
                      surface->size(), in.filtered.points.size()));
  return surface;
}

std::unique_ptr<const Surface> surfaceOf(const Input& in, const RecognitionOptions& options,
                                         const RecognitionScales& scales, StageLog& log) {
  return isMean(options) ? meanSurface(in, options, scales, log) : filteredSurface(in, options, scales, log);
}

/// The surface's keypoints and their descriptors; of both sides of the surface where its outside is not
/// known.
void describeSurface(DescribedSurface& described, bool bothSides, const RecognitionOptions& options,
                     const RecognitionScales& scales, StageLog& log,
                     std::size_t most = std::numeric_limits<std::size_t>::max()) {
  const Surface& surface = *described.surface;
  const FrameSigns signs = isMean(options) ? FrameSigns::normal : FrameSigns::majority;
  const auto keypoints =
      partOf(findKeypoints(surface, options.keypoints, scales.keypointSpacing, options.threads), most);
  log.add("keypoints", fmt::format("{}, {:.4g} m: {} of {} points", options.keypoints, scales.keypointSpacing,
                                   keypoints.size(), surface.size()));
  const auto featuresOf = [&](const Surface& of) {
    return describe(of, keypoints, options.descriptor, scales.descriptorRadius, options.threads, signs);
  };
  described.features = featuresOf(surface);
  const std::size_t count = described.features.size();
  if (bothSides) {
    std::vector<cv::Point3f> other = surface.normals();
    for (cv::Point3f& n : other) n = -n;
    described.features.append(featuresOf(surface.withNormals(std::move(other))));
  }
  log.add("descriptors",
          fmt::format("{}, {:.4g} m: {} of {} keypoints{}", options.descriptor, scales.descriptorRadius,
                      count, keypoints.size(), bothSides ? ", of either side" : ""));
}

/// A view of one side has nothing behind its surface, as seen from its sensor: mostly the origin.
Orientation orientationOf(const std::vector<cv::Point3f>& points, double spacing, const cv::Point3d& center,
                          double extent, int threads) {
  constexpr double afar = 3;  // extents
  Orientation orientation{.outwards = false, .center = center};
  if (RangeImage(points, spacing).known()) return orientation;
  const auto direction = directionOfView(points, spacing, threads);
  orientation.outwards = !direction;
  if (direction) orientation.sensor = center + *direction * (afar * extent);
  return orientation;
}

/// Several draws of a cloud with noise, concatenated.
PointCloud withDraws(const PointCloud& cloud, double noise, std::size_t draws) {
  PointCloud all;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    const PointCloud one = withGaussianNoise(cloud, noise, 7 + draw);
    all.points.insert(all.points.end(), one.points.begin(), one.points.end());
    all.normals.insert(all.normals.end(), one.normals.begin(), one.normals.end());
    all.colors.insert(all.colors.end(), one.colors.begin(), one.colors.end());
  }
  all.width = all.points.size();
  all.height = 1;
  return all;
}

}  // namespace

void StageLog::add(const std::string& stage, std::string detail) {
  const auto now = std::chrono::steady_clock::now();
  if (stages_ != nullptr)
    stages_->push_back({stage, std::move(detail), std::chrono::duration<double>(now - last_).count()});
  last_ = now;
}

void StageLog::append(const std::vector<StageReport>& stages, const std::string& prefix) {
  if (stages_ == nullptr) return;
  for (const StageReport& s : stages) stages_->push_back({prefix + s.stage, s.detail, s.seconds});
}

PreparedModel::PreparedModel(std::string name, PointCloud raw, PointCloud filtered,
                             RecognitionOptions options, std::vector<StageReport> stages)
    : name_(std::move(name)),
      cloud_(std::move(filtered)),
      options_(std::move(options)),
      extent_(extentOf(cloud_.points)),
      center_(meanOf(cloud_.points)),
      stages_(std::move(stages)) {
  if (!isMean(options_)) return;
  StageLog log(&stages_);
  raw_ = std::move(raw);
  const Neighbors neighbors(raw_.points, options_.threads);
  noise_ = estimateNoise(neighbors, options_.threads);
  const double spacing = spacingOf(neighbors);
  orientation_ = orientationOf(raw_.points, spacing, center_, extent_, options_.threads);
  log.add("model",
          fmt::format("{}; noise {:.4g} m, points {:.4g} m apart",
                      orientation_.outwards                  ? "shows several sides"
                      : orientation_.sensor == cv::Point3d() ? "seen from the origin"
                                                             : "shows one side, not towards the origin",
                      noise_, spacing));
}

std::shared_ptr<const PreparedModel::Described> PreparedModel::describedFor(
    const RecognitionScales& scene) const {
  RecognitionScales scales = scene;
  if (!isMean(options_))
    scales.unit = scales.noise = scales.spacing = 0;  // filtered surfaces do not use them
  const std::lock_guard lock(mutex_);
  for (const auto& [known, described] : described_)
    if (known == scales) return described;
  auto fresh = describe(scales);
  if (described_.size() >= maxKept) described_.erase(described_.begin());
  described_.emplace_back(scales, fresh);
  return fresh;
}

std::shared_ptr<const PreparedModel::Described> PreparedModel::describe(
    const RecognitionScales& scales) const {
  auto fresh = std::make_shared<Described>();
  StageLog log(&fresh->stages);
  DenseModel& dense = fresh->dense;
  dense.center = center_;
  constexpr std::size_t coarsePoints = 300, finePoints = 1000;
  if (!isMean(options_)) {
    fresh->surface =
        surfaceOf({.name = name_, .raw = cloud_, .seeds = {}, .filtered = cloud_}, options_, scales, log);
    describeSurface(*fresh, false, options_, scales, log);
    dense.coarse = spreadPoints(*fresh->surface, coarsePoints);
    dense.fine = spreadPoints(*fresh->surface, finePoints);
    return fresh;
  }
  // The model with the noise of the scene, so that averages are comparable. Several draws, because features
  // should be typical of the noise, not of one draw of it.
  constexpr std::size_t noisyDraws = 3;
  constexpr double hidden = 0.5;  // units, up to which noise is averaged away
  const double added = scales.noise > hidden * scales.unit && scales.noise > noise_
                           ? std::sqrt(scales.noise * scales.noise - noise_ * noise_)
                           : 0;
  const std::size_t draws = added > 0 ? noisyDraws : 1;
  const std::vector<cv::Point3f> seeds =
      cloud_.points == raw_.points ? std::vector<cv::Point3f>() : cloud_.points;
  fresh->surface = surfaceOf({.name = name_,
                              .raw = withDraws(raw_, added, draws),
                              .seeds = seeds,
                              .filtered = cloud_,
                              .perPoint = 1 / static_cast<double>(draws),
                              .orientation = orientation_},
                             options_, scales, log);
  const bool given = options_.keypointSpacing > 0;  // else a large model takes no longer than a small one
  describeSurface(*fresh, false, options_, scales, log, given ? fresh->surface->size() : finePoints);
  dense.coarse = spreadPointsBy(*fresh->surface, 9 * scales.unit, coarsePoints);
  dense.area = findKeypoints(*fresh->surface, "uniform", 4.5 * scales.unit).size();
  dense.fine = spreadPointsBy(*fresh->surface, 4.5 * scales.unit, finePoints);
  dense.closed = orientation_.outwards;
  balanceNormals(dense.coarse);
  balanceNormals(dense.fine);
  if (options_.verification == "evidence") addExtent(*fresh, scales);
  return fresh;
}

void PreparedModel::addExtent(Described& fresh, const RecognitionScales& scales) const {
  fresh.field =
      NearestField(fresh.surface->points(), scales.tolerance, 4 * scales.tolerance, options_.threads);
  ModelExtent& extent = fresh.dense.extent;
  extent.surface = fresh.surface.get();
  extent.field = &fresh.field;
  extent.reach = static_cast<float>(2 * scales.tolerance);
  if (orientation_.outwards) return;
  const cv::Affine3d toView = viewFrom(orientation_.sensor, raw_.points);
  fresh.view = RangeImage(transformed(raw_, toView).points, scales.unit);
  extent.view = &fresh.view;
  extent.toView = cv::Affine3f(toView);
}

PreparedScene::PreparedScene(std::string name, PointCloud raw, PointCloud filtered,
                             RecognitionOptions options, std::vector<StageReport> stages,
                             const std::optional<cv::Point3d>& sensor)
    : name_(std::move(name)),
      raw_(std::move(raw)),
      filtered_(filtered.points == raw_.points ? PointCloud() : std::move(filtered)),
      options_(std::move(options)),
      stages_(std::move(stages)) {
  StageLog log(&stages_);
  if (options_.noView) {
    options_.viewpoint.reset();
    viewKnown_ = ViewKnown::no;
  } else if (!options_.viewpoint && raw_.viewpoint) {
    options_.viewpoint = cv::Point3d(raw_.viewpoint->x, raw_.viewpoint->y, raw_.viewpoint->z);
  }
  if (!options_.viewpoint && !options_.noView && isMean(options_)) {
    if (sensor) {
      options_.viewpoint = awayFromOrigin(*sensor, raw_);
    } else {
      const SensorPlace place = sensorByDensity(raw_, options_.threads);
      options_.viewpoint = place.at;
      viewKnown_ = place.known;
    }
    if (options_.viewpoint != cv::Point3d()) estimatedViewpoint_ = options_.viewpoint;
  }
  if (options_.viewpoint) {
    const cv::Affine3d toView = viewFrom(*options_.viewpoint, raw_.points);
    fromView_ = toView.inv();
    raw_ = transformed(std::move(raw_), toView);
    filtered_ = transformed(std::move(filtered_), toView);
  }
  const Neighbors neighbors(raw_.points, options_.threads);
  resolution_ = resolutionOf(neighbors);
  spacing_ = spacingOf(neighbors);
  noise_ = estimateNoise(neighbors, options_.threads);
  if (!(spacing_ > 0))
    fail(ErrorCode::invalidInput, "{}: its {} points nearly coincide; give a cloud of a surface", name_,
         raw_.points.size());
  scales_ = estancia::scalesFor(options_, resolution_, spacing_, noise_);
  log.add("noise",
          fmt::format("{:.4g} m across the surface, points {:.4g} m apart, {:.4g} m from the nearest", noise_,
                      spacing_, resolution_));
  described_ = describe(scales_);
  stages_.insert(stages_.end(), described_->stages.begin(), described_->stages.end());
}

RecognitionScales PreparedScene::scalesFor(const PreparedModel& model) const {
  return isMean(options_) ? estancia::scalesFor(options_, resolution_, spacing_, noise_, model.extent())
                          : scales_;
}

std::shared_ptr<const PreparedScene::Described> PreparedScene::describedFor(
    const RecognitionScales& scales) const {
  if (scales == scales_) return described_;
  const std::lock_guard lock(mutex_);
  for (const auto& known : others_)
    if (known->scales == scales) return known;
  if (others_.size() >= maxKept) others_.erase(others_.begin());
  others_.push_back(describe(scales));
  return others_.back();
}

std::shared_ptr<const PreparedScene::Described> PreparedScene::describe(
    const RecognitionScales& scales) const {
  auto fresh = std::make_shared<Described>();
  const PointCloud& filtered = filtered_.points.empty() ? raw_ : filtered_;
  RecognitionScales own = scales;
  if (options_.sceneKeypointSpacing > 0 && options_.keypoints == "uniform")
    own.keypointSpacing = options_.sceneKeypointSpacing;
  fresh->scales = scales;
  StageLog log(&fresh->stages);
  fresh->surface = surfaceOf({.name = name_, .raw = raw_, .seeds = filtered_.points, .filtered = filtered},
                             options_, own, log);
  // The mean surface has a wider spacing, and no noise.
  if (viewKnown_ != ViewKnown::no)
    fresh->view = isMean(options_) ? RangeImage(fresh->surface->points(), 1.8 * scales.unit)
                                   : RangeImage(raw_.points, resolution_);
  const bool seen = fresh->view.known();
  const char* from = options_.noView                                               ? "one sensor"
                     : estimatedViewpoint_                                         ? "its estimated viewpoint"
                     : options_.viewpoint.value_or(cv::Point3d()) != cv::Point3d() ? "its viewpoint"
                                                                                   : "the origin";
  log.add("view", fmt::format("{} {}", seen ? "seen from" : "no view from", from));
  if (!seen && isMean(options_)) {
    std::vector<cv::Point3f> normals = fresh->surface->normals();
    orientConsistently(fresh->surface->points(), fresh->surface->neighbors(), normals);
    fresh->surface = std::make_unique<const Surface>(fresh->surface->withNormals(std::move(normals)));
  }
  describeSurface(*fresh, !seen && isMean(options_), options_, own, log);
  const Surface& surface = *fresh->surface;
  const bool evidence = options_.verification == "evidence";
  if (evidence || options_.grouping == "local-frames")
    fresh->field = NearestField(surface.points(), scales.tolerance, 4 * scales.tolerance, options_.threads);
  if (evidence) {
    if (seen) fresh->measured = RangeImage(raw_.points, spacing_ / 2);  // cells of 1.25 pixels
    fresh->outline = Outline(surface, fresh->field, fresh->view,
                             {.step = 1.3 * scales.normalRadius,  // within that radius edges are rounded
                              .tolerance = scales.tolerance,
                              .spacing = smoothingFor(scales).spacing},
                             options_.threads);
  }
  if (scales.color > 0) fresh->gradients = colorGradients(surface, scales.normalRadius, options_.threads);
  if (!evidence) {
    OrientedPoints spread = spreadPointsBy(surface, scales.tolerance);
    PointCloud thin;
    thin.points = std::move(spread.points);
    thin.normals = std::move(spread.normals);
    fresh->coarse = std::make_unique<const Surface>(name_, thin, options_.threads);
    if (options_.verification == "global")
      fresh->parts = smoothPartsOf(*fresh->coarse, 2 * scales.tolerance, options_.threads);
  }
  return fresh;
}

}  // namespace estancia
