// Camera: the newest frame of a Video4Linux device, an MJPEG or an RTSP stream, which may go and come back.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "estancia/sources/frame_source.hpp"

namespace estancia {

namespace io {
class VideoDecoder;
}

/// Whether a source's name is a camera's: "0", "/dev/video0", "http://…", "https://…", "rtsp://…".
bool isCamera(const std::string& source);

/// How long a camera may take, and how long it is left alone.
struct CameraPatience {
  /// To open it, and for a frame of one of the network.
  std::chrono::milliseconds answer{5000};
  /// Before it is opened again; twice as long each time that fails, up to `longestPause`.
  std::chrono::milliseconds pause{500}, longestPause{10000};
};

/// A thread takes its frames and keeps the newest one only. Invariant: `mutex_` guards the newest image and
/// its time; the decoder belongs to the thread alone. Life cycle: the thread opens the camera, opens it again
/// when it stops giving frames, and ends with the source.
class CameraSource : public FrameSource {
 public:
  /// Opens it in the background, and again whenever it has gone. Throws missingDependency, invalidInput.
  explicit CameraSource(std::string camera, const CameraPatience& patience = {});
  /// May wait for a camera that does not answer, up to its patience.
  ~CameraSource() override;

  std::string name() const override { return camera_; }
  std::optional<LiveFrame> newest(std::chrono::milliseconds patience) override;
  std::string trouble() const override;

 private:
  using Clock = std::chrono::steady_clock;
  void grab();
  bool isMissing() const;
  void readFrames();
  Frame nextFrame();

  std::string camera_;
  CameraPatience patience_;
  std::unique_ptr<io::VideoDecoder> decoder_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool ending_ = false, open_ = false;
  cv::Mat image_;
  Clock::time_point arrived_, started_ = Clock::now();
  std::size_t grabbed_ = 0, taken_ = 0;
  std::string lastName_;
  std::thread thread_;  // last: it uses all others
};

}  // namespace estancia
