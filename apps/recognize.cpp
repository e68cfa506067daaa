// estancia recognize: known objects in a cloud, and their poses.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <cmath>

#include "common.hpp"
#include "estancia/figures/cloud_image.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/recognition/object_search.hpp"
#include "estancia/recognition/prepared.hpp"

namespace estancia::apps {
namespace {

struct RecognizeArguments {
  explicit RecognizeArguments(CLI::App& command) : declared(command) {}
  std::string preset() const { return declared.preset().empty() ? "default" : declared.preset(); }

  std::vector<std::string> objects;
  std::string scene, image;
  RecognitionOptions options;
  bool overwrite = false, explain = false, json = false;
  DeclaredOptions declared;
};

/// A radius replaces the number of neighbors that the preset fits normals to.
RecognitionOptions optionsOf(const RecognizeArguments& a) {
  RecognitionOptions options = a.options;
  if (options.normalRadius > 0 &&
      options.normalNeighbors == RecognitionOptions::preset(a.preset()).normalNeighbors)
    options.normalNeighbors = 0;
  return options;
}

void printStages(const std::string& name, const std::vector<StageReport>& stages) {
  fmt::print("{}\n", name);
  for (const StageReport& s : stages) fmt::print("  {:<14} {}  ({:.2f} s)\n", s.stage, s.detail, s.seconds);
}

/// Colors that distinguish instances, by Wong, Nature Methods 8 (2011), BGR.
const std::array<cv::Vec3b, 6> instanceColors{
    {{0, 159, 230}, {115, 158, 0}, {178, 114, 0}, {0, 94, 213}, {167, 121, 204}, {233, 180, 86}}};

void drawInstances(const std::string& image, const PointCloud& scene, const SearchResult& result) {
  std::vector<CloudLayer> layers(1);
  layers[0].cloud = &scene;
  for (std::size_t i = 0; i < result.detections.size(); ++i)
    layers.push_back({&result.model(result.detections[i].model).cloud,
                      result.detections[i].pose,
                      instanceColors[i % instanceColors.size()],
                      {}});
  writePng(drawClouds(layers), image);
}

/// `unsaid`: the sensor's position was not given.
void printText(const RecognizeArguments& a, const SearchResult& result, bool unsaid,
               const std::string& sensor) {
  if (a.explain) {
    printStages(a.scene, result.scene->stages());
    for (const SearchedModel& model : result.models) printStages(model.name, model.stages);
  }
  const auto printDetection = [](const Detection& detection, const char* maybe) {
    const cv::Point3d at = detection.pose * detection.center;
    const std::string sureness = std::isnan(detection.falseAlarmRate)
                                     ? fmt::format("confidence {:.2f}", detection.confidence)
                                     : fmt::format("false alarm rate {:.1g}", detection.falseAlarmRate);
    fmt::print("{}{:<20} at ({:.3f}, {:.3f}, {:.3f})  {:>6} inliers  {}\n", maybe, detection.model, at.x,
               at.y, at.z, detection.inliers, sureness);
  };
  for (const Detection& detection : result.detections) printDetection(detection, "");
  if (result.detections.empty())
    fmt::print(
        "{} in {}{}{}\n",
        result.models.size() == 1 ? result.models.front().name + " was not found" : "No object was found",
        a.scene, a.explain ? "" : "; --explain shows what each stage kept",
        unsaid && result.scene->hasView()  // else the warning has reported it
            ? fmt::format("; if the sensor was not {}, give its position by --viewpoint", sensor)
            : "");
  for (const Detection& detection : result.maybe) printDetection(detection, "maybe ");
}

void run(const RecognizeArguments& a) {
  const std::vector<ModelFile> files = modelFilesOf(a.objects);
  std::vector<std::string> inputs{a.scene};
  for (const ModelFile& file : files) inputs.push_back(file.cloud.string());
  requireImage(a.image, a.overwrite, inputs);
  const RecognitionOptions options = optionsOf(a);
  const Recognizer recognizer(options);
  const PointCloud cloud = readCloud(a.scene);
  const auto progress = makeStderrProgress();
  const SearchResult result = searchScene(recognizer, a.scene, cloud, files, *progress);

  for (const auto& [name, reason] : result.failed) spdlog::warn("{} is left out: {}", name, reason);
  const bool unsaid = !options.viewpoint;
  const std::string sensor = !unsaid           ? "at the --viewpoint"
                             : cloud.viewpoint ? "at its VIEWPOINT"
                                               : "at its origin";
  auto warnings = nlohmann::ordered_json::array();
  if (!result.scene->hasView()) {
    const std::string noView = fmt::format(
        "{} is not a view from a sensor {}, so occlusion and free space are ignored; {}", a.scene, sensor,
        unsaid ? "give the position of the sensor by --viewpoint X,Y,Z"
               : "correct --viewpoint, or leave it out");
    spdlog::warn("{}", noView);
    warnings.push_back({{"code", "no-view"}, {"message", noView}});
  }
  if (result.scene->hasView() && result.scene->viewKnown() == PreparedScene::ViewKnown::assumed) {
    const std::string assumed = fmt::format(
        "{} was thinned or has few points, so that the sensor's position does not follow from it; the origin "
        "is "
        "assumed: if it was elsewhere, give its position by --viewpoint X,Y,Z",
        a.scene);
    spdlog::warn("{}", assumed);
    warnings.push_back({{"code", "assumed-view"}, {"message", assumed}});
  }
  if (const auto& at = result.scene->estimatedViewpoint(); at && result.scene->hasView()) {
    const std::string estimated = fmt::format(
        "{} is not a view from its origin; the sensor seems to have been at {:.2f},{:.2f},{:.2f}: if it was "
        "elsewhere, give its position by --viewpoint X,Y,Z",
        a.scene, at->x, at->y, at->z);
    spdlog::warn("{}", estimated);
    warnings.push_back(
        {{"code", "estimated-view"}, {"message", estimated}, {"viewpoint", {at->x, at->y, at->z}}});
  }
  if (!a.image.empty()) drawInstances(a.image, cloud, result);
  if (a.json) {
    nlohmann::ordered_json json = toJson(result);
    if (!warnings.empty()) json["warnings"] = warnings;
    if (a.explain) json["stages"] = stagesJson(result);
    print(json);
  } else {
    printText(a, result, unsaid, sensor);
  }
  if (result.detections.empty()) throw NoAnswer{};
}

}  // namespace

void addRecognizeCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("recognize", "Find known objects and their poses in a point cloud");
  auto a = std::make_shared<RecognizeArguments>(*command);
  command->add_option("SCENE", a->scene, "The point cloud to search (PCD, PLY)")->required();
  command
      ->add_option("--object", a->objects, "Cloud of an object: FILE or NAME=FILE; may be given repeatedly")
      ->type_name("[NAME=]FILE")
      ->allow_extra_args(false)
      ->required();
  a->declared.addPreset(RecognitionOptions::presets(), [&options = a->options](const std::string& name) {
    options = RecognitionOptions::preset(name);
  });
  a->declared.add(declare(a->options),
                  {"scene-filter.method=filter", "scene-filter.points", "keypoints", "descriptor", "grouping",
                   "verification", "accept", "false-alarm-rate", "normal-radius", "keypoint-spacing",
                   "descriptor-radius", "viewpoint"});
  command->add_option("--render", a->image, "Draw the scene with the detected objects (PNG)");
  addOverwriteOption(*command, a->overwrite);
  command->add_flag("--explain", a->explain, "Show what each stage received and kept");
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia recognize table.pcd --object mug.pcd\n"
              "  estancia recognize table.pcd --object mug.pcd --object box=box_front.ply --explain\n"
              "  estancia recognize noisy.pcd --object mug.pcd --filter gng --render found.png --json");
  command->callback([a] { run(*a); });
}

}  // namespace estancia::apps
