// The objects of NYU Depth V2's labeled frames (Silberman et al., ECCV 2012): beside what nyu.cpp reads,
// label/0000.png with the class of every pixel, and classes40.txt with their names, `INDEX NAME` or `NAME`
// per line (the 40 classes of Gupta et al., CVPR 2013). The data set has no instances: an instance is a
// connected component of a class, so touching chairs are one, and each is seen once. Small components and
// classes that are no objects are left out.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "estancia/core/cores.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/readers/formats.hpp"
#include "estancia/readers/object_view_formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// Room structure and collective classes.
constexpr const char* noObjects[] = {"wall",           "floor",          "ceiling",
                                     "otherstructure", "otherfurniture", "otherprop"};

// Fractions of the image: 900 pixels of 320 × 240, 600 of them with depth; components within 6 pixels of the
// border are cut by it, as published images have no labels in a margin of 2 to 5 pixels.
constexpr double minAreaShare = 900.0 / (320 * 240), minDepthShare = 600.0 / (320 * 240),
                 borderShare = 6.0 / 320;

/// The class of each label; "" where it is no object.
std::array<std::string, 256> readClasses(const fs::path& file) {
  std::array<std::string, 256> classes;
  std::set<std::string> seen;
  std::size_t next = 0;
  for (const std::string& line : readLines(file)) {
    const auto words = wordsOf(line);
    if (words.empty()) continue;
    const std::string where = fmt::format("{}: \"{}\"", printable(file), printable(line));
    if (next == classes.size()) fail(ErrorCode::tooLarge, "{}: more than {} classes", where, classes.size());
    if (words.size() > 2 || (words.size() == 2 && toNumber(words[0]) != static_cast<double>(next)))
      fail(ErrorCode::malformedFile, "{}: expected class {}; write `{} NAME`", where, next, next);
    const std::string name = printable(words.back());
    if (!seen.insert(name).second) fail(ErrorCode::malformedFile, "{}: repeated class", where);
    if (std::ranges::find(noObjects, name) == std::end(noObjects)) classes[next] = name;
    ++next;
  }
  if (next == 0) fail(ErrorCode::insufficientData, "{}: no classes", printable(file));
  return classes;
}

/// A connected component, identified by one of its pixels.
struct Component {
  cv::Point pixel;
  cv::Rect box;
  uchar label = 0;
  bool atBorder = false;
};

/// Fills the component of equal labels around `pixel` in `mask`, which is one pixel larger on every side.
Component fill(const cv::Mat& labels, cv::Mat& mask, const cv::Point& pixel, int value) {
  Component component{pixel, {}, labels.at<uchar>(pixel)};
  cv::Mat unchanged = labels;
  cv::floodFill(unchanged, mask, pixel, {}, &component.box, {}, {},
                8 | cv::FLOODFILL_MASK_ONLY | value << 8);  // 8 neighbors, and the value in the second byte
  const cv::Rect& box = component.box;
  const double edge = borderShare * labels.cols;
  component.atBorder =
      box.x < edge || box.y < edge || labels.cols - box.br().x < edge || labels.rows - box.br().y < edge;
  return component;
}

std::vector<Component> componentsOf(const cv::Mat& labels, const cv::Mat& depth,
                                    const std::array<std::string, 256>& classes, std::size_t minPoints) {
  const auto area = static_cast<double>(labels.total());
  const double minDepth = std::max(minDepthShare * area, static_cast<double>(minPoints));
  std::vector<Component> found;
  cv::Mat mask = cv::Mat::zeros(labels.rows + 2, labels.cols + 2, CV_8U);
  for (int v = 0; v < labels.rows; ++v)
    for (int u = 0; u < labels.cols; ++u) {
      if (classes[labels.at<uchar>(v, u)].empty() || mask.at<uchar>(v + 1, u + 1) != 0) continue;
      constexpr int now = 1, before = 2;
      const Component component = fill(labels, mask, {u, v}, now);
      cv::Mat part =
          mask({component.box.x + 1, component.box.y + 1, component.box.width, component.box.height});
      const cv::Mat own = part == now;
      if (cv::countNonZero(own) >= minAreaShare * area &&
          cv::countNonZero(own & (depth(component.box) > 0)) >= minDepth)
        found.push_back(component);
      part.setTo(before, own);
    }
  return found;
}

class NyuObjects final : public ListedObjectViews {
 public:
  NyuObjects(const fs::path& folder, const ObjectViewsOptions& options)
      : ListedObjectViews(nameOf(folder), options.minPoints), frames_(nyuFormat.open(folder, {})) {
    warnings_ = frames_->warnings();
    const auto classes = readClasses(folder / "classes40.txt");
    const std::size_t count = frames_->size();
    std::vector<std::vector<Component>> components(count);
    std::vector<std::string> problems(count);
    for (std::size_t i = 0; i < count; ++i)
      labels_.push_back(folder / "label" / fs::path(frames_->frame(i).name).stem().concat(".png"));
    inParallel(count, static_cast<std::size_t>(usableCores()), [&](std::size_t i) {
      try {
        const cv::Mat labels = readLabelImage(labels_[i]), depth = frames_->depth(i);
        if (labels.size() != depth.size())
          fail(ErrorCode::mismatch, "{}: {} × {} pixels, but depth has {} × {}", printable(labels_[i]),
               labels.cols, labels.rows, depth.cols, depth.rows);
        components[i] = componentsOf(labels, depth, classes, minPoints_);
      } catch (...) {
        problems[i] = frameFailure(frames_->frame(i).name).what();
      }
    });
    LeftOut leftOut;
    for (std::size_t i = 0; i < count; ++i) {
      if (!problems[i].empty()) leftOut.add(problems[i]);
      list(i, components[i], classes);
    }
    if (!leftOut.none()) warn(leftOut.sentence(count, "frames"));
  }

  PointCloud cloud(std::size_t i) const override {
    const Place& place = places_.at(i);
    const cv::Mat depth = frames_->depth(place.frame);
    const ObjectImage seen = image(i);
    return enough(pointsBehind(seen.image, depth, seen.mask, seen.box, *frames_->intrinsics(), view(i).name),
                  view(i).name);
  }

  ObjectImage image(std::size_t i) const override {
    const Place& place = places_.at(i);
    const cv::Mat image = frames_->image(place.frame), labels = readLabelImage(labels_[place.frame]);
    if (image.size() != labels.size())
      fail(ErrorCode::mismatch, "{}: {} × {} pixels, but the image has {} × {}",
           printable(labels_[place.frame]), labels.cols, labels.rows, image.cols, image.rows);
    cv::Mat mask = cv::Mat::zeros(labels.rows + 2, labels.cols + 2, CV_8U);
    const Component& component = place.component;
    if (!cv::Rect({}, labels.size()).contains(component.pixel) ||
        fill(labels, mask, component.pixel, 255).box != component.box)
      fail(ErrorCode::invalidState, "{}: changed since it was opened; open the folder again",
           printable(labels_[place.frame]));
    return {image, component.box, mask({1, 1, labels.cols, labels.rows}).clone()};
  }

 private:
  struct Place {
    std::size_t frame;
    Component component;
  };

  void list(std::size_t frame, const std::vector<Component>& components,
            const std::array<std::string, 256>& classes) {
    const std::string& image = frames_->frame(frame).name;
    std::array<int, 256> numbers = {};
    for (const Component& component : components) {
      const std::string& category = classes[component.label];
      const std::string name =
          fmt::format("{}_{}_{}", fs::path(image).stem().string(), category, ++numbers[component.label]);
      add({.name = name,
           .instance = name,
           .category = category,
           .split = frames_->splits()[frame],
           .frame = image,
           .atBorder = component.atBorder});
      places_.push_back({frame, component});
    }
  }

  io::Opened frames_;
  std::vector<fs::path> labels_;  ///< labels of each frame
  std::vector<Place> places_;     ///< place of each view
};

bool isNyuObjects(const fs::path& folder) {
  return fs::is_regular_file(folder / "classes40.txt") && fs::is_directory(folder / "label") &&
         nyuFormat.recognizes(folder);
}

}  // namespace

const ViewFormat nyuObjects{
    "nyu", "NYU Depth V2: rgb/, depth/, label/ with the same names, classes40.txt, scenes.csv", isNyuObjects,
    openViewsAs<NyuObjects>};

}  // namespace estancia::io
