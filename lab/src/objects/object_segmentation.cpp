// SPDX-License-Identifier: Apache-2.0
#include "objects/object_segmentation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/processes/work_queue.hpp"
#include "objects/made_up_scenes.hpp"
#include "objects/object_scenes.hpp"
#include "objects/object_segmentation_findings.hpp"
#include "runner/config_lists.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {
namespace {

// version of the code below: scenes of another one are segmented anew
constexpr int objectSegmentationVersion = 3;
constexpr int largest = 20'000;  // pixels of a side, and of a focal length

ClusterOptions clustering(const ObjectSegmentationOptions& options) {
  ClusterOptions clusters;
  clusters.seed = options.seed;
  clusters.threads = 1;  // scenes are taken side by side
  return clusters;
}

/// One scene, read or made up.
struct Scene {
  cv::Mat image, depth, truth;
  CameraIntrinsics camera;
  Scene(const ObjectScene& scene, const ObjectSegmentationOptions& options) : camera(options.camera) {
    if (options.madeUp == 0) {
      image = readImage(scene.image);
      depth = io::readDepth(scene.depth, options.depthScale);
      truth = whereDepthIs(readObjectMask(scene.mask), depth);
      return;
    }
    MadeUpScene made = madeUpScene(std::stoull(scene.name));
    image = made.image;
    depth = made.depth;
    truth = whereDepthIs(made.truth, depth);
    camera = made.camera;
  }
};

std::vector<ObjectScene> listScenes(const ObjectSegmentationOptions& options,
                                    std::vector<std::string>& problems) {
  if (options.madeUp == 0) return readObjectScenes(options.scenes, &problems);
  std::vector<ObjectScene> scenes;
  for (std::uint64_t seed = options.firstScene; scenes.size() < options.madeUp; ++seed)
    scenes.push_back({std::to_string(seed), madeUpCategory(seed), {}, {}, {}});
  return scenes;
}

/// Digest of everything that a scene's results depend on.
std::string digestOf(const ObjectScene& file, const ObjectSegmentationOptions& options) {
  const CameraIntrinsics& camera = options.camera;
  const std::string files =
      options.madeUp > 0 ? "made up " + file.name
                         : sha256OfFile(file.image) + sha256OfFile(file.depth) + sha256OfFile(file.mask);
  return sha256(fmt::format("{} {} {} {} {} {} {} {} {} {}", objectSegmentationVersion, files, camera.width,
                            camera.height, camera.fx, camera.fy, camera.cx, camera.cy, options.depthScale,
                            options.seed));
}

std::vector<PixelSet> pixelsOf(Clusters clusters) {
  std::vector<PixelSet> pixels;
  for (Cluster& cluster : clusters.clusters) pixels.push_back(std::move(cluster.points));
  return pixels;
}

void add(CellResults& results, const std::string& prefix, const SegmentationScore& score) {
  const auto objects = static_cast<double>(score.objects);
  for (const auto& [measure, count] :
       {std::pair{"found", score.found}, {"over", score.over}, {"under", score.under}})
    results.push_back({prefix + measure, "", static_cast<double>(count)});
  results.push_back({prefix + "mean_iou", "", score.objects == 0 ? 0 : score.iou / objects});
}

const std::pair<const char*, PrecisionRecall SegmentationMeasures::*> measureKinds[] = {
    {"overlap_", &SegmentationMeasures::overlap}, {"boundary_", &SegmentationMeasures::boundary}};

void add(CellResults& results, const std::string& prefix, const SegmentationMeasures& measures) {
  for (const auto& [name, kind] : measureKinds) {
    const PrecisionRecall& values = measures.*kind;
    results.push_back({prefix + name + "precision", "", values.precision});
    results.push_back({prefix + name + "recall", "", values.recall});
    results.push_back({prefix + name + "f", "", values.f});
  }
  results.push_back({prefix + "f_above_75", "", measures.atThreeQuarters});
}

CellResults segment(const ObjectScene& file, const ObjectSegmentationOptions& options) {
  const Scene scene(file, options);
  ClusterOptions how = clustering(options);
  const auto clusters = pixelsOf(findClusters(scene.depth, scene.camera, how, scene.image));
  how.method = ClusterOptions::Method::euclidean;
  const auto euclidean = pixelsOf(findClusters(scene.depth, scene.camera, how));
  const PointCloud cloud = backProject(scene.depth, scene.camera);
  std::size_t told = 0, taken = 0;
  const auto objects = objectsOf(scene.truth);
  for (std::size_t o = 0; o < objects.size(); ++o) {
    told += isFlat(posterOf(cloud, objects[o], options.seed + o));
    taken += isFlat(pointsOf(cloud, objects[o]));
  }
  const auto count = static_cast<double>(objects.size());
  CellResults results{{"objects", "", count}};
  add(results, "", scoreClusters(scene.truth, clusters));
  add(results, "", measureClusters(scene.truth, clusters));
  results.push_back({"posters", "", count});
  results.push_back({"posters_told", "", static_cast<double>(told)});
  results.push_back({"taken_for_flat", "", static_cast<double>(taken)});
  add(results, "euclidean_", scoreClusters(scene.truth, euclidean));
  add(results, "euclidean_", measureClusters(scene.truth, euclidean));
  return results;
}

SegmentedScene read(const ObjectScene& scene, const CellResults& results) {
  const auto get = [&](const std::string& measure) {
    const auto found = valueOf(results, measure);
    if (!found || !(*found >= 0 && *found < 1e9))
      throw Error(ErrorCode::corruptFile,
                  fmt::format("the cell of {} has no {}; remove the folder `cells`", scene.name, measure));
    return *found;
  };
  const auto count = [&](const std::string& measure) { return static_cast<std::size_t>(get(measure)); };
  const auto score = [&](const std::string& prefix) {
    return SegmentationScore{count("objects"), count(prefix + "found"), count(prefix + "over"),
                             count(prefix + "under"), get(prefix + "mean_iou") * get("objects")};
  };
  const auto measures = [&](const std::string& prefix) {
    SegmentationMeasures all;
    for (const auto& [name, kind] : measureKinds)
      all.*kind = {get(prefix + name + "precision"), get(prefix + name + "recall"), get(prefix + name + "f")};
    all.atThreeQuarters = get(prefix + "f_above_75");
    return all;
  };
  SegmentedScene read{scene.name,          scene.category, score(""),
                      score("euclidean_"), measures(""),   measures("euclidean_")};
  read.postersTold = count("posters_told");
  read.takenForFlat = count("taken_for_flat");
  return read;
}

Images show(const std::vector<ObjectScene>& files, const std::vector<SegmentedScene>& scenes,
            const std::vector<std::size_t>& chosen, const ObjectSegmentationOptions& options,
            const std::string& title) {
  Images images{title, "The image, its objects, and the clusters that were found.", {}, true};
  for (const std::size_t i : chosen) {
    const Scene scene(files[i], options);
    const SegmentationScore& score = scenes[i].ours;
    images.images.push_back(
        {segmentationImage(
             scene.image, scene.truth,
             pixelsOf(findClusters(scene.depth, scene.camera, clustering(options), scene.image))),
         fmt::format("{}{}: {} of {} objects, mean IoU {:.2f}", files[i].name,
                     files[i].category.empty() ? "" : " (" + files[i].category + ")", score.found,
                     score.objects,
                     score.iou / static_cast<double>(std::max<std::size_t>(score.objects, 1)))});
  }
  return images;
}

OptionGroup declare(ObjectSegmentationOptions& options) {
  OptionGroup group("object-segmentation", "Objects found in images.");
  group.add("depth-scale", &options.depthScale, "Units a meter of the depth images").range(1e-6, 1e9);
  group.add("seed", &options.seed, "Seed of the planes and of the posters' noise").range(0, 1e9);
  group.add("images", &options.images, "Best and worst scenes that are shown").range(0, 20);
  return group;
}

CameraIntrinsics readCamera(ConfigFile& config, const toml::table& table) {
  CameraIntrinsics camera;
  const auto size = [&config](int& to) {
    return [&config, &to](auto& n) { to = static_cast<int>(config.integer(n, 1, largest)); };
  };
  const auto number = [&config](double& to, double least) {
    return [&config, &to, least](auto& n) { to = config.number(n, least, largest); };
  };
  config.read(table, {{"width", true, "of its images [pixels]", size(camera.width)},
                      {"height", true, "of its images [pixels]", size(camera.height)},
                      {"fx", true, "focal length [pixels]", number(camera.fx, 1)},
                      {"fy", true, "focal length [pixels]", number(camera.fy, 1)},
                      {"cx", true, "principal point [pixels]", number(camera.cx, -largest)},
                      {"cy", true, "principal point [pixels]", number(camera.cy, -largest)}});
  if (camera.cx < 0 || camera.cx > camera.width || camera.cy < 0 || camera.cy > camera.height)
    config.fail(table,
                fmt::format("the principal point ({}, {}) is not in images of {} × {} pixels; give the "
                            "size of the images that cx and cy are for",
                            camera.cx, camera.cy, camera.width, camera.height));
  return camera;
}

}  // namespace

ObjectSegmentationOptions readObjectSegmentation(ConfigFile& config) {
  ObjectSegmentationOptions options;
  const toml::table *camera = nullptr, *made = nullptr;
  config.read(together(
      keysOf(config, declare(options)),
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"scenes", false, "the folder with the list of scenes",
        [&](auto& n) { options.scenes = config.anywhere(n); }},
       {"camera", false, "the camera that took them", [&](auto& n) { camera = &config.subtable(n); }},
       {"made_up", false, "scenes that are rendered, instead",
        [&](auto& n) { made = &config.subtable(n); }}}));
  if (made != nullptr && (camera != nullptr || !options.scenes.empty()))
    config.fail(*made, "`made_up` has its own scenes and camera; leave out those of files");
  if (made != nullptr) {
    config.read(*made,
                {{"count", true, "how many",
                  [&](auto& n) { options.madeUp = static_cast<std::size_t>(config.integer(n, 1, 10'000)); }},
                 {"first", false, "the seed of the first one", [&](auto& n) {
                    options.firstScene = static_cast<std::uint64_t>(config.integer(n, 0, 1'000'000));
                  }}});
    return options;
  }
  if (options.scenes.empty() || camera == nullptr)
    throw Error(ErrorCode::malformedFile, "give `scenes`, a folder, and its `[camera]`; or `[made_up]`");
  options.camera = readCamera(config, *camera);
  return options;
}

GridColumns objectSegmentationColumns() {
  GridColumns columns{{"scene"}, "", {"objects"}};
  const auto add = [&](const std::string& prefix) {
    for (const char* score :
         {"found", "over", "under", "mean_iou", "overlap_precision", "overlap_recall", "overlap_f",
          "boundary_precision", "boundary_recall", "boundary_f", "f_above_75"})
      columns.measures.push_back(prefix + score);
  };
  add("");
  for (const char* flat : {"posters", "posters_told", "taken_for_flat"}) columns.measures.emplace_back(flat);
  add("euclidean_");
  return columns;
}

Findings segmentObjects(const ObjectSegmentationOptions& options, Grid& grid, const ExperimentRun& run,
                        Progress& progress) {
  refuseModels(run, "segmentation");
  std::vector<std::string> problems;
  const std::vector<ObjectScene> files = listScenes(options, problems);
  std::vector<Cell> cells;
  cells.reserve(files.size());
  for (const ObjectScene& file : files) cells.push_back({{file.name}, digestOf(file, options)});
  const auto found = grid.run(
      cells, [&](std::size_t i) { return segment(files[i], options); }, progress, "segmenting");
  std::vector<SegmentedScene> scenes;
  for (std::size_t i = 0; i < files.size(); ++i) scenes.push_back(read(files[i], found[i]));
  if (std::all_of(scenes.begin(), scenes.end(), [](const auto& scene) { return scene.ours.objects == 0; }))
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: no scene has an object with depth", options.scenes.string()));

  Findings findings = findingsOf(scenes);
  if (run.distribution == nullptr || run.distribution->isFirst()) {
    std::vector<std::size_t> order = bestFirst(scenes);
    const auto count = static_cast<std::ptrdiff_t>(std::min(options.images, order.size() / 2));
    if (count > 0) {
      findings.sections.emplace_back(
          show(files, scenes, {order.end() - count, order.end()}, options, "The worst scenes"));
      findings.sections.emplace_back(
          show(files, scenes, {order.begin(), order.begin() + count}, options, "The best scenes"));
    }
  }
  const std::string from = options.madeUp > 0 ? "made up" : options.scenes.string();
  findings.facts = {
      {"Scenes", fmt::format("{}: {}", from, files.size())},
      {"Clusters", "of the library's defaults"},
      {"Euclidean clusters", "voxels of 5 mm, 15 mm apart, 20 mm from planes, 100 to 25,000 of them"}};
  findings.notes = problems;
  return findings;
}

}  // namespace estancia::experiments
