// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <set>

#include "check/recorded_room.hpp"
#include "estancia/check/check.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/take_interrupt.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::Altered;
using test::numbersIn;
using test::RecordedRoom;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const cv::Affine3d bodyFromOptical(cv::Matx33d(0, 0, 1, -1, 0, 0, 0, -1, 0)),
    openGl(cv::Matx33d(1, 0, 0, 0, -1, 0, 0, 0, -1));

CheckReport checked(const Sequence& sequence, std::size_t frames = 20) {
  return checkSequence(sequence, {.maxFrames = frames});
}

/// The names of all that is not fine. Each must state its evidence and the remedy.
std::vector<std::string> faults(const CheckReport& report) {
  std::vector<std::string> names;
  for (const CheckItem& item : report.items) {
    EXPECT_NE(item.evidence, "") << item.name;
    EXPECT_EQ(item.fix.empty(), item.severity == Severity::fine) << item.name;
    if (item.severity != Severity::fine) names.push_back(item.name);
  }
  return names;
}

std::vector<std::string> faultsOf(const Sequence& sequence) {
  return faults(checked(sequence));
}

/// What people's recordings suffer from, and exactly what must be found then.
struct Fault {
  std::string name;
  std::function<void(Altered&)> spoil;
  std::vector<std::string> found;
};

void multiplyDepth(Altered& s, float factor) {
  s.alterDepth = [factor](std::size_t, cv::Mat& depth) { depth *= factor; };
}

void multiplyPositions(Altered& s, double factor) {
  s.pose([factor](cv::Affine3d t) {
    t.translation(factor * t.translation());
    return t;
  });
}

/// From the frame `first` on, each n-th.
void setPoses(Altered& s, const std::optional<Pose>& pose, std::size_t first = 0, std::size_t n = 1) {
  for (std::size_t i = first; i < s.frames.size(); i += n) s.frames[i].pose = pose;
}

const std::vector<Fault>& geometricFaults() {
  static const std::vector<Fault> faults = {
      {"nothing", [](Altered&) {}, {}},
      {"inverted",
       [](Altered& s) { s.pose([](const cv::Affine3d& t) { return t.inv(); }); },
       {"pose-inverted"}},
      {"OpenGL",
       [](Altered& s) { s.pose([](const cv::Affine3d& t) { return t * openGl; }); },
       {"pose-frame"}},
      {"robot's body",
       [](Altered& s) { s.pose([](const cv::Affine3d& t) { return t * bodyFromOptical.inv(); }); },
       {"pose-frame"}},
      {"qw first",
       [](Altered& s) {
         for (Frame& f : s.frames)
           f.pose = Pose{f.pose->x, f.pose->y, f.pose->z, f.pose->qw, f.pose->qx, f.pose->qy, f.pose->qz};
       },
       {"pose-quaternion"}},
      {"another map",
       [](Altered& s) {
         s.pose([](const cv::Affine3d& t) {
           return cv::Affine3d(cv::Vec3d(1, 2, 0.5), cv::Vec3d(10, -20, 5)) * t;
         });
       },
       {}},
      {"depth x 5", [](Altered& s) { multiplyDepth(s, 5); }, {"depth-scale"}},
      {"millimeters as meters", [](Altered& s) { multiplyDepth(s, 1000); }, {"depth-scale"}},
      {"positions in millimeters", [](Altered& s) { multiplyPositions(s, 1000); }, {"pose-scale"}},
      {"positions too small", [](Altered& s) { multiplyPositions(s, 0.6); }, {"scale"}},
      {"positions in decameters", [](Altered& s) { multiplyPositions(s, 0.1); }, {"pose-scale"}},
      {"poses a frame late", [](Altered& s) { s.shiftPoses(-1); }, {"pose-time"}},
      {"poses a frame early, without times",
       [](Altered& s) {
         s.shiftPoses(1);
         for (Frame& f : s.frames) f.timestamp.reset();
       },
       {"pose-time"}},
      {"NaN here and there", [](Altered& s) { setPoses(s, {}, 0, 4); }, {"pose-missing"}},
      {"depth that cannot be read",
       [](Altered& s) {
         s.alterDepth = [](std::size_t i, cv::Mat&) {
           if (i % 9 == 0) throw Error(ErrorCode::fileUnreadable, "gone");
         };
       },
       {"depth-missing"}},
      {"shuffled",
       [](Altered& s) {
         std::mt19937 random(7);
         for (std::size_t i = s.frames.size() - 1; i > 0; --i)
           std::swap(s.frames[i].pose, s.frames[random() % (i + 1)].pose);
       },
       {"pose-order"}},
      {"another run",
       [](Altered& s) {
         std::vector<Frame> before = s.frames;
         for (std::size_t i = 0; i < s.frames.size(); ++i)
           s.frames[i].pose = before[s.frames.size() - 1 - i].pose;
       },
       {"pose-unfit"}},
      {"shortened", [](Altered& s) { setPoses(s, {}, s.size() / 2); }, {"pose-short"}},
      {"a jump",
       [](Altered& s) {
         for (std::size_t i = s.frames.size() / 2; i < s.frames.size(); ++i) s.frames[i].pose->x += 6;
       },
       {"pose-jump"}},
      {"all the same", [](Altered& s) { setPoses(s, Pose{}); }, {"pose-constant"}},
      {"no intrinsics", [](Altered& s) { s.camera().reset(); }, {"camera-missing"}},
      {"intrinsics of an image twice as large",
       [](Altered& s) {
         CameraIntrinsics twice = s.camera()->scaledTo(2 * s.camera()->width, 2 * s.camera()->height);
         twice.width /= 2;
         twice.height /= 2;
         s.camera() = twice;
       },
       {"camera-center"}},
      {"no poses", [](Altered& s) { setPoses(s, {}); }, {}},
      {"a trajectory of NaN",
       [](Altered& s) {
         setPoses(s, {});
         s.source() = PoseSource{};
       },
       {"pose-missing"}},
      {"no depth", [](Altered& s) { s.depthThere = false; }, {}},
  };
  return faults;
}

TEST(Check, FindsExactlyWhatIsWrongInARoom) {
  const RecordedRoom room;
  for (const Fault& fault : geometricFaults()) {
    Altered spoilt(room);
    fault.spoil(spoilt);
    EXPECT_THAT(faultsOf(spoilt), ::testing::ElementsAreArray(fault.found)) << fault.name;
  }
}

TEST(Check, FindsExactlyWhatIsWrongInTheRedKitchen) {
  const auto data = test::findData("sevenscenes_redkitchen");
  ESTANCIA_NEEDS(data, "the real data set sevenscenes_redkitchen is missing");
  const auto kitchen = openSequence(*data);
  const std::set<std::string> tried{"nothing",   "inverted",           "OpenGL",
                                    "depth x 5", "poses a frame late", "another run"};
  for (const Fault& fault : geometricFaults()) {
    if (!tried.contains(fault.name)) continue;
    Altered spoilt(*kitchen);
    fault.spoil(spoilt);
    EXPECT_THAT(faultsOf(spoilt), ::testing::ElementsAreArray(fault.found)) << fault.name;
  }
}

const CheckItem& onlyFault(const CheckReport& report) {
  static const CheckItem none{};
  for (const CheckItem& item : report.items)
    if (item.severity != Severity::fine) return item;
  return none;
}

TEST(Check, ATrajectoryOfAnotherClockIsFound) {
  const RecordedRoom room;
  const double begin = *room.frame(0).timestamp, end = *room.frame(room.size() - 1).timestamp;
  const std::pair<double, double> clocks[] = {
      {begin * 1e3, end * 1e3}, {begin * 1e9, end * 1e9}, {begin + 500, end + 500}, {0, 0}};
  for (const auto& [from, to] : clocks) {
    Altered spoilt(room);
    spoilt.source() = PoseSource{std::pair(from, to)};
    const CheckReport report = checked(spoilt);
    EXPECT_THAT(faults(report), ElementsAre("pose-clock")) << from;
    EXPECT_EQ(report.count(Severity::warning), 1U);
    if (from > 1000) {
      EXPECT_THAT(numbersIn(onlyFault(report).fix), ElementsAre(from / begin));
    }
  }
  Altered ofTheSame(room);
  ofTheSame.source() = PoseSource{};
  EXPECT_THAT(faultsOf(ofTheSame), IsEmpty());
}

TEST(Check, SaysHowToMendIt) {
  const RecordedRoom room;
  Altered inverted(room), body(room), late(room), early(room), large(room);
  inverted.pose([](const cv::Affine3d& t) { return t.inv(); });
  EXPECT_THAT(onlyFault(checked(inverted)).fix, HasSubstr("R' = Rᵀ"));
  EXPECT_EQ(onlyFault(checked(inverted)).severity, Severity::problem);
  body.pose([](const cv::Affine3d& t) { return t * bodyFromOptical.inv(); });
  EXPECT_THAT(onlyFault(checked(body)).fix, HasSubstr("(-0.5, 0.5, -0.5, 0.5)"));
  // The quaternion that it names is the rotation that mends the poses.
  const cv::Affine3d named = rigidOf({0, 0, 0, -0.5, 0.5, -0.5, 0.5});
  EXPECT_EQ(cv::norm(named.matrix, bodyFromOptical.matrix, cv::NORM_INF), 0);
  late.shiftPoses(-3);
  EXPECT_THAT(numbersIn(onlyFault(checked(late)).what), ElementsAre(3, 0.1));  // frames, seconds
  EXPECT_THAT(onlyFault(checked(late)).what, HasSubstr("late"));
  early.shiftPoses(2);
  EXPECT_THAT(numbersIn(onlyFault(checked(early)).what), ElementsAre(2, 0.067));
  EXPECT_THAT(numbersIn(onlyFault(checked(early)).fix), ElementsAre(2)) << "images to leave out";
  multiplyDepth(large, 5);
  EXPECT_THAT(onlyFault(checked(large)).fix, HasSubstr("--depth-scale 5 times as large"));
}

/// What is found in a room without poses that is spoilt.
std::vector<std::string> found(const std::function<void(Altered&)>& spoil) {
  static const RecordedRoom room;
  Altered spoilt(room);
  setPoses(spoilt, {});
  spoil(spoilt);
  return faultsOf(spoilt);
}

/// Found where each depth image is changed.
std::vector<std::string> foundInDepth(const std::function<void(std::size_t, cv::Mat&)>& change) {
  return found([&](Altered& s) { s.alterDepth = change; });
}

/// Found where each image is changed.
std::vector<std::string> foundInImages(const std::function<void(std::size_t, cv::Mat&)>& change) {
  return found([&](Altered& s) { s.alterImage = change; });
}

TEST(Check, LooksAtDepthWithoutPosesToo) {
  EXPECT_THAT(found([](Altered&) {}), IsEmpty());
  EXPECT_THAT(found([](Altered& s) { multiplyDepth(s, 1000); }), ElementsAre("depth-scale"));
  EXPECT_THAT(found([](Altered& s) { multiplyDepth(s, 1e-3F); }), ElementsAre("depth-scale"));
  const std::pair<std::string, std::function<void(std::size_t, cv::Mat&)>> changes[] = {
      {"depth-missing",
       [](std::size_t i, cv::Mat&) {
         if (i % 2 == 0) throw Error(ErrorCode::fileUnreadable, "gone");
       }},
      {"depth-missing", [](std::size_t, cv::Mat&) { throw std::out_of_range("no reader means this"); }},
      {"depth-empty", [](std::size_t, cv::Mat& d) { d = 0; }},
      {"depth-size", [](std::size_t, cv::Mat& d) { d = d.colRange(0, 80).clone(); }},
      {"depth-coarse",
       [](std::size_t, cv::Mat& d) {
         d.forEach<float>([](float& z, const int*) { z = std::round(z * 25.5F) / 25.5F; });
       }},
      {"depth-saturated", [](std::size_t, cv::Mat& d) { d = cv::min(d, 2.5F); }},
      {"depth-sparse", [](std::size_t, cv::Mat& d) { d.rowRange(10, d.rows).setTo(0); }}};
  for (const auto& [name, change] : changes) EXPECT_THAT(foundInDepth(change), ElementsAre(name));
}

TEST(Check, LooksAtCameraAndImages) {
  const std::pair<CameraIntrinsics, std::vector<std::string>> cameras[] = {
      {{160, 120, 5850, 5850, 80, 60}, {"camera-view"}},
      {{1280, 720, 900, 900, 640, 360}, {"camera-size"}},
      {{160, 120, 140, 100, 80, 60}, {"camera-pixels"}},
      {{160, 120, 140, 140, 60, 80}, {}}};
  for (const auto& [camera, faults] : cameras)
    EXPECT_EQ(found([&camera = camera](Altered& s) { s.camera() = camera; }), faults);
  EXPECT_THAT(foundInImages([](std::size_t i, cv::Mat& p) { p *= i < 40 ? 0 : 1; }),
              ElementsAre("image-black", "image-frozen"));
  EXPECT_THAT(foundInImages([](std::size_t i, cv::Mat& p) {
                p.setTo(cv::Scalar::all(255 - static_cast<double>(i % 2)));
              }),
              ElementsAre("image-white"));
  EXPECT_THAT(foundInImages([](std::size_t, cv::Mat& p) { p.setTo(cv::Scalar(10, 200, 30)); }),
              ElementsAre("image-frozen"));
  EXPECT_THAT(foundInImages([](std::size_t i, cv::Mat&) {
                if (i < 2) throw Error(ErrorCode::fileUnreadable, "damaged");
              }),
              ElementsAre("image-unreadable"));
}

TEST(Check, LooksAtTimeStamps) {
  const std::pair<const char*, std::function<void(Altered&)>> changes[] = {
      {"time-order", [](Altered& s) { std::swap(s.frames[3].timestamp, s.frames[4].timestamp); }},
      {"time-doubled", [](Altered& s) { s.frames[3].timestamp = s.frames[4].timestamp; }},
      {"time-missing", [](Altered& s) { s.frames[3].timestamp.reset(); }},
      {"time-gap",
       [](Altered& s) {
         for (std::size_t i = 50; i < s.size(); ++i) *s.frames[i].timestamp += 5;
       }},
      {nullptr,
       [](Altered& s) {
         for (Frame& f : s.frames) f.timestamp.reset();
       }},
      {nullptr, [](Altered& s) { s.depthDelay = 0.012; }},
      {"depth-time", [](Altered& s) { s.depthDelay = -0.35; }},
      {"depth-time", [](Altered& s) {
         s.depthDelay = -0.35;
         s.alterDepth = [](std::size_t, cv::Mat&) { throw Error(ErrorCode::fileUnreadable, "none in time"); };
       }}};
  for (const auto& [name, change] : changes)
    EXPECT_EQ(found(change), name == nullptr ? std::vector<std::string>() : std::vector<std::string>{name});
}

TEST(Check, AGapInWhichTheRobotWaitsIsNoFault) {
  const RecordedRoom room;
  Altered waiting(room);
  for (std::size_t i = 50; i < room.size(); ++i) *waiting.frames[i].timestamp += i < 70 ? 100 : 110;
  const CheckReport report = checked(waiting);
  EXPECT_THAT(faults(report), IsEmpty());
  const auto times = std::ranges::find(report.items, "times", &CheckItem::name);
  ASSERT_NE(times, report.items.end());
  EXPECT_THAT(numbersIn(times->evidence),
              ElementsAre(90, 0.033, 2, 100, 50, 2));  // gaps, seconds, frame, meters
}

TEST(Check, JudgesPositionsBySpeedWhereThereIsNoDepth) {
  const RecordedRoom room;
  Altered millimeters(room);
  millimeters.depthThere = false;
  multiplyPositions(millimeters, 1000);
  EXPECT_THAT(faultsOf(millimeters), ElementsAre("pose-scale"));
}

TEST(Check, ClaimsNothingOfACameraThatHardlyMoves) {
  const RecordedRoom room;
  Altered still(room);
  still.pose([&](const cv::Affine3d& t) {
    const cv::Affine3d first = rigidOf(*room.frame(0).pose);
    cv::Affine3d step = first.inv() * t;
    return first * cv::Affine3d(1e-3 * step.rvec(), 1e-3 * step.translation());
  });
  still.alterDepth = [&](std::size_t, cv::Mat& depth) { depth = room.depth(0); };
  EXPECT_THAT(faultsOf(still), IsEmpty());
}

TEST(Check, TakesShortSequences) {
  for (const std::size_t size : {1U, 2U, 3U, 5U})
    EXPECT_THAT(faultsOf(RecordedRoom(size)), IsEmpty()) << size;
}

TEST(Check, LooksAtAsManyFramesAsAskedFor) {
  const RecordedRoom room;
  std::vector<std::size_t> seen;
  Altered watched(room);
  watched.depthThere = false;
  watched.alterImage = [&](std::size_t i, cv::Mat&) { seen.push_back(i); };
  checked(watched, 3);
  EXPECT_THAT(seen, ElementsAre(0, 1, 44, 45, 89)) << "the next one, too, to see whether it is frozen";
}

/// Asks to stop when so many pieces of work have begun.
struct StopsAt : Progress {
  explicit StopsAt(int count) : left(count) {}
  void begin(const std::string& /*what*/, std::size_t /*total*/, std::size_t /*done*/) override {
    if (--left == 0) requestInterrupt();
  }
  int left;
};

TEST(Check, StopsWhenAsked) {
  const RecordedRoom room(10);
  for (const int work : {1, 2}) {
    StopsAt stop(work);
    EXPECT_THAT([&] { checkSequence(room, {}, stop); }, test::FailsWith(ErrorCode::interrupted)) << work;
    EXPECT_TRUE(takeInterrupt());
  }
}

TEST(Check, RefusesToLookAtNoFrames) {
  EXPECT_THAT([] { checked(RecordedRoom(3), 0); }, test::FailsWith(ErrorCode::invalidOption));
}

TEST(Check, RaisesNoFalseAlarmOnOtherRealData) {
  const auto corridor = test::findData("corridor_vpr"), nyu = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(corridor && nyu, "the real data sets corridor_vpr and nyuv2_half are missing");
  EXPECT_THAT(faults(checked(*openSequence(*corridor / "ref"))), IsEmpty());
  const CheckReport rgbd = checked(*openSequence(*nyu));
  EXPECT_THAT(faults(rgbd), ElementsAre("depth-coarse")) << "it is: 3.9 cm a step";
  const auto rooms = std::ranges::find(rgbd.items, "rooms", &CheckItem::name);
  ASSERT_NE(rooms, rgbd.items.end());
  EXPECT_NE(rooms->evidence.find("kitchen "), std::string::npos);
  EXPECT_EQ(rgbd.count(Severity::problem), 0U);
}

}  // namespace
}  // namespace estancia
