// Sources of frames: cameras, and recordings that are replayed.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/sources/camera_source.hpp"

#include <gmock/gmock.h>

#include <httplib.h>
#include <array>
#include <atomic>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <thread>

#include "estancia/map_file/map.hpp"
#include "estancia/sources/frame_source.hpp"
#include "estancia/sources/replay_source.hpp"
#include "support/errors.hpp"
#include "support/loopback_server.hpp"
#include "support/support.hpp"

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

TEST(CameraSource, TellsOfACameraThatHasGoneAndOpensItAgain) {
  MjpegServer server;
  server.isGone = true;
  CameraSource camera(server.url(), brief);
  for (int i = 0; i < 300 && server.connections < 3; ++i) camera.newest(100ms);
  EXPECT_GE(server.connections, 3);
  CameraSource missing("/dev/video987", brief), unplugged("987", brief);
  for (CameraSource* silent : {&camera, &missing, &unplugged}) {
    for (int i = 0; i < 300 && silent->trouble().empty(); ++i) EXPECT_FALSE(silent->newest(100ms));
    EXPECT_NE(silent->trouble(), "");
  }
  server.isGone = false;
  EXPECT_TRUE(frameOf(camera));
}

TEST(CameraSource, KnowsCamerasByTheirNames) {
  for (const char* camera : {"0", "12", "/dev/video0", "http://x/y", "rtsp://x/y"})
    EXPECT_TRUE(isCamera(camera)) << camera;
  for (const char* other : {"", "photos", "./0", "12345", "drive.mp4", "-1", "ros2:/image"})
    EXPECT_FALSE(isCamera(other)) << other;
  for (const char* none : {"photos", "http://"})
    EXPECT_THAT([&] { CameraSource source(none); }, FailsWith(ErrorCode::invalidInput)) << none;
}

/// Counts what was decoded.
class Recording : public Sequence {
 public:
  explicit Recording(const std::vector<std::optional<double>>& times) {
    for (const auto& time : times) {
      Frame frame;
      frame.name = "frame " + std::to_string(frames_.size());
      frame.timestamp = time;
      frames_.push_back(frame);
    }
  }
  std::string name() const override { return "recording"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_.at(i); }
  cv::Mat image(std::size_t i) const override {
    decoded.insert(i);
    if (broken.contains(i)) throw Error(ErrorCode::fileUnreadable, frames_[i].name + " is broken");
    return {4, 4, CV_8UC3, cv::Scalar()};
  }
  mutable std::set<std::size_t> decoded;
  std::set<std::size_t> broken;

 private:
  std::vector<Frame> frames_;
};

std::vector<std::optional<double>> evenly(std::size_t count, double period) {
  std::vector<std::optional<double>> times;
  for (std::size_t i = 0; i < count; ++i) times.emplace_back(100 + period * static_cast<double>(i));
  return times;
}

TEST(ReplaySource, DropsWhatNobodyTookInTimeAndDecodesOnlyTheRest) {
  auto recording = std::make_unique<Recording>(evenly(100, 0.01));
  const Recording& seen = *recording;
  ReplaySource source(std::move(recording));
  std::size_t taken = 0, dropped = 0, next = 0;
  while (!source.ended()) {
    const auto live = source.newest(1s);
    ASSERT_TRUE(live);
    ++taken;
    dropped += live->dropped;
    next += live->dropped;
    EXPECT_EQ(live->frame.name, "frame " + std::to_string(next++)) << "frames stay in order, and are counted";
    EXPECT_LE(live->arrived, std::chrono::steady_clock::now());
    if (taken < 3) std::this_thread::sleep_for(55ms);
  }
  EXPECT_EQ(taken + dropped, 100U);
  EXPECT_GE(dropped, 8U);
  EXPECT_EQ(seen.decoded.size(), taken);
}

TEST(ReplaySource, GivesAllFramesAtRateZero) {
  ReplaySource source(std::make_unique<Recording>(evenly(50, 3600)), {.rate = 0});
  for (std::size_t i = 0; i < 50; ++i) {
    const auto live = source.newest(0ms);
    ASSERT_TRUE(live) << i;
    EXPECT_EQ(live->dropped, 0U);
  }
  EXPECT_TRUE(source.ended());
  EXPECT_FALSE(source.newest(0ms));
}

TEST(ReplaySource, IsNotStalledByAClockThatJumpsOrStands) {
  std::vector<std::optional<double>> times = evenly(20, 0.1);
  times[3] = -1e6;
  for (std::size_t i = 5; i < 9; ++i) times[i] = 42;
  times[12] = 1e12;
  times[15] = std::nullopt;
  ReplaySource source(std::make_unique<Recording>(times), {.rate = 100});
  std::size_t count = 0;
  for (int i = 0; i < 200 && !source.ended(); ++i)
    if (const auto live = source.newest(100ms)) count += 1 + live->dropped;
  EXPECT_EQ(count, 20U);
}

TEST(ReplaySource, TellsOfFramesThatCannotBeReadAndGoesOn) {
  auto recording = std::make_unique<Recording>(evenly(3, 1));
  recording->broken = {1};
  ReplaySource source(std::move(recording), {.rate = 0});
  EXPECT_TRUE(source.newest(0ms));
  EXPECT_EQ(source.trouble(), "");
  EXPECT_FALSE(source.newest(0ms));
  EXPECT_NE(source.trouble(), "");
  EXPECT_EQ(source.unreadable(), 1U);
  EXPECT_TRUE(source.newest(0ms));
  EXPECT_EQ(source.trouble(), "");
}

TEST(ReplaySource, GoesOnBehindTheFramesOfAMap) {
  ReplaySource source(std::make_unique<Recording>(evenly(5, 1)), {.rate = 0});
  TopologicalMap map{Vocabulary({"word"})};
  for (const char* name : {"frame 0", "frame 2"}) {
    MappedFrame frame;
    frame.name = name;
    map.frames.push_back(frame);
  }
  EXPECT_TRUE(source.goOnAfter(map));
  EXPECT_EQ(source.newest(0ms)->frame.name, "frame 3");
  map.frames.front().name = "another drive";
  EXPECT_FALSE(source.goOnAfter(map));
  EXPECT_EQ(source.newest(0ms)->frame.name, "frame 0");
}

TEST(OpenSource, SaysWhatIsNoSource) {
  EXPECT_THAT([] { makeFrameSource("/nowhere/at/all"); }, FailsWith(ErrorCode::fileNotFound));
  const test::ScratchFolder folder;
  test::writeFile(folder / "a.labels", "no words");
  EXPECT_THAT([&] { makeFrameSource(folder / "a.labels"); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST(OpenSource, RefusesOptionsThatWouldDoNothing) {
  const auto refuses = [](const char* source, const FrameSourceOptions& options) {
    EXPECT_THAT([&] { makeFrameSource(source, options); }, FailsWith(ErrorCode::invalidOption)) << source;
  };
  std::array<FrameSourceOptions, 6> ofRecordings;
  ofRecordings[0].replay.rate = 2;
  ofRecordings[1].replay.framesPerSecond = 5;
  ofRecordings[2].sequence.type = "tum";
  ofRecordings[3].sequence.poses = "poses.txt";
  ofRecordings[4].sequence.intrinsics = "camera.txt";
  ofRecordings[5].sequence.imageTopic = "/image";
  for (const char* source : {"0", "http://127.0.0.1:9/video", "ros2:/image"})
    for (const FrameSourceOptions& options : ofRecordings) refuses(source, options);
  FrameSourceOptions depth, odometry, backwards;
  depth.sequence.depthTopic = "/depth";
  odometry.sequence.odomTopic = "/odom";
  backwards.replay.rate = -1;
  const test::ScratchFolder folder;
  cv::imwrite(folder / "a.png", cv::Mat(8, 8, CV_8U, 100));
  for (const FrameSourceOptions& options : {depth, odometry}) refuses("0", options);
  for (const FrameSourceOptions& options : {depth, backwards}) refuses(folder.path().c_str(), options);
}

}  // namespace
}  // namespace estancia
