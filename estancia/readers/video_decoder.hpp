// Video decoder: a video file or a camera frame by frame, by a module of OpenCV's video input that is opened
// for the first video. FFmpeg and GStreamer bring a hundred shared libraries, which images do without.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace estancia::io {

/// One file and one position in it, or one camera; not thread-safe. Each function may throw cv::Exception.
class VideoDecoder {
 public:
  virtual ~VideoDecoder() = default;
  /// Goes to the start of the file; false when it cannot be opened as a video.
  virtual bool open(const std::string& file) = 0;
  /// Opens a camera: a number or /dev/videoN of Video4Linux, http:// or rtsp://. False when that fails or
  /// takes longer than `patience`; for one of the network, reading ends after that time, too.
  virtual bool openCamera(const std::string& camera, std::chrono::milliseconds patience) = 0;
  /// Size of a frame [pixels].
  virtual double pixels() const = 0;
  /// Frames a second that the container declares; 0 or less, or not finite, where it declares none.
  virtual double rate() const = 0;
  /// The number of frames that the container declares. It may be wrong.
  virtual double declaredFrames() const = 0;
  /// Goes to a frame; false unless the decoder confirms that position.
  virtual bool seek(double frame) = 0;
  /// Passes over a frame; false when there is none.
  virtual bool skip() = 0;
  /// Decodes a frame into a buffer of the decoder's; empty when there is none.
  virtual cv::Mat read() = 0;
};

/// Opens the module at the first call. Throws Error (missingDependency) where it cannot.
std::unique_ptr<VideoDecoder> makeVideoDecoder();

}  // namespace estancia::io
