// Video files that OpenCV opens. The frame rate is constant: a frame's time is its number divided by the rate
// that the container declares, and absent when it declares none.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <mutex>

#include "estancia/core/digest.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/readers/formats.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/readers/video_decoder.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

constexpr double maxVideoPixels = 1 << 26;
constexpr std::size_t shortHop = 50;  // so many frames are skipped faster by reading than by seeking

/// Frames of a video. Invariant: `next_` is the frame that the decoder gives next; a request for another one
/// seeks or, where that fails, opens the file again. Thread-safe, one decoding at a time.
class Video final : public ListedSequence {
 public:
  explicit Video(const fs::path& file) : ListedSequence(nameOf(file)), file_(file) {
    reopen();
    const double pixels = decoder_->pixels();
    if (!(pixels <= maxVideoPixels))
      fail(ErrorCode::tooLarge, "{}: {:.0f} million pixels per frame; reduce its size", printable(file),
           pixels / 1e6);
    const double rate = decoder_->rate();
    const bool rateIsSane = rate > 0 && rate <= 10'000;
    const std::size_t frames = count();
    if (frames == 0)
      fail(ErrorCode::malformedFile, "{}: no frame can be decoded; is the video complete?", printable(file));
    for (std::size_t i = 0; i < frames; ++i)
      entries_.push_back({fmt::format("frame {:06}", i),
                          rateIsSane ? std::optional(static_cast<double>(i) / rate) : std::nullopt,
                          {},
                          {}});
    if (!rateIsSane) warn("the video declares no frame rate; its frames have no time stamps");
  }

  cv::Mat image(std::size_t i) const override {
    const std::lock_guard lock(mutex_);
    cv::Mat image;
    try {
      if (moveTo(i)) {
        ++next_;  // also when decoding fails: the decoder has moved on
        image = decoder_->read();
      }
    } catch (const cv::Exception&) {  // reported below
      image.release();
    }
    if (image.empty())
      fail(ErrorCode::malformedFile, "{}: {} cannot be decoded", printable(file_), entries_.at(i).name);
    return toBgr8(image.clone());  // the decoder reuses its buffer
  }

  std::string fingerprint(std::size_t i) const override {
    std::call_once(digested_, [this] { digest_ = sha256OfFile(file_); });
    return fmt::format("{} frame {}", digest_, i);
  }

 private:
  void reopen() const {
    next_ = 0;
    bool opened = false;
    try {
      opened = decoder_->open(file_.string());
    } catch (const cv::Exception&) {  // reported below
    }
    if (!opened)
      fail(ErrorCode::unsupportedFile, "{}: OpenCV cannot open it as a video; convert it, for example to MP4",
           printable(file_));
  }

  /// Seeks if the decoder confirms its position; otherwise reads from the start.
  bool moveTo(std::size_t i) const {
    if (i < next_ || i - next_ > shortHop) {
      if (decoder_->seek(static_cast<double>(i)))
        next_ = i;
      else
        reopen();
    }
    for (; next_ < i; ++next_)
      if (!decoder_->skip()) return false;
    return true;
  }

  /// The declared number of frames where the last one exists and none follows; else the frames are counted.
  std::size_t count() const {
    const double declared = decoder_->declaredFrames();
    if (declared >= 1 && declared < 1e9) {
      const bool right = decoder_->seek(declared - 1) && decoder_->skip() && !decoder_->skip();
      reopen();
      if (right) return static_cast<std::size_t>(declared);
    }
    std::size_t frames = 0;
    while (decoder_->skip()) ++frames;
    reopen();
    return frames;
  }

  fs::path file_;
  mutable std::mutex mutex_;  // guards what follows: a decoder has one position
  const std::unique_ptr<VideoDecoder> decoder_ = makeVideoDecoder();
  mutable std::size_t next_ = 0;  // the frame that the next read gives
  mutable std::once_flag digested_;
  mutable std::string digest_;  // digest of the whole file
};
}  // namespace

static Opened openVideo(const fs::path& path, const SequenceOptions&) {
  if (isTextFile(path))  // FFmpeg would render it as a terminal screen
    fail(ErrorCode::unsupportedFile, "{}: a text file, not a video", printable(path));
  return std::make_unique<Video>(path);
}

const SequenceFormat videoFormat{
    "video", "a video file that OpenCV reads",
    [](const fs::path& path) { return fs::is_regular_file(path) && !isImageFile(path); }, openVideo};

}  // namespace estancia::io
