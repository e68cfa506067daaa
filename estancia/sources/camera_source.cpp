// SPDX-License-Identifier: Apache-2.0
#include "estancia/sources/camera_source.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <exception>
#include <filesystem>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/readers/video_decoder.hpp"

namespace estancia {
namespace {

/// A camera that gives nothing for so long has a trouble.
constexpr auto isStalled = std::chrono::seconds(2);

bool isDeviceNumber(const std::string& text) {
  return !text.empty() && text.size() <= 4 && text.find_first_not_of("0123456789") == std::string::npos;
}

/// BGR, 8 bits; empty where it is no image.
cv::Mat asColors(const cv::Mat& image) {
  const int channels = image.channels();
  if (image.empty() || image.depth() != CV_8U || (channels != 1 && channels != 3 && channels != 4)) return {};
  return io::toBgr8(image);
}

}  // namespace

bool isCamera(const std::string& source) {
  return isDeviceNumber(source) || source.starts_with("/dev/video") || source.starts_with("http://") ||
         source.starts_with("https://") || source.starts_with("rtsp://");
}

CameraSource::CameraSource(std::string camera, const CameraPatience& patience)
    : camera_(std::move(camera)), patience_(patience) {
  if (!isCamera(camera_))
    fail(ErrorCode::invalidInput,
         "\"{}\" is no camera; give a number, /dev/videoN, or an address that begins with http:// or rtsp://",
         printable(camera_));
  if (camera_.ends_with("://"))
    fail(ErrorCode::invalidInput, "\"{}\" names no host; give it whole: http://robot.local:8080/stream",
         printable(camera_));
  decoder_ = io::makeVideoDecoder();
  thread_ = std::thread([this] { grab(); });
}

CameraSource::~CameraSource() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void CameraSource::grab() {
  auto pause = patience_.pause;
  for (;;) {
    const std::size_t before = grabbed_;
    try {
      if (decoder_->openCamera(camera_, patience_.answer)) readFrames();
    } catch (const std::exception&) {  // an exception of OpenCV: treated like a camera that cannot be opened
    }
    std::unique_lock lock(mutex_);
    open_ = false;
    pause = grabbed_ > before ? patience_.pause : std::min(2 * pause, patience_.longestPause);
    if (changed_.wait_for(lock, pause, [this] { return ending_; })) return;
  }
}

/// Until there are none, or the source ends.
void CameraSource::readFrames() {
  for (;;) {
    cv::Mat image = decoder_->read();
    const bool isOver = image.empty();
    image = asColors(image);
    const std::lock_guard lock(mutex_);
    if (isOver || ending_) return;
    if (image.empty()) continue;
    open_ = true;
    image_ = std::move(image);
    arrived_ = Clock::now();
    ++grabbed_;
    changed_.notify_all();
  }
}

std::optional<LiveFrame> CameraSource::newest(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, patience, [this] { return grabbed_ > taken_; })) return std::nullopt;
  LiveFrame live;
  live.frame = nextFrame();
  live.image = std::move(image_);
  live.arrived = arrived_;
  live.dropped = grabbed_ - taken_ - 1;
  taken_ = grabbed_;
  return live;
}

/// Named by the time of day: no two of a map that is continued have one name. A clock may be set meanwhile.
Frame CameraSource::nextFrame() {
  using namespace std::chrono;
  static const auto day = system_clock::now();
  static const auto then = Clock::now();
  const double now =
      duration<double>(day.time_since_epoch()).count() + duration<double>(arrived_ - then).count();
  const auto second = static_cast<std::time_t>(now);
  Frame frame;
  frame.timestamp = now;
  frame.name = fmt::format("{:%Y-%m-%d %H:%M:%S}.{:03}", fmt::gmtime(second),
                           static_cast<int>(1000 * (now - static_cast<double>(second))));
  if (frame.name == lastName_) frame.name += '+';
  lastName_ = frame.name;
  return frame;
}

bool CameraSource::isMissing() const {
  const std::string device = isDeviceNumber(camera_) ? "/dev/video" + camera_ : camera_;
  return device.starts_with("/dev/") && !std::filesystem::exists(device);
}

std::string CameraSource::trouble() const {
  const std::lock_guard lock(mutex_);
  const auto silence = Clock::now() - (grabbed_ == 0 ? started_ : arrived_);
  if (silence < isStalled) return "";
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(silence).count();
  if (grabbed_ == 0 && !open_)
    return fmt::format("{} has given no image for {} s ({}): waiting for it", printable(camera_), seconds,
                       isMissing() ? "there is no such camera" : "nothing answers there, or it is no video");
  return fmt::format("no frame from {} for {} s: waiting for it", printable(camera_), seconds);
}

}  // namespace estancia
