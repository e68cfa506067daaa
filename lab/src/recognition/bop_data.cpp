// SPDX-License-Identifier: Apache-2.0
#include "recognition/bop_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/core.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/files.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

constexpr double meters = 0.001;  // lengths are in millimeters there
constexpr int maxId = 999'999;    // six digits

/// Calls use(content); what is wrong with the content is reported with the file.
template <class Use>
void withJson(const fs::path& file, const Use& use) {
  constexpr std::size_t maxBytes = std::size_t{1} << 28U;
  const std::string bytes = io::readBytes(file, maxBytes);
  const auto refuse = [&](ErrorCode code, const std::string& what) {
    fail(code, "{}: {}; unpack the data set anew, or see its format (BOP)", io::printable(file), what);
  };
  try {
    use(Json::parse(bytes));
  } catch (const Json::exception& problem) {
    refuse(ErrorCode::malformedFile, io::jsonProblem(problem));
  } catch (const Error& problem) {
    refuse(problem.code(), problem.what());
  }
}

int idOf(const Json& json, const char* key) {
  const Json& value = json.at(key);
  if (!value.is_number_integer() || value < 0 || value > maxId)
    fail(ErrorCode::malformedFile, "\"{}\" is no number of 0 … {}", key, maxId);
  return value.get<int>();
}

template <std::size_t count>
std::array<double, count> numbersOf(const Json& list) {
  if (!list.is_array() || list.size() != count)
    fail(ErrorCode::malformedFile, "a list has not {} numbers", count);
  return list.get<std::array<double, count>>();
}

double positiveOf(const Json& json, const char* key) {
  const double value = json.at(key).get<double>();
  if (!(value > 0 && value < 1e6)) fail(ErrorCode::malformedFile, "\"{}\" is {}", key, value);
  return value;
}

std::vector<cv::Affine3d> symmetriesOf(const Json& info) {
  constexpr std::size_t max = 100'000;
  std::vector<cv::Affine3d> discrete{cv::Affine3d::Identity()}, turns, all;
  for (const Json& one : info.value("symmetries_discrete", Json::array())) {
    const auto m = numbersOf<16>(one);
    discrete.push_back(bopPose(std::array{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]},
                               std::array{m[3], m[7], m[11]}));
  }
  for (const Json& one : info.value("symmetries_continuous", Json::array())) {
    const auto axis = numbersOf<3>(one.at("axis")), offset = numbersOf<3>(one.at("offset"));
    const auto more = bopTurns(cv::Vec3d(axis.data()), cv::Vec3d(offset.data()) * meters);
    turns.insert(turns.end(), more.begin(), more.end());
    if (turns.size() * discrete.size() > max) break;
  }
  if (turns.empty()) return discrete;
  if (turns.size() * discrete.size() > max)
    fail(ErrorCode::tooLarge, "an object has more than {} symmetries", max);
  for (const cv::Affine3d& one : discrete)
    for (const cv::Affine3d& turn : turns) all.push_back(turn * one);
  return all;
}

PlyMesh readModel(const fs::path& file) {
  PlyMesh mesh = readPlyMesh(file);
  if (mesh.triangles.empty())
    fail(ErrorCode::malformedFile, "{}: a model without faces; give a mesh", io::printable(file));
  for (cv::Point3f& p : mesh.vertices.points) {
    p *= static_cast<float>(meters);
    if (!(cv::norm(p) < 1000))
      fail(ErrorCode::malformedFile, "{}: a vertex is not finite, or kilometers away; units are millimeters",
           io::printable(file));
  }
  return mesh;
}

/// The targets by image, in the order of scenes and images.
std::vector<BopImage> readTargets(const fs::path& file) {
  constexpr int maxInstances = 1000;
  std::map<std::pair<int, int>, std::map<int, std::size_t>> targets;
  withJson(file, [&](const Json& list) {
    for (const Json& one : list) {
      const int count = idOf(one, "inst_count"), object = idOf(one, "obj_id");
      if (count < 1 || count > maxInstances)
        fail(ErrorCode::malformedFile, "\"inst_count\" is {}, not 1 … {}", count, maxInstances);
      const std::pair key(idOf(one, "scene_id"), idOf(one, "im_id"));
      if (!targets[key].emplace(object, count).second)
        fail(ErrorCode::malformedFile, "scene {}, image {}: object {} is there twice", key.first, key.second,
             object);
    }
    if (targets.empty()) fail(ErrorCode::malformedFile, "there are no targets");
  });
  std::vector<BopImage> images;
  for (const auto& [key, objects] : targets) {
    images.push_back({key.first, key.second});
    for (const auto& [object, count] : objects) images.back().targets.push_back({object, count});
  }
  return images;
}

void readCamera(const Json& json, BopImage& image) {
  const auto k = numbersOf<9>(json.at("cam_K"));
  if (!(k[0] > 0 && k[4] > 0))
    fail(ErrorCode::malformedFile, "image {}: \"cam_K\" has no focal lengths", image.image);
  image.camera = {0, 0, k[0], k[4], k[2], k[5]};
  image.unitsPerMeter = 1 / meters / positiveOf(json, "depth_scale");
}

void readTruth(const Json& poses, BopImage& image) {
  for (const Json& one : poses)
    image.truth.push_back(
        {idOf(one, "obj_id"), bopPose(numbersOf<9>(one.at("cam_R_m2c")), numbersOf<3>(one.at("cam_t_m2c")))});
}

void readVisibility(const Json& infos, BopImage& image) {
  if (infos.size() != image.truth.size())
    fail(ErrorCode::mismatch, "image {}: {} entries, but {} poses in scene_gt.json", image.image,
         infos.size(), image.truth.size());
  for (std::size_t i = 0; i < infos.size(); ++i)
    image.truth[i].visible = infos.at(i).at("visib_fract").get<double>();
}

/// Fills in the images of one scene.
void readScene(const fs::path& folder, std::span<BopImage> images) {
  std::error_code problem;
  for (BopImage& image : images) {
    image.depth = folder / "depth" / fmt::format("{:06}.png", image.image);
    if (fs::path tif = image.depth;
        !fs::exists(image.depth, problem) && fs::exists(tif.replace_extension(".tif"), problem))
      image.depth = tif;
  }
  using Fill = std::pair<const char*, void (*)(const Json&, BopImage&)>;
  for (const auto& [file, fill] : {Fill{"scene_camera.json", readCamera},
                                   {"scene_gt.json", readTruth},
                                   {"scene_gt_info.json", readVisibility}})
    withJson(folder / file, [&](const Json& json) {
      for (BopImage& image : images) fill(json.at(std::to_string(image.image)), image);
    });
}

}  // namespace

cv::Affine3d bopPose(std::span<const double> rotation, std::span<const double> translation) {
  constexpr double rounding = 0.01;
  const cv::Matx33d r(rotation.data());
  const cv::Vec3d t(translation.data());
  // Not of what is NaN, either.
  if (!(cv::norm(r * r.t() - cv::Matx33d::eye(), cv::NORM_INF) < rounding && cv::determinant(r) > 0))
    fail(ErrorCode::malformedFile, "9 numbers are no rotation, row by row");
  if (!(cv::norm(t) < 1e9)) fail(ErrorCode::malformedFile, "a translation is not finite");
  return {r, t * meters};
}

std::vector<cv::Affine3d> bopTurns(const cv::Vec3d& axis, const cv::Vec3d& offset) {
  constexpr double step = 0.01;  // share of the diameter: max_sym_disc_step of BOP's programs
  const double length = cv::norm(axis);
  if (!(length > 1e-9 && cv::norm(offset) < 1e9))
    fail(ErrorCode::malformedFile, "the axis of a symmetry has no direction, or is infinitely far");
  const int count = static_cast<int>(std::ceil(std::numbers::pi / step));
  std::vector<cv::Affine3d> turns;
  for (int i = 0; i < count; ++i) {
    const cv::Affine3d turn(axis * (2 * std::numbers::pi * i / count / length));
    turns.push_back(turn.translate(offset - turn * offset));
  }
  return turns;
}

BopData readBop(const BopSource& source) {
  BopData data;
  std::vector<BopImage> all = readTargets(source.path / source.targets);
  const std::size_t count = source.images > 0 ? std::min(source.images, all.size()) : all.size();
  for (std::size_t i = 0; i < count; ++i) data.images.push_back(std::move(all[i * all.size() / count]));
  for (auto first = data.images.begin(); first != data.images.end();) {
    const auto last =
        std::find_if(first, data.images.end(), [&](const auto& i) { return i.scene != first->scene; });
    readScene(source.path / source.split / fmt::format("{:06}", first->scene), {first, last});
    first = last;
  }
  const fs::path evaluated = source.path / "models_eval";
  std::error_code problem;
  const fs::path models = fs::exists(evaluated, problem) ? evaluated : source.path / "models";
  withJson(models / "models_info.json", [&](const Json& json) {
    for (const BopImage& image : data.images)
      for (const BopTarget& target : image.targets) {
        if (data.objects.contains(target.object)) continue;
        const Json& info = json.at(std::to_string(target.object));
        BopObject& object = data.objects[target.object];
        object.diameter = positiveOf(info, "diameter") * meters;
        object.symmetries = symmetriesOf(info);
      }
  });
  for (auto& [id, object] : data.objects) object.mesh = readModel(models / fmt::format("obj_{:06}.ply", id));
  return data;
}

DepthFrame readBopDepth(const BopImage& image) {
  DepthFrame frame{fmt::format("scene {}, image {}", image.scene, image.image),
                   io::readDepth(image.depth, image.unitsPerMeter), image.camera};
  frame.camera.width = frame.depth.cols;
  frame.camera.height = frame.depth.rows;
  return frame;
}

PointCloud sampleMesh(const PlyMesh& mesh, double step) {
  constexpr double min = 1000, max = 200'000;
  const auto& points = mesh.vertices.points;
  std::vector<double> until;  // area of the triangles up to this one
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    until.push_back(area += cv::norm((points[b] - points[a]).cross(points[c] - points[a])) / 2);
  const auto count = static_cast<std::size_t>(std::clamp(area / (step * step), min, max));
  PointCloud cloud;
  std::size_t at = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double wanted = (static_cast<double>(i) + 0.5) / static_cast<double>(count) * area;
    while (at + 1 < until.size() && until[at] < wanted) ++at;
    const auto& [a, b, c] = mesh.triangles[at];
    // The sequence R2 (Roberts 2018), even in the unit square, folded into the triangle.
    double u = std::fmod(0.7548776662466927 * static_cast<double>(i), 1),
           v = std::fmod(0.5698402909980532 * static_cast<double>(i), 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    cloud.points.push_back(points[a] + (points[b] - points[a]) * static_cast<float>(u) +
                           (points[c] - points[a]) * static_cast<float>(v));
  }
  cloud.width = count;
  cloud.height = 1;
  return cloud;
}

}  // namespace estancia::experiments
