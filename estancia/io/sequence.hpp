// A sequence of frames, whatever the format on disk.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/frame.hpp"

namespace estancia {

/// Frames in driving order. What is known without pixels is listed at once; pixels are read on request.
class Sequence {
 public:
  virtual ~Sequence() = default;

  /// Short name for people: the folder or file name.
  virtual std::string name() const = 0;

  virtual std::size_t size() const = 0;

  /// Throws nothing for i < size().
  virtual const Frame& frame(std::size_t i) const = 0;

  /// The picture: BGR, 8 bits, 3 channels, never empty (grey and 16-bit sources are converted).
  /// Throws Error when this one frame cannot be read; later frames may still be fine. Safe to call from
  /// several threads; videos are quickest when read in order.
  virtual cv::Mat image(std::size_t i) const = 0;

  /// Identifies the pixels that image(i) gives without decoding them: equal fingerprints, equal pictures. ""
  /// where that is not possible. Throws Error when the file cannot be read. Safe to call from several
  /// threads.
  virtual std::string fingerprint(std::size_t /*i*/) const { return ""; }

  /// Sentences about what the reader found odd in the whole sequence (unordered or missing stamps, poses with
  /// NaN …).
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::vector<std::string> warnings_;
};

/// How to open a sequence. The defaults find the format by themselves.
struct SequenceOptions {
  /// One of sequenceTypes(), or "auto".
  std::string type = "auto";
  /// A trajectory (TUM `t x y z qx qy qz qw` or KITTI), matched by time stamp or order; "" takes `poses.txt`
  /// in the folder when it is there.
  std::filesystem::path poses;
  /// A CSV `image,room`; "" takes `rooms.csv` in the folder when it is there.
  std::filesystem::path rooms;
  /// A pose further away in time than this belongs to no frame [s].
  double maxPoseGap = 0.05;

  // The panorama tour: perspective views of every place (320×240 pixels).
  int views = 12;           ///< views per place, evenly turned
  double fieldOfView = 80;  ///< horizontal [degrees]
  double turn = 0;          ///< added to every heading [degrees]: another tour of the same places
  double exposure = 0;      ///< change of exposure [EV]: another light
  int rounds = 1;           ///< how often the tour visits all places; later rounds look between the headings
};

/// Opens `path` (a folder, a video file, a folder of panoramas …).
/// Throws Error when there is nothing to read, the format is not recognised, or a side file is wrong.
std::unique_ptr<Sequence> openSequence(const std::filesystem::path& path,
                                       const SequenceOptions& options = {});

/// The known values of SequenceOptions::type, each with one line of explanation.
std::vector<std::pair<std::string, std::string>> sequenceTypes();

}  // namespace estancia
