#include "estancia/recognition/recognizer.hpp"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/search.hpp"

namespace estancia {
namespace {

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
  StageAccount account(&stages);
  PointCloud left = filterCloud(cloud, options, progress);
  account.add("filter",
              fmt::format("{}: {} of {} points", options.method, left.points.size(), cloud.points.size()));
  return finitePoints(name, left);
}

void requireSameUnits(const PreparedModel& model, const PreparedScene& scene) {
  constexpr double largest = 5, smallest = 0.001;  // an object of the scene's size is odd enough
  constexpr double fewest = 5;                     // points across that show an object
  const double ratio = model.extent() / scene.surface().extent();
  if (ratio > largest || ratio < smallest || model.extent() < fewest * scene.resolution())
    throw Error(
        fmt::format("{} measures {:.4g} m and {} {:.4g} m, its points {:.4g} m apart: are they in different "
                    "units? Scale one of them{}",
                    model.name(), model.extent(), scene.name(), scene.surface().extent(), scene.resolution(),
                    ratio > 300 && ratio < 3000 ? ", millimeters by 0.001" : ""));
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

}  // namespace

Recognizer::Recognizer(RecognitionOptions options) : options_(std::move(options)) {
  options_.check();
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

std::vector<Detection> Recognizer::find(const PreparedModel& model, const PreparedScene& scene,
                                        std::vector<StageReport>* stages) const {
  requireSameUnits(model, scene);
  StageAccount account(stages);
  const RecognitionScales scales = scene.scalesFor(model);
  const auto there = scene.describedFor(scales);
  if (stages && scales != scene.scales())
    for (const StageReport& s : there->stages) stages->push_back({"scene's " + s.stage, s.detail, s.seconds});
  const auto described = model.describedFor(scales);
  if (stages) stages->insert(stages->end(), described->stages.begin(), described->stages.end());
  account.add("model", fmt::format("{} keypoints", described->features.size()));
  requireShape(model.name(), described->tried.few);
  return detectionsOf(options_, model, *described, scene, *there, account);
}

}  // namespace estancia
