// Object view formats: one reader per data set, and what they share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <unordered_set>
#include <utility>

#include "estancia/core/camera.hpp"
#include "estancia/readers/object_views.hpp"
#include "estancia/sequences/listed_sequence.hpp"

namespace estancia::io {

/// Views that are all listed when they are opened.
class ListedObjectViews : public Listed<ObjectViews, ObjectView> {
 public:
  const ObjectView& view(std::size_t i) const final { return entries_.at(i); }

 protected:
  ListedObjectViews(std::string name, std::size_t minPoints)
      : Listed(std::move(name)), minPoints_(minPoints) {}

  /// Throws Error on a repeated name.
  void add(ObjectView view);

  /// The cloud itself. Throws Error, naming the view, when too few of the points are finite.
  PointCloud enough(PointCloud cloud, const std::string& view) const;

  std::size_t minPoints_;

 private:
  std::unordered_set<std::string> names_;
};

using OpenedViews = std::unique_ptr<ObjectViews>;

using ViewFormat = Format<OpenedViews, ObjectViewsOptions>;
template <class OneFormat>
OpenedViews openViewsAs(const std::filesystem::path& folder, const ObjectViewsOptions& options) {
  return std::make_unique<OneFormat>(folder, options);
}

// One per format, in the file of its name.
extern const ViewFormat sampleViews, nyuObjects, washingtonViews, cloudViews;

/// Counts equal problems and keeps the first.
class LeftOut {
 public:
  void add(std::string why);
  bool none() const { return count_ == 0; }
  /// "3 of 20 WHAT are left out (first: WHY)".
  std::string sentence(std::size_t all, const std::string& what) const;

 private:
  std::size_t count_ = 0;
  std::string first_;
};

/// A label image: one channel of 8 bits, or several equal ones. Throws Error on anything else.
cv::Mat readLabelImage(const std::filesystem::path& file);

/// The points of the masked pixels in `box`, with colors: `depth` (CV_32F, meters), `mask` (CV_8U) and
/// `image` (BGR) have one size, and `camera` is theirs. Throws Error when sizes differ, naming `view`.
PointCloud pointsBehind(const cv::Mat& image, const cv::Mat& depth, const cv::Mat& mask, const cv::Rect& box,
                        const CameraIntrinsics& camera, const std::string& view);

}  // namespace estancia::io
