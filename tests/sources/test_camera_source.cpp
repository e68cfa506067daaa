// Cameras of the network: an MJPEG server that stalls, goes, and comes back.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/sources/camera_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "support/errors.hpp"
#include "support/loopback_server.hpp"

namespace estancia {
namespace {

using namespace std::chrono_literals;
using test::FailsWith;

/// An MJPEG camera on a free port of this machine.
class MjpegServer {
 public:
  MjpegServer() {
    test::withoutProxy();
    server_.Get("/stream", [this](const httplib::Request&, httplib::Response& answer) {
      ++connections;
      answer.set_chunked_content_provider(
          "multipart/x-mixed-replace; boundary=frame",
          [this](std::size_t, httplib::DataSink& sink) { return send(sink); });
    });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
  }
  ~MjpegServer() {
    ending_ = true;
    server_.stop();
    thread_.join();
  }
  MjpegServer(const MjpegServer&) = delete;
  MjpegServer& operator=(const MjpegServer&) = delete;

  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/stream"; }

  std::atomic<bool> isStalled = false, isGone = false;
  std::atomic<int> width = 64, connections = 0;

 private:
  bool send(httplib::DataSink& sink) {
    std::this_thread::sleep_for(10ms);
    if (ending_ || isGone) return false;
    if (isStalled) return true;
    std::vector<unsigned char> jpeg;
    cv::imencode(".jpg", cv::Mat(48, width, CV_8UC3, cv::Scalar(0, 0, 200)), jpeg);
    const std::string head =
        "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: " + std::to_string(jpeg.size()) + "\r\n\r\n";
    return sink.write(head.data(), head.size()) &&
           sink.write(reinterpret_cast<const char*>(jpeg.data()), jpeg.size()) && sink.write("\r\n", 2);
  }

  httplib::Server server_;
  int port_ = 0;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

const CameraPatience brief{1000ms, 20ms, 100ms};

/// The next frame, however long a busy machine takes; nothing after half a minute.
std::optional<LiveFrame> frameOf(CameraSource& camera) {
  for (int i = 0; i < 300; ++i)
    if (auto live = camera.newest(100ms)) return live;
  return std::nullopt;
}

TEST(CameraSource, GivesTheNewestFramesOfAnMjpegServer) {
  MjpegServer server;
  CameraSource camera(server.url(), brief);
  const auto first = frameOf(camera);
  ASSERT_TRUE(first) << camera.trouble();
  EXPECT_EQ(first->image.size(), cv::Size(64, 48));
  EXPECT_EQ(first->image.type(), CV_8UC3);
  EXPECT_TRUE(first->frame.timestamp);
  const auto second = frameOf(camera);
  ASSERT_TRUE(second);
  EXPECT_NE(first->frame.name, second->frame.name);
  EXPECT_GT(*second->frame.timestamp, *first->frame.timestamp);
  EXPECT_EQ(camera.trouble(), "");
  EXPECT_FALSE(camera.ended());
}

TEST(CameraSource, WaitsForACameraThatStallsAndComesBack) {
  MjpegServer server;
  CameraSource camera(server.url(), brief);
  ASSERT_TRUE(frameOf(camera));
  server.isStalled = true;
  for (int i = 0; i < 300 && camera.trouble().empty(); ++i) camera.newest(100ms);
  EXPECT_NE(camera.trouble(), "");
  server.isStalled = false;
  EXPECT_TRUE(frameOf(camera));
  EXPECT_EQ(camera.trouble(), "");
}

TEST(CameraSource, OpensACameraAgainThatHasGone) {
  MjpegServer server;
  server.isGone = true;
  CameraSource camera(server.url(), brief);
  for (int i = 0; i < 300 && server.connections < 3; ++i) camera.newest(100ms);
  EXPECT_GE(server.connections, 3);
  server.isGone = false;
  EXPECT_TRUE(frameOf(camera));
}

TEST(CameraSource, KnowsCamerasByTheirNames) {
  for (const char* camera : {"0", "12", "/dev/video0", "http://x/y", "rtsp://x/y"})
    EXPECT_TRUE(isCamera(camera)) << camera;
  for (const char* other : {"", "photos", "./0", "12345", "drive.mp4", "-1", "ros2:/image"})
    EXPECT_FALSE(isCamera(other)) << other;
  EXPECT_THAT([] { CameraSource("photos"); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
