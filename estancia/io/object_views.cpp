#include "estancia/io/object_views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/core/error.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/image_file.hpp"
#include "estancia/io/object_view_formats.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

struct Format {
  const char* type;
  const char* explanation;
  bool (*recognizes)(const fs::path& folder);
  io::OpenedViews (*open)(const fs::path& folder, const ObjectViewsOptions& options);
};

/// In the order in which they are asked.
constexpr Format kFormats[] = {
    {"samples", "what `estancia objects collect` gathered: samples.csv, images/, clouds/", io::isSampleViews,
     io::openSampleViews},
    {"nyu", "NYU Depth V2: rgb/, depth/, label/ of equal names, classes40.txt, scenes.csv", io::isNyuObjects,
     io::openNyuObjects},
    {"washington", "RGB-D Object Dataset: CATEGORY/CATEGORY_1/CATEGORY_1_1_1_crop.png with depth and mask",
     io::isWashington, io::openWashington},
    {"clouds", "a folder a category: CATEGORY/VIEW.pcd (.ply), or CATEGORY/INSTANCE/VIEW.pcd",
     io::isCloudViews, io::openCloudViews},
};

const Format& formatOf(const fs::path& folder, const std::string& type) {
  std::string known = "auto";
  for (const Format& format : kFormats) {
    if (type == format.type || (type == "auto" && format.recognizes(folder))) return format;
    known += fmt::format(", {}", format.type);
  }
  if (type != "auto")
    throw Error(fmt::format("unknown type of object views \"{}\"; known are {}", io::printable(type), known));
  std::string layouts;
  for (const Format& format : kFormats) layouts += fmt::format("; {}: {}", format.type, format.explanation);
  throw Error(
      fmt::format("{}: no views of objects in this folder; `estancia objects collect` makes some of a "
                  "sequence. Known are{}",
                  io::printable(folder.string()), layouts.substr(1)));
}

}  // namespace

namespace io {

void ListedObjectViews::add(ObjectView view) {
  if (!names_.insert(view.name).second)
    throw Error(fmt::format("{}: two views are called {}; rename or remove one", name_, view.name));
  views_.push_back(std::move(view));
}

PointCloud ListedObjectViews::enough(PointCloud cloud, const std::string& view) const {
  const auto finite =
      static_cast<std::size_t>(std::count_if(cloud.points.begin(), cloud.points.end(), isFinite));
  if (finite < std::max<std::size_t>(leastPoints_, 1))
    throw Error(fmt::format("{}: {} points are too few to tell a shape by; at least {} are asked for", view,
                            finite, std::max<std::size_t>(leastPoints_, 1)));
  return cloud;
}

std::vector<fs::path> foldersIn(const fs::path& folder) {
  constexpr std::size_t most = 100000;
  std::error_code error;
  fs::directory_iterator entries(folder, error);
  std::vector<fs::path> found;
  for (; !error && entries != fs::directory_iterator(); entries.increment(error)) {
    std::error_code unreadable;  // a dangling or circular link is no folder
    if (entries->path().filename().native().starts_with('.') || !entries->is_directory(unreadable)) continue;
    if (found.size() == most)
      throw Error(fmt::format("{}: more than {} folders", printable(folder.string()), most));
    found.push_back(entries->path());
  }
  if (error)
    throw Error(fmt::format("cannot read the folder {}: {}", printable(folder.string()), error.message()));
  std::ranges::sort(found, [](const fs::path& a, const fs::path& b) {
    return naturalLess(a.filename().native(), b.filename().native());
  });
  return found;
}

void LeftOut::add(std::string why) {
  if (count_++ == 0) first_ = std::move(why);
}

std::string LeftOut::sentence(std::size_t all, const std::string& what) const {
  return fmt::format("{} of {} {} are left out (the first: {})", count_, all, what, first_);
}

cv::Mat readMarks(const fs::path& file) {
  const cv::Mat read = decodeImage(file, cv::IMREAD_UNCHANGED);
  std::vector<cv::Mat> channels;
  cv::split(read, channels);
  const bool gray =
      std::all_of(channels.begin(), channels.begin() + std::min(read.channels(), 3),
                  [&](const cv::Mat& c) { return cv::norm(c, channels[0], cv::NORM_INF) == 0; });
  if (read.depth() != CV_8U || !gray)
    throw Error(fmt::format("{}: marks are gray and of 8 bits; save it so, without palette or colors",
                            printable(file.string())));
  return channels[0];
}

PointCloud pointsBehind(const cv::Mat& image, const cv::Mat& depth, const cv::Mat& mask, const cv::Rect& box,
                        const CameraIntrinsics& camera, const std::string& view) {
  if (image.size() != depth.size() || mask.size() != depth.size())
    throw Error(
        fmt::format("{}: image ({} × {}), depth ({} × {}) and mask ({} × {}) differ in size; one "
                    "of them belongs to another view",
                    view, image.cols, image.rows, depth.cols, depth.rows, mask.cols, mask.rows));
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

std::unique_ptr<ObjectViews> openObjectViews(const fs::path& path, const ObjectViewsOptions& options) {
  const std::string name = io::printable(path.string());
  std::error_code error;
  if (!fs::is_directory(path, error))
    throw Error(fmt::format("{}: there is no such folder; views of objects lie in one", name));
  auto views = [&] {
    try {
      return formatOf(path, options.type).open(path, options);
    } catch (const fs::filesystem_error& e) {
      throw Error(fmt::format("{}: cannot be read ({})", name, e.code().message()));
    } catch (const cv::Exception& e) {
      throw Error(fmt::format("{}: OpenCV cannot read it ({})", name, io::printable(e.err)));
    }
  }();
  if (views->size() == 0) {
    std::string why;
    for (const std::string& warning : views->warnings()) why += fmt::format("; {}", warning);
    throw Error(fmt::format("{}: no view of an object can be used{}", name, why));
  }
  return views;
}

std::vector<std::pair<std::string, std::string>> objectViewTypes() {
  std::vector<std::pair<std::string, std::string>> types;
  for (const Format& format : kFormats) types.emplace_back(format.type, format.explanation);
  return types;
}

}  // namespace estancia
