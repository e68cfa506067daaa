// estancia filter: a cloud with fewer, better points; or with noise, normals, in another format.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "common.hpp"
#include "estancia/cloud/filter.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/figures/cloud_image.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_writer.hpp"

namespace estancia::apps {
namespace {

struct FilterArguments {
  explicit FilterArguments(CLI::App& command) : declared(command) {}
  std::string input, output, graph, image;
  CloudFileOptions file;
  FilterOptions filter{.method = "gng", .gng = {}};
  NormalOptions normal;
  double noise = 0;
  bool normals = false, overwrite = false, json = false;
  DeclaredOptions declared;
};

struct Measured {
  std::size_t all = 0, finite = 0;
  /// Resolution and noise of the filtered cloud [m].
  double resolution = 0, noise = 0;
  /// Duration of the filter alone.
  double seconds = 0;
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

void tell(const FilterArguments& arguments, const FilteredCloud& filtered, const Measured& measured) {
  const NeuralGas& gas = filtered.gas;
  const bool neural = arguments.filter.method == "gng";
  const auto written = static_cast<std::size_t>(
      std::count_if(filtered.cloud.points.begin(), filtered.cloud.points.end(), isFinite));
  const std::size_t holes =  // PLY has none
      io::hasSuffix(arguments.output, {".ply"}) ? 0 : filtered.cloud.points.size() - written;
  if (arguments.json) {
    nlohmann::ordered_json json{{"cloud", arguments.output},
                                {"method", arguments.filter.method},
                                {"points_in", measured.all},
                                {"finite", measured.finite},
                                {"points_out", written},
                                {"holes", holes},
                                {"resolution", measured.resolution},
                                {"noise", measured.noise},
                                {"seconds", measured.seconds}};
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
  fmt::print("{}: {} of {} points", printable(arguments.output), written, measured.all);
  if (measured.finite < measured.all)
    fmt::print("; {} that are not finite are {}", measured.all - measured.finite,
               holes > 0 ? "kept as holes" : "left out");
  if (filtered.leaf > 0) fmt::print("; voxels of {:.3g} m", filtered.leaf);
  if (neural)
    fmt::print("; {} edges, {} signals, quantization error {:.3g} m", gas.edges.size(), gas.signals,
               gas.quantizationError);
  fmt::print("; {:.2f} s\n", measured.seconds);
  fmt::print("the cloud's resolution is {:.3g} m and its noise {:.3g} m across the surface\n",
             measured.resolution, measured.noise);
}

/// Flags that only some filters use.
constexpr std::pair<const char*, const char*> methodsOf[] = {{"--points", "gng or voxel"},
                                                             {"--leaf", "voxel"},
                                                             {"--quantization-error", "gng"},
                                                             {"--max-seconds", "gng"},
                                                             {"--graph", "gng"}};

void requireUsed(const CLI::App& command, const std::string& method) {
  for (const auto& [option, methods] : methodsOf)
    if (command.count(option) > 0 && std::string_view(methods).find(method) == std::string_view::npos)
      throw Error(ErrorCode::invalidOption,
                  fmt::format("{} needs --filter {}; {} does not use it", option, methods, method));
}

void requireOutputs(const FilterArguments& arguments) {
  std::vector<std::string> outputs{arguments.output};
  requireCloudFile(arguments.output);
  if (!arguments.graph.empty()) {
    requireCloudFile(arguments.graph, true);
    const auto place = [](const std::string& file) {
      return std::filesystem::weakly_canonical(std::filesystem::absolute(file));
    };
    if (place(arguments.graph) == place(arguments.output))
      throw Error(
          ErrorCode::invalidOption,
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

/// Normals of the filtered points, fitted to the points around them in the cloud that was filtered.
void addNormals(PointCloud& filtered, const PointCloud& cloud, const Neighbors& around, NormalOptions options,
                const Measured& measured) {
  if (options.radius == 0 && options.neighbors == 0)  // wide enough to show through the noise
    options.radius = std::max(7 * measured.resolution, 3 * measured.noise);
  if (options.radius == 0 && options.neighbors == 0)
    throw Error(ErrorCode::invalidInput, "normals need points at different places; this cloud has none");
  if (cloud.viewpoint)
    options.viewpoint = cv::Point3d(cloud.viewpoint->x, cloud.viewpoint->y, cloud.viewpoint->z);
  filtered.normals = estimateNormals(filtered.points, around, options);
  if (std::ranges::none_of(filtered.normals, [](const cv::Point3f& n) { return std::isfinite(n.x); }))
    throw Error(
        ErrorCode::invalidOption,
        fmt::format("no point has enough others within {:.3g} m for a normal; the points lie {:.3g} m "
                    "apart, so give a --normal-radius of {:.3g} m or more",
                    options.radius, measured.resolution, 4 * measured.resolution));
}

void run(const FilterArguments& arguments) {
  requireOutputs(arguments);
  PointCloud cloud = withGaussianNoise(readCloud(arguments.input, arguments.file), arguments.noise,
                                       arguments.filter.gng.seed);
  if (arguments.noise > 0) cloud.normals.clear();  // they were those of the points without it
  const Neighbors around(cloud.points, 0);
  Measured measured{cloud.points.size(), around.size(), resolutionOf(around), estimateNoise(around), 0};

  const auto progress = makeStderrProgress();
  const auto start = std::chrono::steady_clock::now();
  FilteredCloud filtered = filterWithDetails(cloud, arguments.filter, *progress);
  measured.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  if (arguments.normals) addNormals(filtered.cloud, cloud, around, arguments.normal, measured);
  writeCloud(filtered.cloud, arguments.output);
  if (!arguments.graph.empty()) writeCloud(filtered.cloud, arguments.graph, filtered.gas.edges);
  if (!arguments.image.empty()) {
    CloudLayer layer;
    layer.cloud = &filtered.cloud;
    layer.edges = filtered.gas.edges;
    writePng(drawClouds({&layer, 1}), arguments.image);
  }
  tell(arguments, filtered, measured);
}

}  // namespace

void addFilterCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("filter", "Thin out and denoise a point cloud");
  auto a = std::make_shared<FilterArguments>(*command);
  command->add_option("IN", a->input, "Cloud (.pcd, .ply) or depth image (.png, .tif, .exr, …)")->required();
  addOutputOption(*command, a->output, "The filtered cloud, .pcd or .ply")->required();
  a->declared.add(declare(a->filter), {"method=filter", "points", "leaf", "gng.quantization-error",
                                       "gng.seconds=max-seconds", "gng.seed"});
  command->get_option("--leaf")->excludes("--points");
  command->get_option("--seed")->description("Seed of the signals of gng, and of --noise\nDefault: 1");
  command->add_option("--graph", a->graph, "gng: write the graph of the neurons, too (.ply with edges)");
  command->add_option("--render", a->image, "Draw the filtered cloud, neurons with their graph (PNG)");
  command->add_option("--noise", a->noise,
                      "First add Gaussian noise of this standard deviation to x, y and z [m]; normals of IN "
                      "are dropped then");
  command->add_flag("--normals", a->normals,
                    "Write normals that point to the sensor: the VIEWPOINT of a PCD, else the origin");
  a->declared.add(declare(a->normal), {"radius=normal-radius"});
  command->get_option("--normal-radius")
      ->description("Radius of the points that a plane is fitted to [m]\nDefault: follows the noise")
      ->needs("--normals");
  a->declared.add(declare(a->file), {"depth-scale", "intrinsics", "colors"});
  addOverwriteOption(*command, a->overwrite);
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia filter scene.pcd -o small.ply --points 10000 --graph graph.ply\n"
              "  estancia filter scene.pcd -o small.pcd --filter voxel --points 10000 --normals\n"
              "  estancia filter scene.pcd -o noisy.pcd --filter none --noise 0.005 --seed 3\n"
              "  estancia filter kitchen/frame-000000.depth.png -o kitchen.ply --filter none --intrinsics "
              "camera.txt");
  command->callback([a, command] {
    requireUsed(*command, a->filter.method);
    run(*a);
  });
}

}  // namespace estancia::apps
