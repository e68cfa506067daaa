// Object views: crops and point clouds of single objects, from data sets or collected from a sequence.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Data of a view without its pixels.
struct ObjectView {
  /// Unique among the views.
  std::string name;
  /// Views of one physical object share it; unique among all categories.
  std::string instance;
  /// The class in the data set; "" where unknown.
  std::string category = {};
  /// The part of the data set: "train", "test"; "" where it has none.
  std::string split = {};
  /// The image or frame of the view; "" where there is none.
  std::string frame = {};
  /// The object was found flat when it was collected.
  bool flat = false;
  /// The border of the image cuts the object.
  bool atBorder = false;
};

/// The image of a view.
struct ObjectImage {
  /// BGR; empty where there is only a cloud.
  cv::Mat image;
  /// Bounding box of the object.
  cv::Rect box;
  /// CV_8U, the size of the image, not 0 on the object; empty where unknown.
  cv::Mat mask;
};

/// Views of objects, in order. Pixels and points are read on request; thread-safe.
class ObjectViews {
 public:
  virtual ~ObjectViews() = default;
  virtual std::string name() const = 0;
  virtual std::size_t size() const = 0;
  virtual const ObjectView& view(std::size_t i) const = 0;

  /// The points of the object in the camera frame [m], with colors where known. Throws Error as image().
  virtual PointCloud cloud(std::size_t i) const = 0;

  /// Throws Error when this view cannot be read.
  virtual ObjectImage image(std::size_t i) const = 0;

  /// Sentences about views that were left out.
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::vector<std::string> warnings_;
};

struct ObjectViewsOptions {
  /// One of objectViewTypes(), or "auto".
  std::string type = "auto";
  /// Views with fewer points are left out where opening reads points ("clouds", "nyu"), else by cloud().
  std::size_t minPoints = 100;
};
OptionGroup declare(ObjectViewsOptions& options);

/// Opens a folder of views:
///  * "samples": written by `estancia objects collect`, see object_samples.hpp;
///  * "clouds": CATEGORY/NAME.pcd (or .ply), one instance a folder, or CATEGORY/INSTANCE/NAME.pcd; no image;
///  * "washington": the RGB-D Object Dataset (Lai et al., ICRA 2011), CATEGORY/CATEGORY_N/
///    CATEGORY_N_VIDEO_FRAME_{crop.png,depthcrop.png,maskcrop.png,loc.txt}; camera-intrinsics.txt,
///    intrinsics.txt or camera.yaml in the folder replaces the published camera;
///  * "nyu": the labeled frames of NYU Depth v2 with label/ and classes40.txt. An instance is a connected
///    component of a class with at least 900 pixels, 600 of them with depth (of 320 × 240); walls, floors,
///    ceilings and the classes "other…" are left out.
/// warnings() names unusable views. Throws Error when none is left, a list is malformed or the format
/// unknown.
std::unique_ptr<ObjectViews> openObjectViews(const std::filesystem::path& path,
                                             const ObjectViewsOptions& options = {});

/// The values of ObjectViewsOptions::type besides "auto".
Choices objectViewTypes();

}  // namespace estancia
