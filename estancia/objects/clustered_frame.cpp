// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/clustered_frame.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"

namespace estancia {
namespace {

class Crops final : public Sequence {
 public:
  Crops(const ObjectViews& views, const CropOptions& options) : views_(views), options_(options) {
    warnings_ = views.warnings();
    for (std::size_t i = 0; i < views.size(); ++i) {
      Frame frame;
      frame.name = views.view(i).name;
      frame.room = views.view(i).category;
      frames_.push_back(std::move(frame));
    }
  }

  std::string name() const override { return views_.name(); }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }

  cv::Mat image(std::size_t i) const override {
    const ObjectImage view = views_.image(i);
    if (!view.image.empty()) return cropObject(view.image, view.box, view.mask, options_);
    constexpr int size = 299;  // what the larger networks take
    return renderObject(views_.cloud(i), size, options_);
  }

 private:
  const ObjectViews& views_;
  CropOptions options_;
  std::vector<Frame> frames_;
};

}  // namespace

ClusteredFrame clusteredFrame(const cv::Mat& image, const cv::Mat& depth, const CameraIntrinsics& camera,
                              const ClusterOptions& options) {
  if (image.empty() || image.type() != CV_8UC3)
    throw Error(ErrorCode::invalidInput, "the image of a frame is not BGR with 8 bits; convert it");
  ClusteredFrame frame{image, depth, camera, findClusters(depth, camera, options, image)};
  frame.camera = camera.scaledTo(depth.cols, depth.rows);
  return frame;
}

void requireClusterable(const Sequence& sequence) {
  if (!sequence.hasDepth())
    fail(ErrorCode::invalidInput,
         "{} has no depth images, which segmentation needs; give a sequence with depth", sequence.name());
  if (!sequence.intrinsics())
    fail(ErrorCode::invalidInput, "{} has no camera intrinsics; give a file of fx fy cx cy by --intrinsics",
         sequence.name());
}

ImageAndDepth readImageAndDepth(const Sequence& sequence, std::size_t i) {
  ImageAndDepth read;
  inParallel(2, std::size_t{2}, [&](std::size_t which) {
    if (which == 0)
      read.image = sequence.image(i);
    else
      read.depth = sequence.depth(i);
  });
  constexpr double maxRatio = 1.05;  // ratio of the aspect ratios of images of the same view
  const double image = static_cast<double>(read.image.cols) / read.image.rows;
  const double depth = static_cast<double>(read.depth.cols) / read.depth.rows;
  if (image > maxRatio * depth || depth > maxRatio * image)
    fail(ErrorCode::mismatch,
         "an image of {} × {} and depth of {} × {} pixels do not show the same view; register depth to color",
         read.image.cols, read.image.rows, read.depth.cols, read.depth.rows);
  return read;
}

PointCloud cloudOf(const ClusteredFrame& frame, std::size_t i) {
  const Cluster& cluster = frame.clusters.clusters.at(i);
  const int columns = frame.depth.cols;
  const double sx = static_cast<double>(frame.image.cols) / columns;
  const double sy = static_cast<double>(frame.image.rows) / frame.depth.rows;
  PointCloud cloud;
  cloud.points.reserve(cluster.points.size());
  cloud.colors.reserve(cluster.points.size());
  for (const std::uint32_t pixel : cluster.points) {
    const int u = static_cast<int>(pixel) % columns, v = static_cast<int>(pixel) / columns;
    const float z = frame.depth.at<float>(v, u);
    cloud.points.emplace_back(static_cast<float>(frame.camera.slopeX(u) * z),
                              static_cast<float>(frame.camera.slopeY(v) * z), z);
    cloud.colors.push_back(
        frame.image.at<cv::Vec3b>(static_cast<int>((v + 0.5) * sy), static_cast<int>((u + 0.5) * sx)));
  }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

cv::Rect boxOf(const ClusteredFrame& frame, std::size_t i) {
  const cv::Rect& box = frame.clusters.clusters.at(i).box;
  const double sx = static_cast<double>(frame.image.cols) / frame.depth.cols;
  const double sy = static_cast<double>(frame.image.rows) / frame.depth.rows;
  const cv::Point low(static_cast<int>(box.x * sx), static_cast<int>(box.y * sy));
  const cv::Point high(static_cast<int>(std::ceil(box.br().x * sx)),
                       static_cast<int>(std::ceil(box.br().y * sy)));
  return cv::Rect(low, high) & cv::Rect({}, frame.image.size());
}

cv::Mat maskOf(const ClusteredFrame& frame, std::size_t i) {
  cv::Mat mask = cv::Mat::zeros(frame.depth.size(), CV_8U);
  for (const std::uint32_t pixel : frame.clusters.clusters.at(i).points) mask.data[pixel] = 255;
  cv::resize(mask, mask, frame.image.size(), 0, 0, cv::INTER_NEAREST);
  return mask;
}

cv::Mat cropObject(const ClusteredFrame& frame, std::size_t i, const CropOptions& options) {
  const bool kept = options.background == CropOptions::Background::kept;
  return cropObject(frame.image, boxOf(frame, i), kept ? cv::Mat() : maskOf(frame, i), options);
}

std::unique_ptr<Sequence> cropsOf(const ObjectViews& views, const CropOptions& options) {
  return std::make_unique<Crops>(views, options);
}

}  // namespace estancia
