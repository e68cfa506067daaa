// estancia recognize: known objects in a cloud, and their poses.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/io/cloud_file.hpp"
#include "estancia/io/image_writer.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "estancia/report/cloud_image.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::vector<std::string> models;
  std::string scene, preset = "default", image;
  // What the user says goes before what the preset says.
  std::optional<std::string> filter, keypoints, descriptor, grouping, verification;
  std::optional<std::size_t> points;
  std::optional<double> normalRadius, keypointSpacing, descriptorRadius;
  std::vector<double> viewpoint;
  int threads = 0;
  bool overwrite = false, explain = false, json = false;
};

template <class Value>
void take(const std::optional<Value>& given, Value& option) {
  if (given) option = *given;
}

RecognitionOptions optionsOf(const Arguments& a) {
  RecognitionOptions options = RecognitionOptions::preset(a.preset);
  take(a.filter, options.sceneFilter.method);
  take(a.points, options.sceneFilter.points);
  take(a.keypoints, options.keypoints);
  take(a.descriptor, options.descriptor);
  take(a.grouping, options.grouping);
  take(a.verification, options.verification);
  take(a.normalRadius, options.normalRadius);
  if (a.normalRadius) options.normalNeighbors = 0;
  take(a.keypointSpacing, options.keypointSpacing);
  take(a.descriptorRadius, options.descriptorRadius);
  if (a.viewpoint.size() == 3)
    options.viewpoint = cv::Point3d(a.viewpoint[0], a.viewpoint[1], a.viewpoint[2]);
  options.threads = a.threads;
  return options;
}

struct NamedFile {
  std::string name;
  fs::path file;
};

/// Of words FILE and NAME=FILE.
std::vector<NamedFile> namedFiles(const std::vector<std::string>& words) {
  std::vector<NamedFile> files;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    const bool named = equals != std::string::npos && equals > 0 && !fs::exists(word);
    const fs::path file = named ? word.substr(equals + 1) : word;
    const std::string name = named ? word.substr(0, equals) : file.stem().string();
    if (std::any_of(files.begin(), files.end(), [&](const NamedFile& f) { return f.name == name; }))
      throw Error(fmt::format("two models are called {}; name them: --model NAME=FILE", name));
    files.push_back({name, file});
  }
  return files;
}

std::array<double, 16> rowMajor(const cv::Affine3d& pose) {
  std::array<double, 16> numbers;
  std::copy_n(pose.matrix.val, 16, numbers.begin());
  return numbers;
}

void tellStages(const std::string& of, const std::vector<StageReport>& stages) {
  fmt::print("{}\n", of);
  for (const StageReport& s : stages) fmt::print("  {:<14} {}  ({:.2f} s)\n", s.stage, s.detail, s.seconds);
}

nlohmann::ordered_json toJson(const std::vector<StageReport>& stages) {
  auto json = nlohmann::ordered_json::array();
  for (const StageReport& s : stages)
    json.push_back({{"stage", s.stage}, {"detail", s.detail}, {"seconds", s.seconds}});
  return json;
}

/// Colors that tell instances apart, by Wong, Nature Methods 8 (2011), BGR.
const std::array<cv::Vec3b, 6> instanceColors{
    {{0, 159, 230}, {115, 158, 0}, {178, 114, 0}, {0, 94, 213}, {167, 121, 204}, {233, 180, 86}}};

void drawInstances(const Arguments& arguments, const PointCloud& scene,
                   const std::map<std::string, PointCloud>& models, const std::vector<Detection>& instances) {
  std::vector<CloudLayer> layers(1);
  layers[0].cloud = &scene;
  for (std::size_t i = 0; i < instances.size(); ++i)
    layers.push_back(
        {&models.at(instances[i].model), instances[i].pose, instanceColors[i % instanceColors.size()], {}});
  writePng(drawClouds(layers), arguments.image);
}

void run(const Arguments& arguments) {
  const std::vector<NamedFile> files = namedFiles(arguments.models);
  std::vector<std::string> inputs{arguments.scene};
  for (const NamedFile& model : files) inputs.push_back(model.file.string());
  requireImage(arguments.image, arguments.overwrite, inputs);
  const Recognizer recognizer(optionsOf(arguments));
  const PointCloud cloud = readCloud(arguments.scene);

  const auto progress = makeStderrProgress();
  const auto scene = recognizer.prepareScene(arguments.scene, cloud, *progress);
  std::vector<Detection> instances;
  nlohmann::ordered_json explained{{"scene", toJson(scene->stages())}};
  if (arguments.explain && !arguments.json) tellStages(arguments.scene, scene->stages());
  std::map<std::string, PointCloud> models;
  auto failed = nlohmann::ordered_json::array();
  for (const auto& [name, file] : files) {
    try {
      PointCloud shape = readCloud(file);
      const auto model = recognizer.prepareModel(name, shape);
      std::vector<StageReport> stages = model->stages();
      for (Detection& found : recognizer.find(*model, *scene, &stages)) instances.push_back(std::move(found));
      explained["models"][name] = toJson(stages);
      if (arguments.explain && !arguments.json) tellStages(name, stages);
      models[name] = std::move(shape);
    } catch (...) {
      const Error failure = frameFailure(name);
      if (files.size() == 1) throw failure;
      spdlog::warn("{} is left out: {}", name, failure.what());
      failed.push_back({{"model", name}, {"reason", failure.what()}});
    }
  }
  if (models.empty()) throw Error(fmt::format("none of the {} models can be looked for", files.size()));
  std::stable_sort(instances.begin(), instances.end(),
                   [](const Detection& a, const Detection& b) { return a.confidence > b.confidence; });

  const auto stood = cloud.viewpoint ? "where its VIEWPOINT says" : "at its origin";
  auto warnings = nlohmann::ordered_json::array();
  if (arguments.viewpoint.empty() && !scene->hasView()) {
    const std::string noView = fmt::format(
        "{} does not look like a view from a sensor {}, so what is hidden, or seen through, does not count; "
        "say where it stood with --viewpoint X Y Z",
        arguments.scene, stood);
    spdlog::warn("{}", noView);
    warnings.push_back({{"code", "no-view"}, {"message", noView}});
  }
  if (!arguments.image.empty()) drawInstances(arguments, cloud, models, instances);
  if (arguments.json) {
    nlohmann::ordered_json json{{"instances", nlohmann::json::array()}};
    for (const Detection& found : instances)
      json["instances"].push_back({{"model", found.model},
                                   {"pose", rowMajor(found.pose)},
                                   {"inliers", found.inliers},
                                   {"confidence", found.confidence}});
    if (!failed.empty()) json["failed"] = failed;
    if (!warnings.empty()) json["warnings"] = warnings;
    if (arguments.explain) json["stages"] = explained;
    print(json);
  } else {
    for (const Detection& found : instances) {
      const cv::Point3d at = found.pose * found.center;
      fmt::print("{:<20} at ({:.3f}, {:.3f}, {:.3f})  {:>6} inliers  confidence {:.2f}\n", found.model, at.x,
                 at.y, at.z, found.inliers, found.confidence);
    }
    if (instances.empty())
      fmt::print("{} in {}{}{}\n",
                 models.size() == 1 ? models.begin()->first + " is not" : "None of the models is",
                 arguments.scene, arguments.explain ? "" : "; --explain tells what each stage kept",
                 arguments.viewpoint.empty() && scene->hasView()  // else the warning said it
                     ? fmt::format("; if the sensor did not stand {}, say where: --viewpoint", stood)
                     : "");
  }
  if (instances.empty()) throw NoAnswer{};
}

}  // namespace

void addRecognizeCommand(CLI::App& app) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("recognize", "Find known objects in a cloud, and how they lie there");
  command->add_option("SCENE", a->scene, "The cloud that is looked through (PCD, PLY)");
  command->add_option("-m,--model", a->models, "An object's cloud: FILE or NAME=FILE; several may be given")
      ->required();
  command->add_option("--preset", a->preset, "default; to compare with: classical, thesis, tight, wide")
      ->capture_default_str();
  command->add_option("--filter", a->filter, "What cleans the scene: none, voxel, gng");
  command->add_option("--points", a->points, "Points that the filter leaves")->check(CLI::PositiveNumber);
  command->add_option("--keypoints", a->keypoints, "uniform, harris3d, iss");
  command->add_option("--descriptor", a->descriptor, "shot, fpfh, spin-image");
  command->add_option("--grouping", a->grouping, "geometric-consistency, hough, local-frames");
  command->add_option("--verification", a->verification, "global, inliers, evidence");
  command->add_option("--normal-radius", a->normalRadius,
                      "Points that a normal is fitted to [m]; 0: by noise");
  command->add_option("--keypoint-spacing", a->keypointSpacing, "Between keypoints [m]; 0: by noise");
  command->add_option("--descriptor-radius", a->descriptorRadius, "What a descriptor sees [m]; 0: by noise");
  command
      ->add_option("--viewpoint", a->viewpoint,
                   "Where the sensor stood, in the frame of the scene [m]; default: where a PCD's VIEWPOINT "
                   "says; else at its origin, looking along z")
      ->expected(3);
  command->add_option("--render", a->image, "Draw the scene with what was found in it (PNG)");
  command->add_flag("--overwrite", a->overwrite, "Replace an existing image");
  command->add_option("--threads", a->threads, "Threads of the work; default: one a usable core")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--explain", a->explain, "Tell what each stage took and kept");
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia recognize --model mug.pcd table.pcd\n"
              "  estancia recognize --model mug.pcd --model box=box_front.ply table.pcd --explain\n"
              "  estancia recognize --model mug.pcd noisy.pcd --filter gng --render found.png --json");
  command->callback([a] {
    if (a->scene.empty() && a->models.size() > 1) {  // --model A B SCENE: the option took all three
      a->scene = a->models.back();
      a->models.pop_back();
    }
    if (a->scene.empty())
      throw Error("SCENE is missing: the cloud that is looked through; see estancia recognize --help");
    run(*a);
  });
}

}  // namespace estancia::apps
