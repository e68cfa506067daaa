// estancia recognize: known objects in a cloud, and their poses.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <cmath>

#include "common.hpp"
#include "estancia/figures/cloud_image.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/scene_cloud.hpp"
#include "known_object_arguments.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;

struct RecognizeArguments {
  explicit RecognizeArguments(CLI::App& command) : declared(command) {}
  std::string preset() const { return declared.preset().empty() ? "default" : declared.preset(); }

  KnownObjectArguments objects;
  std::string path, image;
  SceneCloudOptions scene;
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

/// `sensor`: where it is taken to have been, "" where that is known.
void printText(const RecognizeArguments& a, const SearchResult& result, const std::string& sensor) {
  if (a.explain) {
    printStages(a.path, result.scene->stages());
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
        a.path, a.explain ? "" : "; --explain shows what each stage kept",
        !sensor.empty() && result.scene->hasView()  // else the warning has reported it
            ? fmt::format("; if the sensor was not {}, give its position by --viewpoint", sensor)
            : "");
  for (const Detection& detection : result.maybe) printDetection(detection, "maybe ");
}

/// "at its origin": where the sensor is taken to have been.
std::string sensorOf(const RecognitionOptions& options, const PointCloud& cloud) {
  return options.viewpoint ? "at the --viewpoint" : cloud.viewpoint ? "at its VIEWPOINT" : "at its origin";
}

/// What a user should know about the view, logged: [{"code", "message"}].
Json viewWarnings(const RecognizeArguments& a, const SceneCloud& cloud, const RecognitionOptions& options,
                  const PreparedScene& scene) {
  Json warnings = Json::array();
  const auto warn = [&](const char* code, const std::string& message) -> Json& {
    spdlog::warn("{}", message);
    return warnings.emplace_back(Json{{"code", code}, {"message", message}});
  };
  const std::string ignored = "so occlusion and free space are ignored";
  if (cloud.frames.size() > 1 && !scene.hasView())
    warn("no-view", fmt::format("{} frames are several views, {}", cloud.frames.size(), ignored));
  else if (!scene.hasView() && !options.noView)
    warn("no-view", fmt::format("{} is not a view from a sensor {}, {}; {}", a.path,
                                sensorOf(options, cloud.cloud), ignored,
                                options.viewpoint ? "correct --viewpoint, or leave it out"
                                                  : "give the position of the sensor by --viewpoint X,Y,Z"));
  if (!scene.hasView()) return warnings;
  if (scene.viewKnown() == PreparedScene::ViewKnown::assumed)
    warn("assumed-view",
         fmt::format("{} was thinned or has few points, so that the sensor's position does not follow from "
                     "it; the origin is assumed: if it was elsewhere, give its position by --viewpoint X,Y,Z",
                     a.path));
  if (const auto& at = scene.estimatedViewpoint())
    warn("estimated-view",
         fmt::format(
             "{} is not a view from its origin; the sensor seems to have been at {:.2f},{:.2f},{:.2f}: "
             "if it was elsewhere, give its position by --viewpoint X,Y,Z",
             a.path, at->x, at->y, at->z))["viewpoint"] = {at->x, at->y, at->z};
  return warnings;
}

/// Adds what the poses are relative to, and the frames of a drive.
void addReference(Json& json, const SceneCloud& scene) {
  json["poses_in"] = scene.reference;
  for (const Frame& frame : scene.frames) {
    Json& entry = json["frames"].emplace_back(Json{{"name", frame.name}});
    if (frame.pose) entry["pose"] = rigidOf(*frame.pose).matrix.val;
  }
}

void run(const RecognizeArguments& a) {
  const std::vector<ModelFile> files = a.objects.files();
  std::vector<std::string> inputs{a.path};
  for (const ModelFile& file : files) inputs.push_back(file.cloud.string());
  requireImage(a.image, a.overwrite, inputs);
  RecognitionOptions options = optionsOf(a);
  validate(options);
  const SceneCloud scene = readSceneCloud(a.path, a.scene);
  for (const std::string& warning : scene.warnings) spdlog::warn("{}", warning);
  if (scene.frames.size() > 1 && !options.viewpoint) options.noView = true;
  const auto progress = makeStderrProgress();
  const SearchResult result = searchScene(Recognizer(options), a.path, scene.cloud, files, *progress);

  for (const auto& [name, reason] : result.failed) spdlog::warn("{} is left out: {}", name, reason);
  const Json warnings = viewWarnings(a, scene, options, *result.scene);
  if (!a.image.empty()) drawInstances(a.image, scene.cloud, result);
  if (a.json) {
    Json json = toJson(result);
    addReference(json, scene);
    if (!warnings.empty()) json["warnings"] = warnings;
    if (a.explain) json["stages"] = stagesJson(result);
    print(json);
  } else {
    const bool askForView = !options.viewpoint && scene.reference == "cloud";
    printText(a, result, askForView ? sensorOf(options, scene.cloud) : "");
    if (scene.reference != "cloud" && result.detections.size() + result.maybe.size() > 0)
      fmt::print("Positions are in the frame of the {}\n", scene.reference);
  }
  if (result.detections.empty()) throw NoAnswer{};
}

}  // namespace

void addRecognizeCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("recognize", "Find known objects and their poses in a point cloud");
  auto a = std::make_shared<RecognizeArguments>(*command);
  command
      ->add_option(
          "SCENE", a->path,
          "What to search: a point cloud (PCD, PLY), a depth image (PNG, TIFF, …) with its camera, or "
          "frames of a drive with depth (folder, bag, data set)")
      ->required();
  command
      ->add_option(
          "--frame", a->scene.frames,
          "Frame of the drive SCENE, by its number from 0 or its name; several, separated by commas, "
          "are joined by their poses, which are those of the map then")
      ->type_name("N,...")
      ->delimiter(',')
      ->allow_extra_args(false);
  a->objects.addTo(*command, "Cloud of an object: FILE or NAME=FILE; may be given repeatedly")->required();
  addUnitOption(*command, "--scene-unit", a->scene.file.unit, "Unit of the coordinates in the cloud SCENE");
  a->declared.addPreset(RecognitionOptions::presets(), [&options = a->options](const std::string& name) {
    options = RecognitionOptions::preset(name);
  });
  a->declared.add(declare(a->options),
                  {"scene-filter.method=filter", "scene-filter.points", "keypoints", "descriptor", "grouping",
                   "verification", "accept", "false-alarm-rate", "normal-radius", "keypoint-spacing",
                   "descriptor-radius", "viewpoint"});
  a->declared.add(declare(a->scene.sequence), {"type", "poses", "depth-scale", "intrinsics",
                                               "image-topic=image", "depth-topic=depth", "odom-topic=odom"});
  OptionGroup file = declare(a->scene.file);  // the others are those of the sequence
  std::erase_if(file.options(), [](const Option& option) { return option.name() != "colors"; });
  a->declared.add(std::move(file), {"colors"});
  command->add_option("--render", a->image, "Draw the scene with the detected objects (PNG)");
  addOverwriteOption(*command, a->overwrite);
  command->add_flag("--explain", a->explain, "Show what each stage received and kept");
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia recognize table.pcd --object mug.pcd\n"
              "  estancia recognize table.pcd --object mug.pcd --object box=box_front.ply --explain\n"
              "  estancia recognize table.pcd --object millimeters.ply --object-unit mm\n"
              "  estancia recognize depth.png --intrinsics camera.txt --object mug.pcd\n"
              "  estancia recognize ~/kitchen --frame 120,125,130 --object mug.pcd --json\n"
              "  estancia recognize noisy.pcd --object mug.pcd --filter gng --render found.png --json");
  command->callback([a] { run(*a); });
}

}  // namespace estancia::apps
