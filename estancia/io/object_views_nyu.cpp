// The objects of NYU Depth V2's labeled frames (Silberman et al., ECCV 2012): beside what nyu.cpp reads,
// label/0000.png with the class of every pixel, and classes40.txt with their names, `INDEX NAME` or `NAME` a
// line (the 40 classes of Gupta et al., CVPR 2013). Instances are not told: one is a connected component of a
// class, so chairs that touch are one, and each is seen once. Left out are components too small to tell a
// shape by, and classes that are no things.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "estancia/core/cores.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/formats.hpp"
#include "estancia/io/object_view_formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// What encloses, and what the 40 classes lump together.
constexpr const char* kNoThings[] = {"wall",           "floor",          "ceiling",
                                     "otherstructure", "otherfurniture", "otherprop"};

// Shares of the image: 900 pixels of 320 × 240, 600 of them with depth; what comes within 6 pixels of the
// edge is cut by it, as published images have no labels in a frame of 2 to 5 pixels.
constexpr double kLeastArea = 900.0 / (320 * 240), kLeastDepth = 600.0 / (320 * 240), kEdge = 6.0 / 320;

/// The class of each mark; "" where it is no thing.
std::array<std::string, 256> readClasses(const fs::path& file) {
  std::array<std::string, 256> classes;
  std::set<std::string> seen;
  std::size_t next = 0;
  for (const std::string& line : readLines(file)) {
    const auto words = wordsOf(line);
    if (words.empty()) continue;
    const std::string where = fmt::format("{}: \"{}\"", printable(file.string()), printable(line));
    if (next == classes.size()) throw Error(fmt::format("{}: more than {} classes", where, classes.size()));
    if (words.size() > 2 || (words.size() == 2 && toNumber(words[0]) != static_cast<double>(next)))
      throw Error(fmt::format("{} is not the class {}; write `{} NAME`", where, next, next));
    const std::string name = printable(words.back());
    if (!seen.insert(name).second) throw Error(fmt::format("{} is there twice", where));
    if (std::ranges::find(kNoThings, name) == std::end(kNoThings)) classes[next] = name;
    ++next;
  }
  if (next == 0) throw Error(fmt::format("{}: names no class", printable(file.string())));
  return classes;
}

/// A component: any of its pixels finds it again.
struct Component {
  cv::Point pixel;
  cv::Rect box;
  uchar mark = 0;
  bool atEdge = false;
};

/// Fills the component of equal marks around `pixel` in `mask`, which is a pixel larger on every side.
Component fill(const cv::Mat& marks, cv::Mat& mask, const cv::Point& pixel, int value) {
  Component component{pixel, {}, marks.at<uchar>(pixel)};
  cv::Mat unchanged = marks;
  constexpr int eight = 8, byte = 8;
  cv::floodFill(unchanged, mask, pixel, {}, &component.box, {}, {},
                eight | cv::FLOODFILL_MASK_ONLY | value << byte);
  const cv::Rect& box = component.box;
  const double edge = kEdge * marks.cols;
  component.atEdge =
      box.x < edge || box.y < edge || marks.cols - box.br().x < edge || marks.rows - box.br().y < edge;
  return component;
}

std::vector<Component> componentsOf(const cv::Mat& marks, const cv::Mat& depth,
                                    const std::array<std::string, 256>& classes, std::size_t leastPoints) {
  const auto area = static_cast<double>(marks.total());
  const double leastDepth = std::max(kLeastDepth * area, static_cast<double>(leastPoints));
  std::vector<Component> found;
  cv::Mat mask = cv::Mat::zeros(marks.rows + 2, marks.cols + 2, CV_8U);
  for (int v = 0; v < marks.rows; ++v)
    for (int u = 0; u < marks.cols; ++u) {
      if (classes[marks.at<uchar>(v, u)].empty() || mask.at<uchar>(v + 1, u + 1) != 0) continue;
      constexpr int now = 1, before = 2;
      const Component component = fill(marks, mask, {u, v}, now);
      cv::Mat part =
          mask({component.box.x + 1, component.box.y + 1, component.box.width, component.box.height});
      const cv::Mat own = part == now;
      if (cv::countNonZero(own) >= kLeastArea * area &&
          cv::countNonZero(own & (depth(component.box) > 0)) >= leastDepth)
        found.push_back(component);
      part.setTo(before, own);
    }
  return found;
}

class NyuObjects final : public ListedObjectViews {
 public:
  NyuObjects(const fs::path& folder, const ObjectViewsOptions& options)
      : ListedObjectViews(nameOf(folder), options.leastPoints), frames_(openNyu(folder, {})) {
    warnings_ = frames_->warnings();
    const auto classes = readClasses(folder / "classes40.txt");
    const std::size_t count = frames_->size();
    std::vector<std::vector<Component>> components(count);
    std::vector<std::string> problems(count);
    for (std::size_t i = 0; i < count; ++i)
      labels_.push_back(folder / "label" / fs::path(frames_->frame(i).name).stem().concat(".png"));
    inParallel(count, static_cast<std::size_t>(usableCores()), [&](std::size_t i) {
      try {
        const cv::Mat marks = readMarks(labels_[i]), depth = frames_->depth(i);
        if (marks.size() != depth.size())
          throw Error(fmt::format("{}: {} × {} pixels, depth has {} × {}", printable(labels_[i].string()),
                                  marks.cols, marks.rows, depth.cols, depth.rows));
        components[i] = componentsOf(marks, depth, classes, leastPoints_);
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
    const cv::Mat image = frames_->image(place.frame), marks = readMarks(labels_[place.frame]);
    if (image.size() != marks.size())
      throw Error(fmt::format("{}: {} × {} pixels, its image has {} × {}",
                              printable(labels_[place.frame].string()), marks.cols, marks.rows, image.cols,
                              image.rows));
    cv::Mat mask = cv::Mat::zeros(marks.rows + 2, marks.cols + 2, CV_8U);
    const Component& component = place.component;
    constexpr int thing = 255;
    if (!cv::Rect({}, marks.size()).contains(component.pixel) ||
        fill(marks, mask, component.pixel, thing).box != component.box)
      throw Error(fmt::format("{}: changed since it was opened", printable(labels_[place.frame].string())));
    return {image, component.box, mask({1, 1, marks.cols, marks.rows}).clone()};
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
      const std::string& category = classes[component.mark];
      const std::string name =
          fmt::format("{}_{}_{}", fs::path(image).stem().string(), category, ++numbers[component.mark]);
      add({name, name, category, frames_->splits()[frame], image, false, component.atEdge});
      places_.push_back({frame, component});
    }
  }

  io::Opened frames_;
  std::vector<fs::path> labels_;  ///< of each frame
  std::vector<Place> places_;     ///< of each view
};

}  // namespace

bool isNyuObjects(const fs::path& folder) {
  return fs::is_regular_file(folder / "classes40.txt") && fs::is_directory(folder / "label") && isNyu(folder);
}

OpenedViews openNyuObjects(const fs::path& folder, const ObjectViewsOptions& options) {
  return std::make_unique<NyuObjects>(folder, options);
}

}  // namespace estancia::io
