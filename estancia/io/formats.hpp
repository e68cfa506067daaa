// What the readers of the single formats share with openSequence; of no use to others.
#pragma once

#include <filesystem>
#include <memory>
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
  void warn(std::string sentence) { warnings_.push_back(std::move(sentence)); }

 protected:
  explicit ListedSequence(std::string name) : name_(std::move(name)) {}

  std::string name_;
  std::vector<Frame> frames_;
};

/// Frames that are one picture file each: what most data sets come down to.
class ImageFiles final : public ListedSequence {
 public:
  explicit ImageFiles(std::string name) : ListedSequence(std::move(name)) {}
  void add(Frame frame, std::filesystem::path file);
  cv::Mat image(std::size_t i) const override;
  std::string fingerprint(std::size_t i) const override;

 private:
  std::vector<std::filesystem::path> files_;
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
bool isImageFolder(const std::filesystem::path& path);
Opened openImageFolder(const std::filesystem::path& path, const SequenceOptions& options);

/// The last component of a path, also of "folder/" and ".".
std::string nameOf(const std::filesystem::path& path);

}  // namespace estancia::io
