// Taking depth images apart, stage by stage, beside PCL's planes and Euclidean clusters in the same run.
//   bench_clusters FOCAL DEPTH…    images in millimeters whose camera looks along their middle
//   bench_clusters FOCAL noise     an image of 320 x 240 that is noise alone: nothing of it may take for ever
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#ifdef ESTANCIA_HAS_PCL
#include <pcl/features/integral_image_normal.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/organized_multi_plane_segmentation.h>
#endif

#include "estancia/files/depth_file.hpp"
#include "estancia/segmentation/clusters.hpp"
#include "estancia/segmentation/inverse_depth.hpp"
#include "estancia/segmentation/segmentation_stages.hpp"
#include "estancia/segmentation/segments.hpp"

namespace {

using namespace estancia;

constexpr int rounds = 3;

double processorTime() {  // time of this thread; other load of the machine does not affect it
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double wallTime() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Milliseconds, the best of some rounds.
double milliseconds(double (*clock)(), const std::function<void()>& work) {
  double best = HUGE_VAL;
  for (int round = 0; round < rounds; ++round) {
    const double begin = clock();
    work();
    best = std::min(best, clock() - begin);
  }
  return 1e3 * best;
}

struct Row {
  std::string what;
  double sum = 0;
};

#ifdef ESTANCIA_HAS_PCL
/// What PCL has for it: planes by the normals of integral images, then Euclidean clusters of what is left.
struct Pcl {
  using Points = pcl::PointCloud<pcl::PointXYZ>;
  Points::Ptr points{new Points}, rest{new Points};
  pcl::PointCloud<pcl::Normal>::Ptr normals{new pcl::PointCloud<pcl::Normal>};
  std::vector<pcl::PointIndices> planes, clusters;

  explicit Pcl(const PointCloud& cloud) {
    for (const cv::Point3f& p : cloud.points) points->push_back({p.x, p.y, p.z});
    points->width = static_cast<std::uint32_t>(cloud.width);
    points->height = static_cast<std::uint32_t>(cloud.height);
    points->is_dense = false;
  }
  void findNormals() {
    pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    estimation.setNormalEstimationMethod(estimation.AVERAGE_3D_GRADIENT);
    estimation.setMaxDepthChangeFactor(0.02F);
    estimation.setNormalSmoothingSize(20);
    estimation.setInputCloud(points);
    estimation.compute(*normals);
  }
  void findPlanes() {
    pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ, pcl::Normal, pcl::Label> segmentation;
    segmentation.setMinInliers(10'000);
    segmentation.setAngularThreshold(3 * M_PI / 180);
    segmentation.setDistanceThreshold(0.02);
    segmentation.setInputNormals(normals);
    segmentation.setInputCloud(points);
    std::vector<pcl::ModelCoefficients> coefficients;
    pcl::PointCloud<pcl::Label>::Ptr labels(new pcl::PointCloud<pcl::Label>);
    std::vector<pcl::PointIndices> labelIndices, borders;
    std::vector<pcl::PlanarRegion<pcl::PointXYZ>, Eigen::aligned_allocator<pcl::PlanarRegion<pcl::PointXYZ>>>
        regions;
    planes.clear();
    segmentation.segmentAndRefine(regions, coefficients, planes, labels, labelIndices, borders);
  }
  void findClusters(const ClusterOptions& options) {
    std::vector<char> taken(points->size());
    for (const pcl::PointIndices& plane : planes)
      for (const int i : plane.indices) taken[static_cast<std::size_t>(i)] = 1;
    rest->clear();
    for (std::size_t i = 0; i < points->size(); ++i)
      if (taken[i] == 0 && std::isfinite((*points)[i].z)) rest->push_back((*points)[i]);
    clusters.clear();
    if (rest->empty()) return;
    pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
    extraction.setClusterTolerance(0.02);
    extraction.setMinClusterSize(static_cast<int>(options.minPoints));
    extraction.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
    extraction.setInputCloud(rest);
    extraction.extract(clusters);
  }
};
#endif

cv::Mat readOrMake(const std::string& depth) {
  if (depth != "noise") return io::readDepth(depth, 1000);
  cv::Mat noise(240, 320, CV_32F);
  cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0.5, 10.);
  return noise;
}

void run(double focal, const std::vector<std::string>& files) {
  std::vector<Row> rows = {{"1/z, smoothed"},
                           {"planes"},
                           {"structure"},
                           {"creases"},
                           {"segments"},
                           {"remnants of structure"},
                           {"joins"},
                           {"loose parts"},
                           {"furniture"},
                           {"vessels"},
                           {"all of it"},
                           {"all, wall clock, one thread"},
                           {"all, wall clock, two threads"},
                           {"PCL: normals"},
                           {"PCL: planes"},
                           {"PCL: Euclidean clusters of 2 cm"}};
  std::size_t ours = 0, planes = 0, theirs = 0, theirPlanes = 0;
  for (const std::string& file : files) {
    const cv::Mat depth = readOrMake(file);
    const CameraIntrinsics camera{depth.cols,           depth.rows, focal, focal, (depth.cols - 1) / 2.,
                                  (depth.rows - 1) / 2.};
    ClusterOptions options;
    options.threads = 1;
    auto add = [&, next = rows.begin()](double (*clock)(), const std::function<void()>& work) mutable {
      (next++)->sum += milliseconds(clock, work);
    };
    InverseDepth grid;
    std::optional<PlaneRemoval> removal, structured;
    std::vector<std::uint8_t> creases;
    Segmentation segments, kept, joined, loose, furniture, vessels;
    add(processorTime, [&] { grid = inverseDepth(depth, camera, 1); });
    add(processorTime, [&] { removal.emplace(removePlanes(grid, options)); });
    cv::Vec3d up;
    Segmentation patches;
    std::optional<Mask> foreground;
    add(processorTime, [&] {
      PlaneRemoval copy = *removal;
      up = upOf(copy.planes);
      findStructure(grid, up, copy);
      patches = takePatches(grid, copy);
      dropGrazedLevels(grid, up, copy);
      structured.emplace(std::move(copy));
    });
    add(processorTime, [&] { creases = concaveCreases(grid, structured->rest, options.creaseDepth, 1); });
    add(processorTime, [&] { segments = oversegment(grid, structured->rest, creases); });
    add(processorTime,
        [&] { foreground.emplace(dropStructure(grid, *structured, up, patches, kept = segments)); });
    add(processorTime, [&] { mergeSegments(grid, *foreground, 1, joined = kept); });
    add(processorTime, [&] { joinLoose(grid, *foreground, structured->half, up, loose = joined); });
    add(processorTime,
        [&] { assembleFurniture(grid, *foreground, structured->half, {}, up, furniture = loose); });
    add(processorTime,
        [&] { mergeContainerInteriors(grid, *foreground, structured->planes, 1, vessels = furniture); });
    Clusters found;
    add(processorTime, [&] { found = findClusters(depth, camera, options); });
    add(wallTime, [&] { found = findClusters(depth, camera, options); });
    options.threads = 2;
    add(wallTime, [&] { found = findClusters(depth, camera, options); });
    ours += found.clusters.size();
    planes += found.planes.size();
#ifdef ESTANCIA_HAS_PCL
    Pcl pcl(backProject(depth, camera));
    add(processorTime, [&] { pcl.findNormals(); });
    add(processorTime, [&] { pcl.findPlanes(); });
    add(processorTime, [&] { pcl.findClusters(options); });
    theirs += pcl.clusters.size();
    theirPlanes += pcl.planes.size();
#endif
  }
  fmt::print("{} images, milliseconds each, best of {}; processor time of one thread unless said\n\n",
             files.size(), rounds);
  fmt::print("| stage | ms |\n|---|---|\n");
  for (const Row& row : rows)
    if (row.sum > 0) fmt::print("| {} | {:.2f} |\n", row.what, row.sum / static_cast<double>(files.size()));
  fmt::print("\nours: {} planes, {} clusters; PCL's: {} planes, {} clusters\n", planes, ours, theirPlanes,
             theirs);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: bench_clusters FOCAL DEPTH…|noise\n");
    return 2;
  }
  try {
    run(std::stod(argv[1]), {argv + 2, argv + argc});
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 2;
  }
}
