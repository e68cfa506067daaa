// Listed sequence: a sequence whose frames are known when it is opened; what readers of data sets share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/core/options.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/sequences/trajectory.hpp"

namespace estancia::io {

/// One format: whether a path looks like it, and how to open it.
template <class Opened, class Options>
struct Format {
  const char* type;
  const char* explanation;
  bool (*recognizes)(const std::filesystem::path& path);
  Opened (*open)(const std::filesystem::path& path, const Options& options);
};

template <class Formats>
Choices typesOf(const Formats& formats) {
  Choices types;
  for (const auto& format : formats) types.push_back({format.type, format.explanation});
  return types;
}

/// "auto" and the types.
template <class Formats>
Choices typesWithAuto(const Formats& formats) {
  Choices types = typesOf(formats);
  types.insert(types.begin(), {"auto", "detected by content"});
  return types;
}

/// The format of this type, or with "auto" the first that recognizes `path`; null when none does.
template <class Formats>
auto findFormat(const Formats& formats, const std::filesystem::path& path, const std::string& type) {
  const auto found = std::find_if(std::begin(formats), std::end(formats), [&](const auto& format) {
    return type == format.type || (type == "auto" && format.recognizes(path));
  });
  return found == std::end(formats) ? nullptr : &*found;
}

/// The result of `open()`. Exceptions of the file system and of OpenCV become Error.
template <class Open>
auto opened(const std::filesystem::path& path, const Open& open) {
  try {
    return open();
  } catch (const std::filesystem::filesystem_error& e) {
    fail(ErrorCode::fileUnreadable, "{}: cannot be read ({})", printable(path), e.code().message());
  } catch (const cv::Exception& e) {
    fail(ErrorCode::fileUnreadable, "{}: OpenCV cannot read it ({})", printable(path), printable(e.err));
  }
}

/// A Sequence or ObjectViews whose entries are all known when it is opened.
template <class Base, class Entry>
class Listed : public Base {
 public:
  std::string name() const final { return name_; }
  std::size_t size() const final { return entries_.size(); }
  void warn(std::string sentence) { this->warnings_.push_back(std::move(sentence)); }

 protected:
  explicit Listed(std::string name) : name_(std::move(name)) {}

  std::string name_;
  std::vector<Entry> entries_;
};

/// A sequence whose frames are all listed when it is opened.
class ListedSequence : public Listed<Sequence, Frame> {
 public:
  const Frame& frame(std::size_t i) const final { return entries_[i]; }

  /// For openSequence(), which adds poses and rooms from side files.
  std::vector<Frame>& frames() { return entries_; }
  /// The split ("train", "test" …) of each frame, "" where unknown; empty where unknown for all.
  std::vector<std::string>& splits() { return splits_; }
  void setIntrinsics(const CameraIntrinsics& camera) { intrinsics_ = camera; }
  void setPoseSource(const PoseSource& source) { poseSource_ = source; }

 protected:
  using Listed::Listed;

  std::vector<std::string> splits_;
};

/// Frames of one image file each, perhaps with a depth image: most data sets.
class ImageFiles final : public ListedSequence {
 public:
  /// `depthScale`: units per meter, see readDepth().
  explicit ImageFiles(std::string name, double depthScale = 0)
      : ListedSequence(std::move(name)), depthScale_(depthScale) {}
  void add(Frame frame, std::filesystem::path file, DepthFile depth = {});
  cv::Mat image(std::size_t i) const override;
  cv::Mat reducedImage(std::size_t i, int side) const override;
  std::string fingerprint(std::size_t i) const override;
  bool hasDepth() const override { return hasDepth_; }
  cv::Mat depth(std::size_t i) const override;
  double depthScale() const override { return depthScale_; }
  std::optional<double> depthTimestamp(std::size_t i) const override { return depths_.at(i).timestamp; }

 private:
  std::vector<std::filesystem::path> files_;
  std::vector<DepthFile> depths_;
  double depthScale_;
  bool hasDepth_ = false;
};

using Opened = std::unique_ptr<ListedSequence>;

/// The frames of options.split and options.only, in order; all frames when both are empty. Throws Error on an
/// unknown split or room (naming the known ones), and when no frame is in both.
std::unique_ptr<Sequence> selectFrames(Opened sequence, const SequenceOptions& options);

/// The pose of a rigid transform camera → map, row-major 3×4. Nothing when it is not finite or its left part
/// is no rotation (columns off by more than 1 % from unit length or right angles, or mirrored).
std::optional<Pose> poseOfMatrix(const std::array<double, 12>& matrix);

/// The time stamp [s] in a file name like TUM's "1305031102.175304.png"; nothing in other names.
std::optional<double> timestampOf(const std::filesystem::path& file);

/// The last component of a path, also of "folder/" and ".".
std::string nameOf(const std::filesystem::path& path);

/// Gives every frame the pose nearest in time, at most `maxGap` [s] away; not interpolated, so that every
/// pose is a measured one. Where frames or poses have no time stamps, or no time stamp matches at all (two
/// clocks), lists of equal length are matched by order. Throws Error when neither is possible.
void attachPoses(ListedSequence& sequence, const Trajectory& trajectory, const std::filesystem::path& file,
                 double maxGap);

/// Sets the rooms of frames from the CSV `image,room` (by frame name or its last component), and their splits
/// from a third column; a header is optional. A warning counts names without a frame. Throws `FILE:LINE: …`.
void attachRooms(ListedSequence& sequence, const std::filesystem::path& file);

}  // namespace estancia::io
