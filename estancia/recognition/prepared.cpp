#include "estancia/recognition/prepared.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/error.hpp"
#include "estancia/recognition/keypoints.hpp"
#include "estancia/recognition/verify.hpp"

namespace estancia {
namespace {

constexpr std::size_t fewPoints = 300, manyPoints = 1000;  // of a model, to try poses with

class Clock {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// What options leave open follows the resolution of the cloud and its noise: at 2 mm without noise and with
/// 10 mm that is 16 and 36 mm for normals, 36 and 61 mm for descriptors.
RecognitionLengths lengthsFor(const RecognitionOptions& options, double resolution, double noise) {
  const auto or_ = [](double given, double automatic) { return given > 0 ? given : automatic; };
  return {or_(options.normalRadius, 8 * resolution + 2 * noise), or_(options.keypointSpacing, 5 * resolution),
          or_(options.descriptorRadius, 18 * resolution + 2.5 * noise),
          or_(options.consistency, 5 * resolution + noise),
          or_(options.tolerance, 3 * resolution + 0.6 * noise)};
}

/// A length that would silently find nothing, or everything, is likely to be in other units.
void requireLengths(const std::string& name, const RecognitionLengths& lengths, double extent,
                    double resolution) {
  const auto require = [&](double length, const char* what, double least, double good) {
    if (length >= least && length <= extent / 2) return;
    throw Error(
        fmt::format("{}: a {} of {:.4g} m does not fit a cloud that measures {:.4g} m and whose points lie "
                    "{:.4g} m apart; is it in other units? About {:.4g} m would do",
                    name, what, length, extent, resolution, good));
  };
  require(lengths.keypointSpacing, "keypoint spacing", resolution / 10, 5 * resolution);
  require(lengths.consistency, "consistency", resolution / 10, 5 * resolution);
  require(lengths.tolerance, "tolerance", resolution / 10, 3 * resolution);
}

}  // namespace

DescribedSurface DescribedSurface::of(const std::string& name, const PointCloud& cloud,
                                      const RecognitionOptions& options, const RecognitionLengths& lengths) {
  DescribedSurface described;
  const Clock all;
  PointCloud oriented = cloud;
  const Neighbours neighbours(cloud.points, options.threads);
  requireRadius(name, cloud.points, neighbours, lengths.normalRadius, "normal radius");
  requireLengths(name, lengths, extentOf(cloud.points), resolutionOf(neighbours));
  oriented.normals =
      estimateNormals(cloud.points, neighbours, {.radius = lengths.normalRadius, .threads = options.threads});
  described.surface = std::make_unique<const Surface>(name, oriented, options.threads);
  described.stages.push_back({"normals",
                              fmt::format("radius {:.4g} m: {} of {} points", lengths.normalRadius,
                                          described.surface->size(), cloud.points.size()),
                              all.seconds()});
  const Clock detecting;
  const auto keypoints =
      findKeypoints(*described.surface, options.keypoints, lengths.keypointSpacing, options.threads);
  described.stages.push_back(
      {"keypoints",
       fmt::format("{}, {:.4g} m: {} of {} points", options.keypoints, lengths.keypointSpacing,
                   keypoints.size(), described.surface->size()),
       detecting.seconds()});
  const Clock describing;
  described.features =
      describe(*described.surface, keypoints, options.descriptor, lengths.descriptorRadius, options.threads);
  described.stages.push_back(
      {"descriptors",
       fmt::format("{}, {:.4g} m: {} of {} keypoints", options.descriptor, lengths.descriptorRadius,
                   described.features.size(), keypoints.size()),
       describing.seconds()});
  return described;
}

PreparedModel::PreparedModel(std::string name, PointCloud filtered, RecognitionOptions options,
                             std::vector<StageReport> stages)
    : name_(std::move(name)),
      cloud_(std::move(filtered)),
      options_(std::move(options)),
      extent_(extentOf(cloud_.points)),
      stages_(std::move(stages)) {}

std::shared_ptr<const PreparedModel::Described> PreparedModel::describedFor(
    const RecognitionLengths& lengths) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [known, described] : described_)
    if (known == lengths) return described;
  auto fresh = std::make_shared<Described>();
  static_cast<DescribedSurface&>(*fresh) = DescribedSurface::of(name_, cloud_, options_, lengths);
  fresh->few = spreadPoints(*fresh->surface, fewPoints);
  fresh->many = spreadPoints(*fresh->surface, manyPoints);
  described_.emplace_back(lengths, fresh);
  return fresh;
}

PreparedScene::PreparedScene(std::string name, PointCloud raw, PointCloud filtered,
                             const RecognitionOptions& options, std::vector<StageReport> stages)
    : name_(std::move(name)), raw_(std::move(raw)), view_({}, 0), stages_(std::move(stages)) {
  const Clock measuring;
  const Neighbours neighbours(raw_.points, options.threads);
  resolution_ = resolutionOf(neighbours);
  if (!(resolution_ > 0))
    throw Error(fmt::format("{}: all of its {} points lie in one place; a cloud of a surface is needed",
                            name_, raw_.points.size()));
  noise_ = estimateNoise(neighbours, options.threads);
  lengths_ = lengthsFor(options, resolution_, noise_);
  stages_.push_back({"noise",
                     fmt::format("{:.4g} m across the surface, points {:.4g} m apart", noise_, resolution_),
                     measuring.seconds()});
  described_ = DescribedSurface::of(name_, filtered, options, lengths_);
  stages_.insert(stages_.end(), described_.stages.begin(), described_.stages.end());

  const Clock thinning;
  PointCloud thin;
  for (const std::uint32_t i : findKeypoints(surface(), "uniform", lengths_.tolerance)) {
    thin.points.push_back(surface().points()[i]);
    thin.normals.push_back(surface().normals()[i]);
  }
  coarse_ = std::make_unique<const Surface>(name_, thin, options.threads);
  if (options.verification == "global")
    parts_ = smoothPartsOf(*coarse_, 2 * lengths_.tolerance, options.threads);
  view_ = RangePicture(raw_.points, resolution_);
  stages_.push_back({"view",
                     fmt::format("{} points to verify with; {}", coarse_->size(),
                                 view_.known() ? "seen from the origin" : "no view from the origin"),
                     thinning.seconds()});
}

}  // namespace estancia
