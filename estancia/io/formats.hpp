// What the readers of the single formats share with openSequence; of no use to others.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/io/sequence.hpp"

namespace estancia::io {

/// A sequence whose frames are all listed when it is opened.
class ListedSequence : public Sequence {
 public:
  std::string name() const final { return name_; }
  std::size_t size() const final { return frames_.size(); }
  const Frame& frame(std::size_t i) const final { return frames_[i]; }

  /// For openSequence, which adds poses and rooms from side files before anybody else sees the frames.
  std::vector<Frame>& frames() { return frames_; }
  /// The part of the data set ("train", "test" …) that each frame is of, "" where nobody says; empty where
  /// that is so for all.
  std::vector<std::string>& splits() { return splits_; }
  void warn(std::string sentence) { warnings_.push_back(std::move(sentence)); }
  void setIntrinsics(const CameraIntrinsics& camera) { intrinsics_ = camera; }
  void setPoseSource(const PoseSource& source) { poseSource_ = source; }

 protected:
  explicit ListedSequence(std::string name) : name_(std::move(name)) {}

  std::string name_;
  std::vector<Frame> frames_;
  std::vector<std::string> splits_;
};

/// A frame's depth image: "" where it has none.
struct DepthFile {
  std::filesystem::path file;
  std::optional<double> timestamp;  ///< of the nearest depth image, even where that is not this frame's
};

/// Frames that are one image file each, perhaps with one of depth: what most data sets come down to.
class ImageFiles final : public ListedSequence {
 public:
  /// `depthScale`: units a meter, as readDepth has it.
  explicit ImageFiles(std::string name, double depthScale = 0)
      : ListedSequence(std::move(name)), depthScale_(depthScale) {}
  void add(Frame frame, std::filesystem::path file, DepthFile depth = {});
  cv::Mat image(std::size_t i) const override;
  std::string fingerprint(std::size_t i) const override;
  bool hasDepth() const override { return hasDepth_; }
  cv::Mat depth(std::size_t i) const override;
  std::optional<double> depthTimestamp(std::size_t i) const override { return depths_.at(i).timestamp; }

 private:
  std::vector<std::filesystem::path> files_;
  std::vector<DepthFile> depths_;
  double depthScale_;
  bool hasDepth_ = false;
};

using Opened = std::unique_ptr<ListedSequence>;

// One pair a format: does `path` look like it, and open it. Each lives in the file of its name.
bool isVideo(const std::filesystem::path& path);
Opened openVideo(const std::filesystem::path& path, const SequenceOptions& options);
bool isTumRgbd(const std::filesystem::path& path);
Opened openTumRgbd(const std::filesystem::path& path, const SequenceOptions& options);
bool isSevenScenes(const std::filesystem::path& path);
Opened openSevenScenes(const std::filesystem::path& path, const SequenceOptions& options);
bool isPanoramas(const std::filesystem::path& path);
Opened openPanoramas(const std::filesystem::path& path, const SequenceOptions& options);
bool isIdol2(const std::filesystem::path& path);
Opened openIdol2(const std::filesystem::path& path, const SequenceOptions& options);
bool isNyu(const std::filesystem::path& path);
Opened openNyu(const std::filesystem::path& path, const SequenceOptions& options);
bool isRgbdFolders(const std::filesystem::path& path);
Opened openRgbdFolders(const std::filesystem::path& path, const SequenceOptions& options);
bool isVidrilo(const std::filesystem::path& path);
Opened openVidrilo(const std::filesystem::path& path, const SequenceOptions& options);
bool isClasses(const std::filesystem::path& path);
Opened openClasses(const std::filesystem::path& path, const SequenceOptions& options);
bool isImageFolder(const std::filesystem::path& path);
Opened openImageFolder(const std::filesystem::path& path, const SequenceOptions& options);

/// The time stamp [s] that a file is called by, like TUM's "1305031102.175304.png"; nothing where it is not.
std::optional<double> timestampOf(const std::filesystem::path& file);

/// The last component of a path, also of "folder/" and ".".
std::string nameOf(const std::filesystem::path& path);

}  // namespace estancia::io
