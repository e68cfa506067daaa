// The module with OpenCV's video input; video_decoder.cpp opens it.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>

#include "estancia/readers/video_decoder.hpp"

namespace estancia::io {
namespace {

/// FFmpeg where OpenCV has it: others load plug-ins, leak on broken files, or read a name as a pattern.
int backend() {
  const auto all = cv::videoio_registry::getStreamBackends();
  return std::find(all.begin(), all.end(), cv::CAP_FFMPEG) != all.end() ? cv::CAP_FFMPEG : cv::CAP_ANY;
}

class OpencvVideoDecoder final : public VideoDecoder {
 public:
  bool open(const std::string& file) override { return capture_.open(file, backend()); }
  bool openCamera(const std::string& camera, std::chrono::milliseconds patience) override {
    capture_.release();
    if (camera.find("://") != std::string::npos) {
      setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // its log lines come with each frame and are of no use
      const int limit = static_cast<int>(patience.count());
      return capture_.open(camera, backend(),
                           {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, limit, cv::CAP_PROP_READ_TIMEOUT_MSEC, limit});
    }
    const bool isNumber = camera.find_first_not_of("0123456789") == std::string::npos;
    return isNumber ? capture_.open(std::stoi(camera), cv::CAP_V4L2) : capture_.open(camera, cv::CAP_V4L2);
  }
  double pixels() const override {
    return capture_.get(cv::CAP_PROP_FRAME_WIDTH) * capture_.get(cv::CAP_PROP_FRAME_HEIGHT);
  }
  double rate() const override { return capture_.get(cv::CAP_PROP_FPS); }
  double declaredFrames() const override { return capture_.get(cv::CAP_PROP_FRAME_COUNT); }
  bool seek(double frame) override {
    return capture_.set(cv::CAP_PROP_POS_FRAMES, frame) && capture_.get(cv::CAP_PROP_POS_FRAMES) == frame;
  }
  bool skip() override { return capture_.grab(); }
  cv::Mat read() override {
    cv::Mat image;
    capture_.read(image);
    return image;
  }

 private:
  cv::VideoCapture capture_;
};

}  // namespace
}  // namespace estancia::io

extern "C" __attribute__((visibility("default"))) estancia::io::VideoDecoder* estanciaMakeVideoDecoder() {
  return new estancia::io::OpencvVideoDecoder;
}
