// The RGB-D Object Dataset (Lai, Bo, Ren, Fox: A large-scale hierarchical multi-view RGB-D object dataset,
// ICRA 2011), as published: CATEGORY/CATEGORY_N/CATEGORY_N_VIDEO_FRAME_crop.png is the image around an
// object, _depthcrop.png its depth (16 bits, millimeters), _maskcrop.png its mask, and _loc.txt the first
// pixel "x,y" of the crop in the 640 × 480 image, counted from 1. Categories contain underscores
// ("bell_pepper"), so names are parsed from the right. Videos 1, 2 and 4 look down by 30°, 45° and 60°.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <unordered_set>

#include "estancia/files/camera_file.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/readers/formats.hpp"
#include "estancia/readers/object_view_formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// From the data set's depthToCloud.m.
constexpr CameraIntrinsics washingtonCamera = {640, 480, 570.3, 570.3, 320, 240};
constexpr double washingtonScale = 1000;
constexpr const char* crop = "_crop.png";
constexpr const char* beside[] = {"_depthcrop.png", "_maskcrop.png", "_loc.txt"};

bool isNumber(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// Whether `name` is PREFIX_NUMBER.
bool isNumbered(std::string_view name, std::string_view prefix) {
  return name.size() > prefix.size() + 1 && name.starts_with(prefix) && name[prefix.size()] == '_' &&
         isNumber(name.substr(prefix.size() + 1));
}

/// Whether `name` is INSTANCE_VIDEO_FRAME.
bool isFrameOf(std::string_view name, std::string_view instance) {
  const auto last = name.rfind('_');
  return last != std::string_view::npos && isNumber(name.substr(last + 1)) &&
         isNumbered(name.substr(0, last), instance);
}

/// The first pixel of the crop in the image, from 0.
cv::Point readOrigin(const fs::path& file) {
  std::vector<std::string> lines = readLines(file);
  std::vector<double> numbers;
  for (std::string& line : lines) {
    std::ranges::replace(line, ',', ' ');
    for (const std::string_view word : wordsOf(line)) numbers.push_back(toNumber(word).value_or(0));
  }
  constexpr double max = 65536;
  if (numbers.size() != 2 || !(numbers[0] >= 1 && numbers[1] >= 1 && numbers[0] < max && numbers[1] < max))
    fail(ErrorCode::malformedFile, "{}: not the origin of a crop, `x,y` from 1", printable(file));
  return {static_cast<int>(numbers[0]) - 1, static_cast<int>(numbers[1]) - 1};
}

class Washington final : public ListedObjectViews {
 public:
  Washington(const fs::path& folder, const ObjectViewsOptions& options)
      : ListedObjectViews(nameOf(folder), options.minPoints), camera_(washingtonCamera) {
    if (const fs::path file = findIntrinsics(folder); !file.empty()) {
      camera_ = readIntrinsics(file);
      if (camera_.width == 0)
        std::tie(camera_.width, camera_.height) = std::pair(washingtonCamera.width, washingtonCamera.height);
    }
    std::size_t all = 0;
    LeftOut leftOut;
    for (const fs::path& category : foldersIn(folder))
      for (const fs::path& instance : foldersIn(category))
        if (isNumbered(instance.filename().string(), category.filename().string()))
          all += list(instance, category.filename().string(), leftOut);
    if (!leftOut.none()) warn(leftOut.sentence(all, "views"));
  }

  PointCloud cloud(std::size_t i) const override {
    const ObjectImage seen = image(i);
    const std::string& stem = stems_.at(i);
    const cv::Mat depth = readDepth(stem + beside[0], washingtonScale);
    const fs::path file = stem + beside[2];
    const cv::Point origin = readOrigin(file);
    if (origin.x + depth.cols > camera_.width || origin.y + depth.rows > camera_.height)
      fail(ErrorCode::mismatch, "{}: {} × {} pixels at ({}, {}) exceed the camera's {} × {}", printable(file),
           depth.cols, depth.rows, origin.x + 1, origin.y + 1, camera_.width, camera_.height);
    const CameraIntrinsics own{
        depth.cols, depth.rows, camera_.fx, camera_.fy, camera_.cx - origin.x, camera_.cy - origin.y};
    return enough(pointsBehind(seen.image, depth, seen.mask, seen.box, own, view(i).name), view(i).name);
  }

  ObjectImage image(std::size_t i) const override {
    const std::string& stem = stems_.at(i);
    ObjectImage seen{readImage(stem + crop), {}, readLabelImage(stem + beside[1])};
    if (seen.image.size() != seen.mask.size())
      fail(ErrorCode::mismatch, "{}{}: {} × {} pixels, but the image has {} × {}", printable(stem), beside[1],
           seen.mask.cols, seen.mask.rows, seen.image.cols, seen.image.rows);
    seen.box = cv::boundingRect(seen.mask);
    if (seen.box.empty()) fail(ErrorCode::malformedFile, "{}{}: empty mask", printable(stem), beside[1]);
    return seen;
  }

 private:
  /// Adds the complete views of one instance; returns the number of all its views.
  std::size_t list(const fs::path& folder, const std::string& category, LeftOut& leftOut) {
    const std::string instance = folder.filename().string();
    const std::vector<fs::path> files = filesIn(folder, {".png", ".txt"});
    std::unordered_set<std::string> there;
    for (const fs::path& file : files) there.insert(file.filename().string());
    std::size_t count = 0;
    for (const fs::path& file : files) {
      std::string stem = file.filename().string();
      if (!stem.ends_with(crop)) continue;
      stem.resize(stem.size() - std::string_view(crop).size());
      if (!isFrameOf(stem, instance)) continue;
      ++count;
      const auto missing =
          std::ranges::find_if(beside, [&](const char* end) { return !there.contains(stem + end); });
      if (missing != std::end(beside)) {
        leftOut.add(fmt::format("{}{} is missing", printable(stem), *missing));
        continue;
      }
      const std::string name = printable(stem);
      stems_.push_back((folder / stem).string());
      add({.name = name, .instance = printable(instance), .category = printable(category), .frame = name});
    }
    return count;
  }

  CameraIntrinsics camera_;
  std::vector<std::string> stems_;  ///< stems of each view's files
};

bool isWashington(const fs::path& folder) {
  for (const fs::path& category : foldersIn(folder))
    for (const fs::path& instance : foldersIn(category)) {
      const std::string name = instance.filename().string();
      if (!isNumbered(name, category.filename().string())) continue;
      for (const fs::path& file : filesIn(instance, {crop}))
        if (file.filename().string().starts_with(name + "_")) return true;
    }
  return false;
}

}  // namespace

const ViewFormat washingtonViews{
    "washington", "RGB-D Object Dataset: CATEGORY/CATEGORY_1/CATEGORY_1_1_1_crop.png with depth and mask",
    isWashington, openViewsAs<Washington>};

}  // namespace estancia::io
