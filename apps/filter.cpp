// estancia filter: a cloud with fewer, better points; or with noise, normals, in another format.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "common.hpp"
#include "estancia/cloud/filter.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/noise.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/error.hpp"
#include "estancia/io/cloud_file.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/image_writer.hpp"
#include "estancia/report/cloud_image.hpp"

namespace estancia::apps {
namespace {

struct Arguments {
  std::string input, output, graph, image;
  CloudFileOptions file;
  FilterOptions filter;
  double noise = 0, normalRadius = 0;
  std::uint64_t seed = 1;
  bool normals = false, overwrite = false, json = false;
};

/// What was measured on the way.
struct Account {
  std::size_t all = 0, finite = 0;
  double resolution = 0, noise = 0;  ///< [m] of the cloud that was filtered
  double seconds = 0;                ///< of the filter alone
};

const char* nameOf(GngStop stop) {
  switch (stop) {
    case GngStop::neurons:
      return "neurons";
    case GngStop::quantizationError:
      return "error";
    case GngStop::seconds:
      return "deadline";
    case GngStop::points:
      return "points";
    case GngStop::stalled:
      return "stalled";
  }
  return "";
}

void tell(const Arguments& arguments, const FilteredCloud& filtered, const Account& account) {
  const NeuralGas& gas = filtered.gas;
  const bool neural = arguments.filter.method == "gng";
  const auto written = static_cast<std::size_t>(
      std::count_if(filtered.cloud.points.begin(), filtered.cloud.points.end(), isFinite));
  const std::size_t holes =  // PLY has none
      io::hasSuffix(arguments.output, {".ply"}) ? 0 : filtered.cloud.points.size() - written;
  if (arguments.json) {
    nlohmann::ordered_json json{{"cloud", arguments.output},
                                {"method", arguments.filter.method},
                                {"points_in", account.all},
                                {"finite", account.finite},
                                {"points_out", written},
                                {"holes", holes},
                                {"resolution", account.resolution},
                                {"noise", account.noise},
                                {"seconds", account.seconds}};
    if (filtered.leaf > 0) json["leaf"] = filtered.leaf;
    if (neural) {
      json["edges"] = gas.edges.size();
      json["signals"] = gas.signals;
      json["quantization_error"] = gas.quantizationError;
      json["stopped_by"] = nameOf(gas.stop);
    }
    print(json);
    return;
  }
  fmt::print("{}: {} of {} points", arguments.output, written, account.all);
  if (account.finite < account.all)
    fmt::print("; {} that are not finite are {}", account.all - account.finite,
               holes > 0 ? "kept as holes" : "left out");
  if (filtered.leaf > 0) fmt::print("; voxels of {:.3g} m", filtered.leaf);
  if (neural)
    fmt::print("; {} edges, {} signals, quantization error {:.3g} m", gas.edges.size(), gas.signals,
               gas.quantizationError);
  fmt::print("; {:.2f} s\n", account.seconds);
  fmt::print("the cloud's resolution is {:.3g} m and its noise {:.3g} m across the surface\n",
             account.resolution, account.noise);
}

/// Options that only some filters use.
constexpr std::pair<const char*, const char*> kOptionsOf[] = {{"--points", "gng or voxel"},
                                                              {"--leaf", "voxel"},
                                                              {"--error", "gng"},
                                                              {"--deadline", "gng"},
                                                              {"--graph", "gng"}};

void requireUsed(const CLI::App& command, const std::string& method) {
  for (const auto& [option, methods] : kOptionsOf)
    if (command.count(option) > 0 && std::string_view(methods).find(method) == std::string_view::npos)
      throw Error(fmt::format("{} needs --method {}; {} has no use for it", option, methods, method));
}

void requireOutputs(const Arguments& arguments) {
  std::vector<std::string> outputs{arguments.output};
  requireCloudFile(arguments.output);
  if (!arguments.graph.empty()) {
    requireCloudFile(arguments.graph, true);
    const auto place = [](const std::string& file) {
      return std::filesystem::weakly_canonical(std::filesystem::absolute(file));
    };
    if (place(arguments.graph) == place(arguments.output))
      throw Error(
          fmt::format("{} cannot hold both the cloud and the graph; give two names", arguments.output));
    outputs.push_back(arguments.graph);
  }
  const std::vector<std::string> inputs{arguments.input, arguments.file.intrinsics, arguments.file.colors};
  requireImage(arguments.image, arguments.overwrite, inputs);
  for (const std::string& output : outputs) {
    requireReplaceable(output, arguments.overwrite, isCloudFile, "point cloud");
    requireNoData(output, inputs);
  }
}

void run(Arguments& arguments) {
  requireOutputs(arguments);
  arguments.filter.gng.seed = arguments.seed;
  PointCloud cloud =
      withGaussianNoise(readCloud(arguments.input, arguments.file), arguments.noise, arguments.seed);
  if (arguments.noise > 0) cloud.normals.clear();  // they were those of the points without it
  const Neighbors around(cloud.points, 0);
  Account account{cloud.points.size(), around.size(), resolutionOf(around), estimateNoise(around), 0};

  const auto progress = makeStderrProgress();
  const auto start = std::chrono::steady_clock::now();
  FilteredCloud filtered = filterWithDetails(cloud, arguments.filter, *progress);
  account.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  if (arguments.normals) {
    NormalOptions options;  // planes that are wide enough to show through the noise
    options.radius = arguments.normalRadius > 0 ? arguments.normalRadius
                                                : std::max(7 * account.resolution, 3 * account.noise);
    if (options.radius == 0) throw Error("normals need points at different places; this cloud has none");
    if (cloud.viewpoint)
      options.viewpoint = cv::Point3d(cloud.viewpoint->x, cloud.viewpoint->y, cloud.viewpoint->z);
    filtered.cloud.normals = estimateNormals(filtered.cloud.points, around, options);
    if (std::none_of(filtered.cloud.normals.begin(), filtered.cloud.normals.end(),
                     [](const cv::Point3f& n) { return std::isfinite(n.x); }))
      throw Error(
          fmt::format("no point has enough others within {:.3g} m for a normal; the points lie {:.3g} m "
                      "apart, so give a --normal-radius of {:.3g} m or more",
                      options.radius, account.resolution, 4 * account.resolution));
  }
  writeCloud(filtered.cloud, arguments.output);
  if (!arguments.graph.empty()) writeCloud(filtered.cloud, arguments.graph, filtered.gas.edges);
  if (!arguments.image.empty()) {
    CloudLayer layer;
    layer.cloud = &filtered.cloud;
    layer.edges = filtered.gas.edges;
    writePng(drawClouds({&layer, 1}), arguments.image);
  }
  tell(arguments, filtered, account);
}

}  // namespace

void addFilterCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("filter", "Thin out a point cloud and take the noise off it");
  command->add_option("IN", arguments->input, "Cloud (.pcd, .ply) or depth image (.png, .tif, .exr, …)")
      ->required();
  command->add_option("OUT", arguments->output, "The filtered cloud, .pcd or .ply")->required();
  FilterOptions& filter = arguments->filter;
  filter.method = "gng";
  std::string methods = "The filter:";
  std::vector<std::string> names;
  for (const auto& [name, explanation] : filterMethods()) {
    methods += fmt::format("\n{} ({})", name, explanation);
    names.push_back(name);
  }
  command->add_option("--method", filter.method, methods)->capture_default_str()->check(CLI::IsMember(names));
  command->add_option("--points", filter.points, "So many points are to be left: neurons, or voxels about")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, std::size_t{100000000}));
  command->add_option("--leaf", filter.leaf, "Edge of a voxel [m]; default: the one that leaves --points")
      ->check(positive())
      ->excludes("--points");
  command
      ->add_option("--error", filter.gng.quantizationError, "Neurons: stop below this quantization error [m]")
      ->check(positive());
  command->add_option("--deadline", filter.gng.seconds, "Neurons: stop after so many seconds")
      ->check(positive());
  command->add_option("--graph", arguments->graph, "Neurons: write their graph, too (.ply with edges)");
  command->add_option("--render", arguments->image,
                      "Draw the filtered cloud, neurons with their graph (PNG)");
  command
      ->add_option(
          "--noise", arguments->noise,
          "First add Gaussian noise of this standard deviation to x, y and z [m]; drops IN's normals")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--seed", arguments->seed, "Of the noise, and of the signals that neurons learn from")
      ->capture_default_str();
  command->add_flag("--normals", arguments->normals,
                    "Write normals, towards the sensor: at the origin, unless IN (PCD) says where");
  command
      ->add_option("--normal-radius", arguments->normalRadius,
                   "Of the points that a normal is fitted to [m]; default: follows resolution and noise")
      ->check(positive())
      ->needs("--normals");
  command->add_flag("--overwrite", arguments->overwrite, "Replace existing clouds and images");
  const auto depth = "Depth images";
  command
      ->add_option("--depth-scale", arguments->file.depthScale,
                   "What a meter is in their numbers; default: 16 bits 1000, 8 bits 25.5, float 1")
      ->check(positive())
      ->group(depth);
  command
      ->add_option(
          "--intrinsics", arguments->file.intrinsics,
          "The camera: file with fx fy cx cy, a 3×3 matrix, or a calibration of ROS or OpenCV; default: "
          "camera-intrinsics.txt, intrinsics.txt or camera.yaml beside the image or above")
      ->group(depth);
  command->add_option("--colors", arguments->file.colors, "Color image of the same view")->group(depth);
  addJsonOption(*command, arguments->json);
  addExamples(
      *command,
      "  estancia filter scene.pcd small.ply --points 10000 --graph graph.ply\n"
      "  estancia filter scene.pcd small.pcd --method voxel --points 10000 --normals\n"
      "  estancia filter scene.pcd noisy.pcd --method none --noise 0.005 --seed 3\n"
      "  estancia filter kitchen/frame-000000.depth.png kitchen.ply --method none --intrinsics camera.txt");
  command->callback([arguments, command] {
    requireUsed(*command, arguments->filter.method);
    run(*arguments);
  });
}

}  // namespace estancia::apps
