// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/object_views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/readers/object_view_formats.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// In order of detection.
std::vector<io::ViewFormat> viewFormats() {
  return {io::sampleViews, io::nyuObjects, io::washingtonViews, io::cloudViews};
}

}  // namespace

namespace io {

void ListedObjectViews::add(ObjectView view) {
  if (!names_.insert(view.name).second)
    fail(ErrorCode::malformedFile, "{}: two views are named {}; rename or remove one", name_, view.name);
  entries_.push_back(std::move(view));
}

PointCloud ListedObjectViews::enough(PointCloud cloud, const std::string& view) const {
  const auto finite =
      static_cast<std::size_t>(std::count_if(cloud.points.begin(), cloud.points.end(), isFinite));
  const std::size_t min = std::max<std::size_t>(minPoints_, 1);
  if (finite < min)
    fail(ErrorCode::insufficientData, "{}: {} points; at least {} are needed", view, finite, min);
  return cloud;
}

void LeftOut::add(std::string why) {
  if (count_++ == 0) first_ = std::move(why);
}

std::string LeftOut::sentence(std::size_t all, const std::string& what) const {
  return fmt::format("{} of {} {} are left out (first: {})", count_, all, what, first_);
}

cv::Mat readLabelImage(const fs::path& file) {
  const cv::Mat labels = onlyChannel(decodeImage(file));
  if (labels.empty() || labels.depth() != CV_8U)
    fail(ErrorCode::unsupportedFile,
         "{}: a label image must be gray with 8 bits; save it without palette and colors", printable(file));
  return labels;
}

PointCloud pointsBehind(const cv::Mat& image, const cv::Mat& depth, const cv::Mat& mask, const cv::Rect& box,
                        const CameraIntrinsics& camera, const std::string& view) {
  if (image.size() != depth.size() || mask.size() != depth.size())
    fail(ErrorCode::mismatch,
         "{}: image ({} × {}), depth ({} × {}) and mask ({} × {}) differ in size; one of them belongs to "
         "another view",
         view, image.cols, image.rows, depth.cols, depth.rows, mask.cols, mask.rows);
  CameraIntrinsics part = camera.scaledTo(depth.cols, depth.rows);
  part.cx -= box.x;
  part.cy -= box.y;
  part.width = box.width;
  part.height = box.height;
  const PointCloud all = backProject(depth(box), part);
  PointCloud cloud;
  for (int v = 0; v < box.height; ++v)
    for (int u = 0; u < box.width; ++u) {
      const cv::Point pixel(box.x + u, box.y + v);
      const cv::Point3f& point =
          all.points[static_cast<std::size_t>(v) * all.width + static_cast<std::size_t>(u)];
      if (mask.at<uchar>(pixel) == 0 || !isFinite(point)) continue;
      cloud.points.push_back(point);
      cloud.colors.push_back(image.at<cv::Vec3b>(pixel));
    }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

}  // namespace io

OptionGroup declare(ObjectViewsOptions& o) {
  OptionGroup group("object-views", "How to open a folder of object views.");
  group.add("type", &o.type, "Format of the folder").choices(io::typesWithAuto(viewFormats()));
  group.add("min-points", &o.minPoints, "Views with fewer points are left out")
      .range(0, 1e9)
      .why("raise it when shapes of few points are described badly");
  return group;
}

std::unique_ptr<ObjectViews> openObjectViews(const fs::path& path, const ObjectViewsOptions& options) {
  validate(options);
  const std::string name = io::printable(path);
  std::error_code error;
  if (!fs::is_directory(path, error))
    fail(ErrorCode::fileNotFound, "{}: no such folder of object views", name);
  auto views = io::opened(path, [&] {
    const std::vector<io::ViewFormat> formats = viewFormats();
    const auto* format = io::findFormat(formats, path, options.type);
    if (format != nullptr) return format->open(path, options);
    std::string layouts;
    for (const auto& known : formats) layouts += fmt::format("; {}: {}", known.type, known.explanation);
    fail(ErrorCode::unsupportedFile,
         "{}: no object views in this folder; make some with `estancia objects collect`. Known formats{}",
         name, layouts.replace(0, 1, ":"));
  });
  if (views->size() == 0) {
    std::string why;
    for (const std::string& warning : views->warnings()) why += fmt::format("; {}", warning);
    fail(ErrorCode::insufficientData, "{}: no usable view of an object{}", name, why);
  }
  return views;
}

Choices objectViewTypes() {
  return io::typesOf(viewFormats());
}

}  // namespace estancia
