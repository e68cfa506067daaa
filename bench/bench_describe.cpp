// PHOG, GIST and ESF, one thread each, beside peers in the same run. docs/measured/benchmarks.md holds what
// it showed.
//   bench_describe [SEQUENCE]   a folder of images with depth (rgb/, depth/), brought to 320×240; without
//                               it made-up ones. Peers are scikit-image and PCL, where they are at hand.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#ifdef ESTANCIA_HAS_PCL
#include <pcl/features/esf.h>
#include <pcl/point_types.h>
#endif

#include "estancia/core/error.hpp"
#include "estancia/describe/esf.hpp"
#include "estancia/describe/gist.hpp"
#include "estancia/describe/phog.hpp"
#include "estancia/readers/open_sequence.hpp"

namespace {

using namespace estancia;
namespace fs = std::filesystem;

constexpr std::size_t views = 40;
const cv::Size kSize(320, 240);
const CameraIntrinsics camera{320, 240, 290, 290, 159.5, 119.5};

struct Scene {
  cv::Mat image, depth;
};

/// Blocks of noise, and a room with a box in it.
Scene madeUp(int number) {
  Scene scene;
  cv::Mat blocks(30, 40, CV_8UC3);
  cv::RNG random(static_cast<std::uint64_t>(number) + 1);
  random.fill(blocks, cv::RNG::UNIFORM, 0, 256);
  cv::resize(blocks, scene.image, kSize, 0, 0, cv::INTER_CUBIC);
  scene.depth.create(kSize, CV_32F);
  const float wall = 3 + 0.05F * static_cast<float>(number);
  for (int y = 0; y < kSize.height; ++y)
    for (int x = 0; x < kSize.width; ++x) {
      const auto floor = static_cast<float>(y > 120 ? 1.4 / camera.slopeY(y) : 1e9);
      const bool box = x > 100 && x < 180 && y > 90 && y < 190;
      scene.depth.at<float>(y, x) =
          std::min({wall, floor, box ? 1.8F : 1e9F}) + static_cast<float>(random.gaussian(0.005));
    }
  return scene;
}

std::vector<Scene> scenesOf(const fs::path& path) {
  std::vector<Scene> scenes;
  if (path.empty()) {
    for (std::size_t i = 0; i < views; ++i) scenes.push_back(madeUp(static_cast<int>(i)));
    return scenes;
  }
  const auto sequence = openSequence(path);
  if (!sequence->hasDepth()) throw Error(ErrorCode::invalidInput, path.string() + ": there is no depth");
  const std::size_t step = std::max<std::size_t>(sequence->size() / views, 1);
  for (std::size_t i = 0; i < sequence->size() && scenes.size() < views; i += step) {
    Scene& scene = scenes.emplace_back();
    cv::resize(sequence->image(i), scene.image, kSize, 0, 0, cv::INTER_AREA);
    cv::resize(sequence->depth(i), scene.depth, kSize, 0, 0, cv::INTER_NEAREST);
  }
  return scenes;
}

/// Processor time of this thread, which other load of the machine does not affect.
double milliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

struct Milliseconds {
  double median, best;
};

/// Time of one object: the mean over all, three times each.
template <class Object>
Milliseconds timeOf(const std::vector<Object>& objects, const std::function<void(const Object&)>& work) {
  std::vector<double> times;
  work(objects.front());
  for (int round = 0; round < 3; ++round)
    for (const Object& object : objects) {
      const double start = milliseconds();
      work(object);
      times.push_back(milliseconds() - start);
    }
  std::sort(times.begin(), times.end());
  return {times[times.size() / 2], times.front()};
}

/// Milliseconds of the four peers; empty where there is no scikit-image.
std::vector<double> scikitImage(const std::vector<Scene>& scenes) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("bench_describe.{}", getpid());
  fs::create_directory(folder);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    cv::imwrite((folder / fmt::format("{:04}.png", i)).string(), scenes[i].image);
  const std::string command = fmt::format("/usr/bin/python3 '{}/bench/skimage_descriptors.py' '{}'",
                                          ESTANCIA_SOURCE_DIR, folder.string());
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::vector<double> times;
  for (double t = 0; pipe && std::fscanf(pipe.get(), "%lf", &t) == 1;) times.push_back(t);
  fs::remove_all(folder);
  if (times.size() != 4) {
    fmt::print(stderr, "scikit-image gave no answer; install python3-skimage\n");
    times.clear();
  }
  return times;
}

void print(const std::string& who, const Milliseconds& ours) {
  fmt::print("| {} | {:.2f} | {:.2f} | |\n", who, ours.median, ours.best);
}
void printPeer(const std::string& who, double theirs, const Milliseconds& ours) {
  fmt::print("| {} | {:.2f} | | {:.1f} |\n", who, theirs, theirs / ours.median);
}

void run(const fs::path& path) {
  cv::setNumThreads(1);
  const std::vector<Scene> scenes = scenesOf(path);
  fmt::print(
      "{} images of {}x{}, one thread; milliseconds of the processor\n\n| who | ms, median | best | times "
      "as fast |\n|---|---|---|---|\n",
      scenes.size(), kSize.width, kSize.height);
  const Milliseconds edges = timeOf<Scene>(scenes, [](const Scene& s) { phog(s.image); });
  const Milliseconds energies = timeOf<Scene>(scenes, [](const Scene& s) { gist(s.image); });
  print("PHOG", edges);
  const std::vector<double> peers = scikitImage(scenes);
  if (!peers.empty()) {
    printPeer("the same by scikit-image's canny and sobel", peers[0], edges);
    printPeer("scikit-image's hog, three sizes of cells, no edges", peers[1], edges);
  }
  print("GIST", energies);
  if (!peers.empty()) {
    printPeer("its filters by SciPy's Fourier transforms, no prefilter", peers[2], energies);
    printPeer("scikit-image's gabor, the same frequencies, no prefilter", peers[3], energies);
  }
  print("ESF of a depth image, 20,000 of its points",
        timeOf<Scene>(scenes, [](const Scene& s) { esf(backProject(s.depth, camera)); }));
  std::vector<PointCloud> clouds;
  for (const Scene& scene : scenes) {
    clouds.push_back(backProject(scene.depth, camera));
    std::erase_if(clouds.back().points, [](const cv::Point3f& p) { return !std::isfinite(p.z); });
  }
  const Milliseconds all =
      timeOf<PointCloud>(clouds, [](const PointCloud& cloud) { esf(cloud, {.points = 0}); });
  print("ESF of all points", all);
#ifdef ESTANCIA_HAS_PCL
  using PclCloud = pcl::PointCloud<pcl::PointXYZ>;
  std::vector<PclCloud::Ptr> same;
  for (const PointCloud& cloud : clouds) {
    same.push_back(std::make_shared<PclCloud>());
    for (const cv::Point3f& p : cloud.points) same.back()->emplace_back(p.x, p.y, p.z);
  }
  const Milliseconds theirs = timeOf<PclCloud::Ptr>(same, [](const PclCloud::Ptr& cloud) {
    pcl::ESFEstimation<pcl::PointXYZ> estimation;
    estimation.setInputCloud(cloud);
    pcl::PointCloud<pcl::ESFSignature640> result;
    estimation.compute(result);
  });
  printPeer("PCL's ESFEstimation, the same points and as many samples", theirs.median, all);
#else
  fmt::print(stderr, "built without PCL; install libpcl-dev\n");
#endif
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 2) {
    std::fputs("usage: bench_describe [SEQUENCE]\n", stderr);
    return 2;
  }
  try {
    run(argc == 2 ? argv[1] : "");
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
  }
  return 2;
}
