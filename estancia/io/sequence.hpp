// A sequence of frames, whatever the format on disk.
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

/// What is known of the trajectory that poses were taken from.
struct PoseSource {
  /// Its first and last time stamp [s], where frames have stamps, too, but none fits: poses went by order.
  std::optional<std::pair<double, double>> otherClock;
};

/// Frames in driving order. What is known without pixels is listed at once; pixels are read on request.
class Sequence {
 public:
  virtual ~Sequence() = default;

  /// Short name for people: the folder or file name.
  virtual std::string name() const = 0;

  virtual std::size_t size() const = 0;

  /// Throws nothing for i < size().
  virtual const Frame& frame(std::size_t i) const = 0;

  /// The image: BGR, 8 bits, 3 channels, never empty (gray and 16-bit sources are converted).
  /// Throws Error when this one frame cannot be read; later frames may still be fine. Safe to call from
  /// several threads; videos are quickest when read in order.
  virtual cv::Mat image(std::size_t i) const = 0;

  /// Identifies the pixels that image(i) gives without decoding them: equal fingerprints, equal images. ""
  /// where that is not possible. Throws Error when the file cannot be read. Safe to call from several
  /// threads.
  virtual std::string fingerprint(std::size_t /*i*/) const { return ""; }

  /// Whether there are depth images; single frames may still lack theirs.
  virtual bool hasDepth() const { return false; }

  /// Meters along the optical axis, CV_32F, never empty; 0 where there is none. Its size may be another than
  /// the image's: it shows the same view. Throws Error when this frame's depth is missing or cannot be
  /// read. Safe to call from several threads.
  virtual cv::Mat depth(std::size_t i) const;

  /// When the depth image nearest to frame i in time was taken [s], also where that is too far away to be
  /// the frame's own. Absent where depth has no time stamps of its own.
  virtual std::optional<double> depthTimestamp(std::size_t /*i*/) const { return std::nullopt; }

  /// The camera of the images and of depth; scaledTo() fits it to a size. Absent where unknown.
  const std::optional<CameraIntrinsics>& intrinsics() const { return intrinsics_; }

  /// Absent where nobody gave poses. Frames may lack theirs all the same, as where a trajectory is all NaN.
  const std::optional<PoseSource>& poseSource() const { return poseSource_; }

  /// Sentences about what the reader found odd in the whole sequence (unordered or missing stamps, poses with
  /// NaN …).
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::vector<std::string> warnings_;
  std::optional<CameraIntrinsics> intrinsics_;
  std::optional<PoseSource> poseSource_;
};

/// How to open a sequence. The defaults find the format by themselves.
struct SequenceOptions {
  /// One of sequenceTypes(), or "auto".
  std::string type = "auto";
  /// A trajectory (TUM `t x y z qx qy qz qw` or KITTI), matched by time stamp or order; "" takes `poses.txt`
  /// in the folder when it is there.
  std::filesystem::path poses;
  /// A CSV `image,room` or `image,room,split`; "" takes `rooms.csv` in the folder when it is there.
  std::filesystem::path rooms;
  /// Only the frames of this part of the data set: "train", "test" or what the data set or the CSV of rooms
  /// calls it; "" takes all.
  std::string split;
  /// Only the frames in these rooms; none takes all, those of unknown rooms included.
  std::vector<std::string> only;
  /// A pose further away in time than this belongs to no frame [s].
  double maxPoseGap = 0.05;

  /// What a meter is in the numbers of depth images; 0 takes the data set's own (TUM RGB-D 5000), or, where
  /// there is none, 1000 for 16 bits (millimeters), 25.5 for 8 bits (255 is 10 m) and 1 for float (meters).
  double depthScale = 0;
  /// The camera: a file with its 3×3 matrix, `fx fy cx cy`, or a calibration of ROS or OpenCV (YAML); ""
  /// takes `camera-intrinsics.txt`, `intrinsics.txt` or `camera.yaml` in the folder when it is there, else
  /// what the data set publishes.
  std::filesystem::path intrinsics;

  // The panorama tour: perspective views of every place (320×240 pixels).
  int views = 12;           ///< views per place, evenly turned
  double fieldOfView = 80;  ///< horizontal [degrees]
  double turn = 0;          ///< added to every heading [degrees]: another tour of the same places
  double exposure = 0;      ///< change of exposure [EV]: another light
  int rounds = 1;           ///< how often the tour visits all places; later rounds look between the headings
};

/// Opens `path` (a folder, a video file, a folder of panoramas …).
/// Throws Error when there is nothing to read, the format is not recognized, a side file is wrong, or there
/// is no such split or room (listing the known ones).
std::unique_ptr<Sequence> openSequence(const std::filesystem::path& path,
                                       const SequenceOptions& options = {});

/// Single image files, in the order given; each frame is called as its file is given. Throws Error for what
/// is no file, or no image by its name.
std::unique_ptr<Sequence> openImages(const std::vector<std::filesystem::path>& files);

/// Whether the file is an image by its name.
bool isImageFile(const std::filesystem::path& file);

/// The known values of SequenceOptions::type, each with one line of explanation.
std::vector<std::pair<std::string, std::string>> sequenceTypes();

}  // namespace estancia
