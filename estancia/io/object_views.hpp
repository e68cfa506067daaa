// Single things, seen again and again: what objects are learned from, whatever the format on disk.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// What is known of a view without its pixels.
struct ObjectView {
  std::string name;  ///< unique among the views
  /// Of which thing; several views of one thing have the same, unique among categories.
  std::string instance;
  std::string category;   ///< what the data set calls it; "" where unknown
  std::string split;      ///< the data set's own part: "train", "test"; "" where it has none
  std::string frame;      ///< the image or frame it comes from; "" where there is none
  bool flat = false;      ///< told to be flat when it was collected
  bool atBorder = false;  ///< cut by the edge of the image
};

/// The thing in its image.
struct ObjectImage {
  cv::Mat image;  ///< BGR; empty where there is only a cloud
  cv::Rect box;   ///< of the thing in it
  cv::Mat mask;   ///< CV_8U, the size of the image, not 0 on the thing; empty where unknown
};

/// Views of things, in order. Pixels and points are read on request; from several threads at once.
class ObjectViews {
 public:
  virtual ~ObjectViews() = default;
  virtual std::string name() const = 0;
  virtual std::size_t size() const = 0;
  virtual const ObjectView& view(std::size_t i) const = 0;

  /// The thing's points in the frame of the camera where there was one [m], colored where colors are known.
  /// Throws Error when this view cannot be read.
  virtual PointCloud cloud(std::size_t i) const = 0;

  /// Throws Error when this view cannot be read.
  virtual ObjectImage image(std::size_t i) const = 0;

  /// Sentences about what was left out.
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::vector<std::string> warnings_;
};

struct ObjectViewsOptions {
  std::string type = "auto";  ///< one of objectViewTypes(), or "auto"
  /// Views with fewer points are left out where opening reads them anyway ("clouds", "nyu"), else refused
  /// by cloud().
  std::size_t leastPoints = 100;
};

/// Opens a folder of views:
///  * "samples": what `estancia objects collect` gathered, see object_samples.hpp;
///  * "clouds": CATEGORY/NAME.pcd (or .ply), a folder an object, which is one instance, or
///    CATEGORY/INSTANCE/NAME.pcd where there are several; no images;
///  * "washington": the RGB-D Object Dataset (Lai et al., ICRA 2011), CATEGORY/CATEGORY_N/
///    CATEGORY_N_VIDEO_FRAME_{crop.png,depthcrop.png,maskcrop.png,loc.txt}; a camera file in the folder
///    (io::findIntrinsics) replaces the published camera;
///  * "nyu": the labeled frames of NYU Depth v2 with label/ and classes40.txt. An instance is a connected
///    component of a class, of 900 pixels or more, 600 of them with depth (of 320 × 240); walls, floors,
///    ceilings and the classes other… are no things.
/// Views that cannot be used are told in warnings(). Throws Error when none is left, on lists that are wrong,
/// and when the format is not recognized.
std::unique_ptr<ObjectViews> openObjectViews(const std::filesystem::path& path,
                                             const ObjectViewsOptions& options = {});

/// The known values of ObjectViewsOptions::type, each with one line of explanation.
std::vector<std::pair<std::string, std::string>> objectViewTypes();

}  // namespace estancia
