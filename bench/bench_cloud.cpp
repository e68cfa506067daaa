// Neighbors, normals and voxel grids, one thread, beside PCL's and nanoflann's in the same run.
//   bench_cloud CLOUD    a .pcd or .ply in meters, as a depth camera sees a room
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <functional>
#include <vector>

#if __has_include(<nanoflann.hpp>)
#include <nanoflann.hpp>
#define HAS_NANOFLANN
#endif
#ifdef ESTANCIA_HAS_PCL
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>
#endif

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/cloud_file.hpp"

namespace {

using namespace estancia;

constexpr std::size_t step = 7;  // every such point asks
constexpr double radii[] = {0.005, 0.015, 0.035, 0.06};
constexpr int kCounts[] = {1, 10, 30};

/// Processor time of this thread, which other load of the machine does not affect. The best of three.
double seconds(const std::function<void()>& work) {
  double best = HUGE_VAL;
  for (int round = 0; round < 3; ++round) {
    timespec begin{}, end{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
    work();
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    best = std::min(best, static_cast<double>(end.tv_sec - begin.tv_sec) +
                              1e-9 * static_cast<double>(end.tv_nsec - begin.tv_nsec));
  }
  return best;
}

/// Microseconds a query of ours, and of theirs, with what each of them found.
struct Row {
  std::string what;
  double ours = 0, pcl = 0, nanoflann = 0;
};

void print(const Row& row) {
  const auto ratio = [&](double theirs) {
    return theirs > 0 ? fmt::format("{:.2f} ({:.1f})", theirs, theirs / row.ours) : std::string();
  };
  fmt::print("| {} | {:.2f} | {} | {} |\n", row.what, row.ours, ratio(row.pcl), ratio(row.nanoflann));
  std::fflush(stdout);
}

#ifdef HAS_NANOFLANN
struct Adaptor {  // NOLINTBEGIN(readability-identifier-naming): nanoflann's names
  const std::vector<cv::Point3f>& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return (&points[i].x)[axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
// NOLINTEND(readability-identifier-naming)
using Nanoflann =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Adaptor>, Adaptor, 3>;
#endif

void run(const std::string& file) {
  PointCloud cloud = voxelGrid(readCloud(file), 1e-5);  // finite
  const std::vector<cv::Point3f>& points = cloud.points;
  std::vector<cv::Point3f> places;
  for (std::size_t i = 0; i < points.size(); i += step) places.push_back(points[i]);
  const double million = 1e6 / static_cast<double>(places.size());
  fmt::print("{} points, resolution {:.2g} m, noise {:.2g} m; one thread, best of three\n\n", points.size(),
             resolutionOf(cloud), estimateNoise(cloud));
  fmt::print("| microseconds a query (times ours) | ours | PCL | nanoflann |\n|---|---|---|---|\n");

  const Neighbors ours(points);
  std::vector<Neighbor> buffer;
#ifdef ESTANCIA_HAS_PCL
  const pcl::PointCloud<pcl::PointXYZ>::Ptr theirs(new pcl::PointCloud<pcl::PointXYZ>);
  const pcl::PointCloud<pcl::PointXYZ>::Ptr few(new pcl::PointCloud<pcl::PointXYZ>);
  for (const cv::Point3f& p : points) theirs->push_back({p.x, p.y, p.z});
  for (const cv::Point3f& p : places) few->push_back({p.x, p.y, p.z});
  pcl::KdTreeFLANN<pcl::PointXYZ> flann(false);
  flann.setInputCloud(theirs);
  std::vector<int> indices;
  std::vector<float> distances;
#endif
#ifdef HAS_NANOFLANN
  const Adaptor adaptor{points};
  Nanoflann nano(3, adaptor, {16});
  nano.buildIndex();
  std::vector<std::pair<std::uint32_t, float>> matches;
  nanoflann::SearchParams unsorted;
  unsorted.sorted = false;
#endif
  std::size_t found = 0;
  Row row{"building, milliseconds"};
  row.ours = 1e3 * seconds([&] { found += Neighbors(points).size(); });
#ifdef ESTANCIA_HAS_PCL
  row.pcl = 1e3 * seconds([&] { pcl::KdTreeFLANN<pcl::PointXYZ>().setInputCloud(theirs); });
#endif
#ifdef HAS_NANOFLANN
  row.nanoflann = 1e3 * seconds([&] { nano.buildIndex(); });
#endif
  print(row);
  for (const double radius : radii) {
    const auto r = static_cast<float>(radius);
    found = 0;
    for (const cv::Point3f& p : places) found += ours.within(p, r, buffer).size();
    row = {fmt::format("within {} m: {} points", radius, found / places.size())};
    row.ours = million * seconds([&] {
                 for (const cv::Point3f& p : places) found += ours.within(p, r, buffer).size();
               });
#ifdef ESTANCIA_HAS_PCL
    row.pcl = million * seconds([&] {
                for (const auto& p : *few) flann.radiusSearch(p, radius, indices, distances);
              });
#endif
#ifdef HAS_NANOFLANN
    row.nanoflann = million * seconds([&] {
                      for (const cv::Point3f& p : places) nano.radiusSearch(&p.x, r * r, matches, unsorted);
                    });
#endif
    print(row);
  }
  for (const int count : kCounts) {
    const auto k = static_cast<std::size_t>(count);
    row = {fmt::format("{} nearest", count)};
    row.ours = million * seconds([&] {
                 for (const cv::Point3f& p : places) found += ours.nearest(p, k, buffer).size();
               });
#ifdef ESTANCIA_HAS_PCL
    row.pcl = million * seconds([&] {
                for (const auto& p : *few) flann.nearestKSearch(p, count, indices, distances);
              });
#endif
#ifdef HAS_NANOFLANN
    std::vector<std::uint32_t> nearest(k);
    std::vector<float> squared(k);
    row.nanoflann = million * seconds([&] {
                      for (const cv::Point3f& p : places)
                        nano.knnSearch(&p.x, k, nearest.data(), squared.data());
                    });
#endif
    print(row);
  }
  for (const double radius : radii) {
    NormalOptions options;
    options.radius = radius;
    options.threads = 1;
    row = {fmt::format("normals, {} m", radius)};
    row.ours = million * seconds([&] { found += estimateNormals(places, ours, options).size(); });
#ifdef ESTANCIA_HAS_PCL
    row.pcl =
        million * seconds([&] {
          pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
          const pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>(false));
          tree->setInputCloud(theirs);
          estimation.setSearchMethod(tree);
          estimation.setInputCloud(few);
          estimation.setSearchSurface(theirs);
          estimation.setRadiusSearch(radius);
          pcl::PointCloud<pcl::Normal> normals;
          estimation.compute(normals);
        });
#endif
    print(row);
  }
  row = {"voxel grid of 0.01 m, milliseconds"};
  row.ours = 1e3 * seconds([&] { found += voxelGrid(cloud, 0.01).points.size(); });
#ifdef ESTANCIA_HAS_PCL
  row.pcl = 1e3 * seconds([&] {
              pcl::VoxelGrid<pcl::PointXYZ> grid;
              grid.setInputCloud(theirs);
              grid.setLeafSize(0.01F, 0.01F, 0.01F);
              pcl::PointCloud<pcl::PointXYZ> filtered;
              grid.filter(filtered);
            });
#endif
  print(row);
  if (found == 0) fmt::print("nothing was found\n");  // so that no loop is left out
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: bench_cloud CLOUD\n");
    return 2;
  }
  try {
    run(argv[1]);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 2;
  }
}
