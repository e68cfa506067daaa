// Sequence: frames in driving order from videos, image folders and robotics data sets.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/frame.hpp"

namespace estancia {

/// Where the poses of a sequence come from.
struct PoseSource {
  /// First and last time stamp of the trajectory [s] when no frame matches them, so that poses were assigned
  /// by order.
  std::optional<std::pair<double, double>> otherClock;
};

/// Frames in driving order. Names, times, poses and rooms are known at once; pixels are read on request.
class Sequence {
 public:
  virtual ~Sequence() = default;

  /// Short name for display: the folder or file name.
  virtual std::string name() const = 0;

  virtual std::size_t size() const = 0;

  /// Throws nothing for i < size().
  virtual const Frame& frame(std::size_t i) const = 0;

  /// The image: BGR, 8 bits, 3 channels, never empty (gray and 16-bit images are converted). Throws Error
  /// when this frame cannot be read; other frames may still be readable. Thread-safe; videos are fastest in
  /// order.
  virtual cv::Mat image(std::size_t i) const = 0;

  /// image(i), decoded at a fraction of its size where its file is a JPEG: see readReducedImage().
  /// Thread-safe.
  virtual cv::Mat reducedImage(std::size_t i, int /*side*/) const { return image(i); }

  /// Identifies the pixels of image(i) without decoding them: equal fingerprints mean equal images. "" where
  /// that is not possible. Throws Error when the file cannot be read. Thread-safe.
  virtual std::string fingerprint(std::size_t /*i*/) const { return ""; }

  /// Whether there are depth images; single frames may still lack theirs.
  virtual bool hasDepth() const { return false; }

  /// Depth along the optical axis [m], CV_32F, never empty; 0 where unknown. Same view as the image, perhaps
  /// another size. Throws Error when this frame has no depth or it cannot be read. Thread-safe.
  virtual cv::Mat depth(std::size_t i) const;

  /// Units per meter of the depth images' files, as given or as defined by the data set; 0 where their type
  /// defines it.
  virtual double depthScale() const { return 0; }

  /// Time stamp of the depth image nearest in time to frame i [s], also where it is too far away to be used.
  /// Absent where depth has no time stamps of its own.
  virtual std::optional<double> depthTimestamp(std::size_t /*i*/) const { return std::nullopt; }

  /// The camera of images and depth; scaledTo() adapts it to a size. Absent where unknown.
  const std::optional<CameraIntrinsics>& intrinsics() const { return intrinsics_; }

  /// Absent where there is no trajectory. Single frames may lack a pose all the same.
  const std::optional<PoseSource>& poseSource() const { return poseSource_; }

  /// Sentences about problems of the whole sequence (unordered or missing time stamps, poses with NaN …).
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::vector<std::string> warnings_;
  std::optional<CameraIntrinsics> intrinsics_;
  std::optional<PoseSource> poseSource_;
};

/// How openSequence() opens a sequence. The defaults detect the format.
struct SequenceOptions {
  /// One of sequenceTypes(), or "auto".
  std::string type = "auto";
  /// A trajectory (TUM `t x y z qx qy qz qw` or KITTI), matched by time stamp or order; "" takes `poses.txt`
  /// in the folder if it exists.
  std::filesystem::path poses;
  /// A CSV `image,room` or `image,room,split`; "" takes `rooms.csv` in the folder if it exists.
  std::filesystem::path rooms;
  /// Only the frames of this split: "train", "test", or a name of the data set or the CSV of rooms; "" takes
  /// all.
  std::string split;
  /// Only the frames in these rooms; empty takes all, also those of unknown rooms.
  std::vector<std::string> only;
  /// Largest time difference between a frame and its pose [s].
  double maxPoseGap = 0.05;

  /// Depth units per meter; 0 takes that of the data set (TUM RGB-D 5000), else 1000 for 16 bits
  /// (millimeters), 25.5 for 8 bits (255 is 10 m) and 1 for float (meters).
  double depthScale = 0;
  /// The camera: a file with its 3×3 matrix, `fx fy cx cy`, or a calibration of ROS or OpenCV (YAML); ""
  /// takes `camera-intrinsics.txt`, `intrinsics.txt` or `camera.yaml` in the folder if it exists, else the
  /// published camera of the data set.
  std::filesystem::path intrinsics;

  // Bags of ROS 1 and 2: topics by their names. "" takes the only one that fits.
  /// Images, raw or compressed.
  std::string imageTopic;
  /// Depth images; "none": without depth.
  std::string depthTopic;
  /// nav_msgs/Odometry, geometry_msgs/PoseStamped … or tf; "none": without poses.
  std::string odomTopic;

  // Panorama tours: perspective views (320×240 pixels) of each panorama.
  /// Views per panorama, evenly spaced.
  int views = 12;
  /// Horizontal field of view [degrees].
  double fieldOfView = 80;
  /// Offset of all headings [degrees]: another tour of the same places.
  double turn = 0;
  /// Change of exposure [EV]: another illumination.
  double exposure = 0;
  /// How often the tour visits all places; later rounds look between the headings of the earlier ones.
  int rounds = 1;
};

/// Whether any of its frames has a pose.
bool hasPoses(const Sequence& sequence);

}  // namespace estancia
