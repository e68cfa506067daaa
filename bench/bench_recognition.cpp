// A model found in a scene: ours beside a straight PCL program with the same parameters, in the manner of
// PCL's tutorials on correspondence grouping and global hypothesis verification. docs/measured/benchmarks.md
// holds what it showed.
//   bench_recognition MODEL.pcd SCENE.pcd [--descriptor shot|fpfh] [--threads N]
// Each program runs in a process of its own, one after the other, so that its time and its memory are its
// own.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <functional>
#include <numeric>
#include <opencv2/core/affine.hpp>

#ifdef ESTANCIA_HAS_PCL
#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/features/shot.h>
#include <pcl/filters/uniform_sampling.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/registration/icp.h>
#include <pcl/recognition/impl/cg/geometric_consistency.hpp>
#endif

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/pcd.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "estancia/recognition/surface.hpp"

namespace {

using namespace estancia;

// Parameters of both programs [m]: the clouds' points lie about 1 and 2 mm apart.
constexpr double kNormalRadius = 0.015, kSpacing = 0.010, kDescriptorRadius = 0.030, kConsistency = 0.010;
constexpr double kTolerance = 0.005;
constexpr std::size_t minimum = 30;  // matches that must agree
constexpr std::size_t refined =
    5;                      // poses with most matches that PCL's ICP, which is slow, refines; ours: all
constexpr int rounds = 30;  // rounds of ICP

struct Task {
  std::string model, scene, descriptor = "shot";
  int threads = 2;
};

struct Outcome {
  double seconds = 0;       ///< reading the files left out
  double descriptors = 0;   ///< time of describing both clouds
  std::size_t inliers = 0;  ///< model points with a scene point within kTolerance, of the best pose
  std::size_t poses = 0;
};

class Watch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::size_t inliersOf(const cv::Affine3d& pose, const PointCloud& model, const Neighbors& scene) {
  std::vector<Neighbor> buffer;
  std::size_t count = 0;
  for (const cv::Point3f& p : model.points)
    if (!scene.nearest(cv::Affine3f(pose) * p, 1, buffer, kTolerance).empty()) ++count;
  return count;
}

void tell(const std::string& stage, double seconds) {
  fmt::print("  {:<14} {:7.3f} s\n", stage, seconds);
  std::fflush(stdout);
}

Outcome runOurs(const Task& task) {
  const PointCloud model = readPcd(task.model), scene = readPcd(task.scene);
  RecognitionOptions options = RecognitionOptions::preset("tight");
  options.descriptor = task.descriptor;
  options.normalRadius = kNormalRadius;
  options.keypointSpacing = kSpacing;
  options.descriptorRadius = kDescriptorRadius;
  options.consistency = kConsistency;
  options.tolerance = kTolerance;
  options.minMatches = minimum;
  options.threads = task.threads;
  Progress silent;
  Outcome outcome;
  const Watch watch;
  const Recognizer recognizer(options);
  const auto preparedScene = recognizer.prepareScene("scene", scene, silent);
  const auto preparedModel = recognizer.prepareModel("model", model);
  std::vector<StageReport> stages;
  const std::vector<Detection> found = recognizer.find(*preparedModel, *preparedScene, &stages);
  outcome.seconds = watch.seconds();
  stages.insert(stages.begin(), preparedScene->stages().begin(), preparedScene->stages().end());
  for (const StageReport& s : stages) {
    fmt::print("  {:<14} {:7.3f} s  {}\n", s.stage, s.seconds, s.detail);
    if (s.stage == "descriptors") outcome.descriptors += s.seconds;
  }
  const Neighbors neighbors(scene.points, task.threads);
  outcome.poses = found.size();
  for (const Detection& i : found)
    outcome.inliers = std::max(outcome.inliers, inliersOf(i.pose, model, neighbors));
  return outcome;
}

#ifdef ESTANCIA_HAS_PCL

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Normals = pcl::PointCloud<pcl::Normal>;

Cloud::Ptr toPcl(const PointCloud& cloud) {
  auto out = pcl::make_shared<Cloud>();
  for (const cv::Point3f& p : cloud.points)
    if (std::isfinite(p.x)) out->emplace_back(p.x, p.y, p.z);
  return out;
}

Normals::Ptr normalsOf(const Cloud::Ptr& cloud) {
  auto normals = pcl::make_shared<Normals>();
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(kNormalRadius);
  estimation.compute(*normals);
  return normals;
}

Cloud::Ptr keypointsOf(const Cloud::Ptr& cloud) {
  auto keypoints = pcl::make_shared<Cloud>();
  pcl::UniformSampling<pcl::PointXYZ> sampling;
  sampling.setInputCloud(cloud);
  sampling.setRadiusSearch(kSpacing);
  sampling.filter(*keypoints);
  return keypoints;
}

template <class Estimation, class Output>
typename pcl::PointCloud<Output>::Ptr described(const Cloud::Ptr& cloud, const Cloud::Ptr& keypoints,
                                                const Normals::Ptr& normals) {
  auto out = pcl::make_shared<pcl::PointCloud<Output>>();
  Estimation estimation;
  estimation.setInputCloud(keypoints);
  estimation.setSearchSurface(cloud);
  estimation.setInputNormals(normals);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(kDescriptorRadius);
  estimation.compute(*out);
  return out;
}

template <class Output>
pcl::CorrespondencesPtr matched(const pcl::PointCloud<Output>& model, const pcl::PointCloud<Output>& scene,
                                const std::function<bool(const Output&)>& isFinite) {
  auto matches = pcl::make_shared<pcl::Correspondences>();
  pcl::KdTreeFLANN<Output> tree;
  tree.setInputCloud(model.makeShared());
  pcl::Indices index(1);
  std::vector<float> squared(1);
  for (std::size_t i = 0; i < scene.size(); ++i)
    if (isFinite(scene[i]) && tree.nearestKSearch(scene[i], 1, index, squared) == 1)
      matches->emplace_back(index[0], static_cast<int>(i), squared[0]);
  return matches;
}

Outcome runPcl(const Task& task) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  const PointCloud modelCloud = readPcd(task.model), sceneCloud = readPcd(task.scene);
  const Cloud::Ptr model = toPcl(modelCloud), scene = toPcl(sceneCloud);
  Outcome outcome;
  const Watch watch;
  double last = 0;
  const auto lap = [&](const std::string& stage) {
    const double seconds = watch.seconds() - last;
    tell(stage, seconds);
    last = watch.seconds();
    return seconds;
  };
  const Normals::Ptr modelNormals = normalsOf(model), sceneNormals = normalsOf(scene);
  lap("normals");
  const Cloud::Ptr modelKeypoints = keypointsOf(model), sceneKeypoints = keypointsOf(scene);
  lap("keypoints");
  pcl::CorrespondencesPtr matches;
  if (task.descriptor == "fpfh") {
    using Fpfh = pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33>;
    const auto a = described<Fpfh, pcl::FPFHSignature33>(model, modelKeypoints, modelNormals);
    const auto b = described<Fpfh, pcl::FPFHSignature33>(scene, sceneKeypoints, sceneNormals);
    outcome.descriptors = lap("descriptors");
    matches =
        matched<pcl::FPFHSignature33>(*a, *b, [](const auto& f) { return std::isfinite(f.histogram[0]); });
  } else {
    using Shot = pcl::SHOTEstimation<pcl::PointXYZ, pcl::Normal, pcl::SHOT352>;
    const auto a = described<Shot, pcl::SHOT352>(model, modelKeypoints, modelNormals);
    const auto b = described<Shot, pcl::SHOT352>(scene, sceneKeypoints, sceneNormals);
    outcome.descriptors = lap("descriptors");
    matches = matched<pcl::SHOT352>(*a, *b, [](const auto& f) { return std::isfinite(f.descriptor[0]); });
  }
  lap("matching");
  pcl::GeometricConsistencyGrouping<pcl::PointXYZ, pcl::PointXYZ> grouping;
  grouping.setGCSize(kConsistency);
  grouping.setGCThreshold(static_cast<int>(minimum) - 1);
  grouping.setInputCloud(modelKeypoints);
  grouping.setSceneCloud(sceneKeypoints);
  grouping.setModelSceneCorrespondences(matches);
  std::vector<Eigen::Matrix4f, Eigen::aligned_allocator<Eigen::Matrix4f>> poses;
  std::vector<pcl::Correspondences> groups;
  grouping.recognize(poses, groups);
  lap("grouping");
  const Neighbors neighbors(sceneCloud.points, 1);
  std::vector<std::size_t> order(poses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return groups[a].size() > groups[b].size(); });
  order.resize(std::min(order.size(), refined));
  for (const std::size_t which : order) {
    const Eigen::Matrix4f& pose = poses[which];
    pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
    icp.setMaximumIterations(rounds);
    icp.setMaxCorrespondenceDistance(2 * kTolerance);
    icp.setInputTarget(scene);
    icp.setInputSource(model);
    Cloud registered;
    icp.align(registered, pose);
    cv::Matx44d matrix;
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) matrix(r, c) = static_cast<double>(icp.getFinalTransformation()(r, c));
    outcome.inliers = std::max(outcome.inliers, inliersOf(cv::Affine3d(matrix), modelCloud, neighbors));
  }
  outcome.poses = poses.size();
  lap("refinement");
  outcome.seconds = watch.seconds();
  return outcome;
}

#endif

/// Runs a program in a process of its own.
Outcome apart(const std::string& name, const std::function<Outcome()>& program) {
  fmt::print("{}\n", name);
  std::fflush(stdout);
  int pipes[2];
  if (pipe(pipes) != 0) throw Error(ErrorCode::invalidInput, "no pipe can be opened");
  const pid_t child = fork();
  if (child == 0) {
    int status = 0;
    try {
      const Outcome outcome = program();
      status = write(pipes[1], &outcome, sizeof outcome) == sizeof outcome ? 0 : 1;
    } catch (const std::exception& e) {
      fmt::print(stderr, "error: {}\n", e.what());
      status = 2;
    }
    std::fflush(stdout);
    _exit(status);
  }
  close(pipes[1]);
  Outcome outcome;
  const bool told = read(pipes[0], &outcome, sizeof outcome) == sizeof outcome;
  close(pipes[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (!told) throw Error(ErrorCode::invalidState, name + " failed");
  fmt::print(
      "  {:<14} {:7.3f} s, {} poses, {} model points of the best within {} mm of the scene, peak {} MB\n",
      "all", outcome.seconds, outcome.poses, outcome.inliers, 1e3 * kTolerance, usage.ru_maxrss / 1024);
  return outcome;
}

}  // namespace

int main(int argc, char** argv) {
  Task task;
  CLI::App app("A model found in a scene, beside PCL");
  app.add_option("model", task.model)->required();
  app.add_option("scene", task.scene)->required();
  app.add_option("--descriptor", task.descriptor)->check(CLI::IsMember({"shot", "fpfh"}));
  app.add_option("--threads", task.threads);
  CLI11_PARSE(app, argc, argv);
  try {
    const Outcome ours = apart(fmt::format("Estancia, {}, {} threads", task.descriptor, task.threads),
                               [&] { return runOurs(task); });
#ifdef ESTANCIA_HAS_PCL
    const Outcome pcls = apart("PCL, " + task.descriptor, [&] { return runPcl(task); });
    fmt::print("ours is {:.1f} times as fast; describing {:.1f} times\n", pcls.seconds / ours.seconds,
               pcls.descriptors / ours.descriptors);
#endif
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 2;
  }
}
