// What the readers of the single formats of object views share; of no use to others.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/io/object_views.hpp"

namespace estancia::io {

/// Views that are all listed when they are opened.
class ListedObjectViews : public ObjectViews {
 public:
  std::string name() const final { return name_; }
  std::size_t size() const final { return views_.size(); }
  const ObjectView& view(std::size_t i) const final { return views_.at(i); }

 protected:
  ListedObjectViews(std::string name, std::size_t leastPoints)
      : leastPoints_(leastPoints), name_(std::move(name)) {}

  /// Throws Error on a name that is there already.
  void add(ObjectView view);
  void warn(std::string sentence) { warnings_.push_back(std::move(sentence)); }

  /// Throws Error, naming the view, when too few of the points are finite.
  PointCloud enough(PointCloud cloud, const std::string& view) const;

  std::size_t leastPoints_;

 private:
  std::string name_;
  std::vector<ObjectView> views_;
  std::unordered_set<std::string> names_;
};

using OpenedViews = std::unique_ptr<ObjectViews>;

// One pair a format: does `folder` look like it, and open it. Each lives in the file of its name.
bool isSampleViews(const std::filesystem::path& folder);
OpenedViews openSampleViews(const std::filesystem::path& folder, const ObjectViewsOptions& options);
bool isNyuObjects(const std::filesystem::path& folder);
OpenedViews openNyuObjects(const std::filesystem::path& folder, const ObjectViewsOptions& options);
bool isWashington(const std::filesystem::path& folder);
OpenedViews openWashington(const std::filesystem::path& folder, const ObjectViewsOptions& options);
bool isCloudViews(const std::filesystem::path& folder);
OpenedViews openCloudViews(const std::filesystem::path& folder, const ObjectViewsOptions& options);

/// The folders directly inside `folder` whose names do not begin with a dot, in natural order; at most
/// 100,000. Throws Error when it cannot be read or holds more.
std::vector<std::filesystem::path> foldersIn(const std::filesystem::path& folder);

/// Sentences that are the same but for one name become one: how many, and the first.
class LeftOut {
 public:
  void add(std::string why);
  bool none() const { return count_ == 0; }
  /// "3 of 20 WHAT are left out (the first: WHY)".
  std::string sentence(std::size_t all, const std::string& what) const;

 private:
  std::size_t count_ = 0;
  std::string first_;
};

/// An image of marks: one channel of 8 bits, or several equal ones. Throws Error on anything else.
cv::Mat readMarks(const std::filesystem::path& file);

/// The points of the marked pixels in `box`, with colors: `depth` (CV_32F, meters), `mask` (CV_8U) and
/// `image` (BGR) are of one size, and `camera` is theirs. Throws Error when sizes differ, naming `view`.
PointCloud pointsBehind(const cv::Mat& image, const cv::Mat& depth, const cv::Mat& mask, const cv::Rect& box,
                        const CameraIntrinsics& camera, const std::string& view);

}  // namespace estancia::io
