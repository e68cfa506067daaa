// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/segmentation/clusters.hpp"
#include "estancia/sequences/sequence.hpp"
#include "recognition/color_cases.hpp"

namespace estancia::experiments {
namespace {

/// Pixels with depth of a thing in a frame.
struct Piece {
  std::size_t frame = 0;
  std::string name;
  std::vector<std::uint32_t> pixels;
};

class Drive {
 public:
  explicit Drive(const DriveCasesOptions& options)
      : options_(options), sequence_(openSequence(options.path)) {
    if (!sequence_->hasDepth() || !sequence_->intrinsics() || !sequence_->poseSource())
      throw Error(
          ErrorCode::invalidInput,
          fmt::format("{} has no depth, camera or poses; color cases need all", options.path.string()));
  }

  std::size_t size() const { return sequence_->size(); }
  std::string nameOf(std::size_t i) const { return sequence_->frame(i).name; }
  std::optional<cv::Affine3d> pose(std::size_t i) const {
    const auto& pose = sequence_->frame(i).pose;
    return pose ? std::optional(rigidOf(*pose)) : std::nullopt;
  }
  CameraIntrinsics camera(const cv::Mat& depth) const {
    return sequence_->intrinsics()->scaledTo(depth.cols, depth.rows);
  }

  cv::Mat depth(std::size_t i) const {
    cv::Mat depth = sequence_->depth(i);
    cv::RNG random(options_.seed + i);
    for (float& z : cv::Mat_<float>(depth))
      z += z > 0 ? static_cast<float>(random.gaussian(options_.noise) * z * z) : 0;
    return depth;
  }

  PointCloud cloud(std::size_t i) const {
    const cv::Mat depth = this->depth(i);
    PointCloud cloud = backProject(depth, *sequence_->intrinsics());
    cv::Mat image = sequence_->image(i);
    if (image.size() != depth.size()) cv::resize(image, image, depth.size(), 0, 0, cv::INTER_AREA);
    cloud.colors.assign(image.begin<cv::Vec3b>(), image.end<cv::Vec3b>());
    return cloud;
  }

  /// The things of frame i that are large enough and do not touch its edge.
  std::vector<Piece> pieces(std::size_t i) const {
    const cv::Mat depth = this->depth(i);
    std::vector<Piece> pieces;
    const auto keep = [&](const std::string& name, std::vector<std::uint32_t> pixels) {
      if (pixels.size() < options_.minPixels) return;
      const auto atEdge = [&](std::uint32_t p) {
        const auto column = static_cast<int>(p) % depth.cols, row = static_cast<int>(p) / depth.cols;
        return column < 2 || row < 2 || column >= depth.cols - 2 || row >= depth.rows - 2;
      };
      if (std::ranges::any_of(pixels, atEdge)) return;
      pieces.push_back({i, fmt::format("{} of {}", name, nameOf(i)), std::move(pixels)});
    };
    if (!options_.instances) {
      std::size_t number = 0;
      for (estancia::Cluster& cluster :
           findClusters(depth, *sequence_->intrinsics(), {.threads = 1}).clusters)
        keep(fmt::format("cluster {}", number++), std::move(cluster.points));
      return pieces;
    }
    const cv::Mat mask = io::readInstanceMask(io::instanceMaskFile(options_.path, sequence_->frame(i)));
    std::map<int, std::vector<std::uint32_t>> things;
    for (std::size_t p = 0; p < mask.total(); ++p)
      if (mask.ptr<std::uint16_t>()[p] >= io::firstInstance && depth.ptr<float>()[p] > 0)
        things[mask.ptr<std::uint16_t>()[p]].push_back(static_cast<std::uint32_t>(p));
    for (auto& [id, pixels] : things) keep(fmt::format("thing {}", id), std::move(pixels));
    return pieces;
  }

 private:
  const DriveCasesOptions& options_;
  std::unique_ptr<Sequence> sequence_;
};

/// Share of a model's points that a frame sees where they should be.
double visibleShare(const PointCloud& model, const cv::Affine3d& toFrame, const cv::Mat& depth,
                    const CameraIntrinsics& camera) {
  constexpr double near = 0.03;  // [m] at 1 m, growing as noise does
  constexpr std::size_t every = 5;
  double seen = 0, all = 0;
  for (std::size_t i = 0; i < model.points.size(); i += every) {
    ++all;
    const cv::Point3d p = toFrame * cv::Point3d(model.points[i]);
    if (!(p.z > 0)) continue;
    const int u = cvRound(p.x / p.z * camera.fx + camera.cx), v = cvRound(p.y / p.z * camera.fy + camera.cy);
    if (u < 0 || v < 0 || u >= depth.cols || v >= depth.rows) continue;
    const double z = static_cast<double>(depth.at<float>(v, u));
    if (z > 0 && std::abs(z - p.z) < near * std::max(1.0, p.z * p.z)) ++seen;
  }
  return seen / std::max(all, 1.0);
}

/// The second largest share of the normals' scatter: 0 for a plane.
double unevenness(const PointCloud& model) {
  const Neighbors neighbors(model.points);
  const auto normals =
      estimateNormals(model.points, neighbors, {.radius = 6 * spacingOf(neighbors), .neighbors = 0});
  cv::Matx33d scatter = cv::Matx33d::zeros();
  for (const cv::Point3f& n : normals)
    if (isFinite(n)) {
      const cv::Vec3d v(n.x, n.y, n.z);
      scatter += v * v.t();
    }
  cv::Vec3d values;
  cv::eigen(scatter, values);
  return values[1] / std::max(cv::trace(scatter), 1.0);
}

cv::Point3d middleOf(const PointCloud& cloud) {
  cv::Point3d sum;
  for (const cv::Point3f& p : cloud.points) sum += cv::Point3d(p);
  return sum / static_cast<double>(cloud.points.size());
}

/// Frames in which a model is looked for.
struct Views {
  std::optional<std::size_t> seen, absent;
};

Views viewsOf(const Drive& drive, const std::vector<cv::Mat>& depths, std::size_t from,
              const PointCloud& model) {
  constexpr double least = 10, most = 45, best = 20;  // [degrees] between the directions of view
  constexpr double visible = 0.6;
  const cv::Affine3d own = *drive.pose(from);
  const cv::Point3d middle = own * middleOf(model);
  Views views;
  double difference = most;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const auto pose = drive.pose(i);
    if (!pose || i == from) continue;
    const cv::Point3d a = cv::Point3d(own.translation()) - middle,
                      b = cv::Point3d(pose->translation()) - middle;
    const double angle =
        std::acos(std::clamp(a.dot(b) / (cv::norm(a) * cv::norm(b)), -1.0, 1.0)) * 180 / std::numbers::pi;
    const bool better = angle >= least && angle <= most && std::abs(angle - best) < difference;
    if (!better && views.absent) continue;
    const double share = visibleShare(model, pose->inv() * own, depths[i], drive.camera(depths[i]));
    if (share == 0 && !views.absent) views.absent = i;
    if (better && share >= visible) {
      views.seen = i;
      difference = std::abs(angle - best);
    }
  }
  return views;
}

/// `count` of them, evenly spread.
std::vector<Piece> spread(std::vector<Piece> pieces, std::size_t count) {
  if (pieces.size() <= count) return pieces;
  std::vector<Piece> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(pieces[i * pieces.size() / count]);
  return chosen;
}

}  // namespace

std::vector<PointCloud> framesOfDrive(const DriveCasesOptions& options, std::size_t count) {
  const Drive drive(options);
  std::vector<PointCloud> frames;
  for (std::size_t i = 0; i < std::min(count, drive.size()); ++i)
    frames.push_back(drive.cloud(i * drive.size() / std::min(count, drive.size())));
  return frames;
}

ColorCases casesOfDrive(const DriveCasesOptions& options) {
  constexpr double flat = 0.05;
  const Drive drive(options);
  std::vector<cv::Mat> depths;
  for (std::size_t i = 0; i < drive.size(); ++i) depths.push_back(drive.depth(i));
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < drive.size(); i += options.every)
    if (drive.pose(i))
      for (Piece& piece : drive.pieces(i)) pieces.push_back(std::move(piece));

  ColorCases cases;
  std::map<std::size_t, std::size_t> scenes;
  const auto sceneOf = [&](std::size_t frame) {
    const auto [known, isNew] = scenes.emplace(frame, cases.scenes.size());
    if (isNew) cases.scenes.push_back({drive.nameOf(frame), drive.cloud(frame)});
    return known->second;
  };
  // More than wanted are tried, as not each has its views.
  for (const Piece& piece : spread(std::move(pieces), 4 * options.models)) {
    if (cases.models.size() == options.models) break;
    ColorCases::Model model{piece.name, "", pointsOf(drive.cloud(piece.frame), piece.pixels), {}};
    const Views views = viewsOf(drive, depths, piece.frame, model.cloud);
    if (!views.seen || !views.absent) continue;
    model.group = unevenness(model.cloud) < flat ? "flat" : "shaped";
    const std::size_t number = cases.models.size();
    const cv::Affine3d truth = drive.pose(*views.seen)->inv() * *drive.pose(piece.frame);
    // Pairs and absent models take turns in being first, so that halves of searches hold both.
    const ColorCases::Search present{sceneOf(*views.seen), number, {truth}, {}},
        absent{sceneOf(*views.absent), number, {}, {}};
    cases.searches.push_back(number % 2 == 0 ? present : absent);
    cases.searches.push_back(number % 2 == 0 ? absent : present);
    cases.models.push_back(std::move(model));
  }
  if (cases.searches.empty())
    throw Error(ErrorCode::insufficientData, fmt::format("{} shows no thing of {} pixels from two directions",
                                                         options.path.string(), options.minPixels));
  return cases;
}

}  // namespace estancia::experiments
