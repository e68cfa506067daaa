// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <sstream>

#include "check/recorded_room.hpp"
#include "estancia/check/check.hpp"
#include "estancia/core/error.hpp"
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

const cv::Affine3d kBodyFromOptical(cv::Matx33d(0, 0, 1, -1, 0, 0, 0, -1, 0)),
    kOpenGl(cv::Matx33d(1, 0, 0, 0, -1, 0, 0, 0, -1));

CheckReport checked(const Sequence& sequence, std::size_t frames = 20) {
  return checkSequence(sequence, {.maxFrames = frames});
}

/// The names of all that is not fine. Each must say how it is known and what to do.
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

const std::vector<Fault>& geometricFaults() {
  static const std::vector<Fault> faults = {
      {"nothing", [](Altered&) {}, {}},
      {"inverted",
       [](Altered& s) { s.pose([](const cv::Affine3d& t) { return t.inv(); }); },
       {"pose-inverted"}},
      {"OpenGL",
       [](Altered& s) { s.pose([](const cv::Affine3d& t) { return t * kOpenGl; }); },
       {"pose-frame"}},
      {"robot's body",
       [](Altered& s) { s.pose([](const cv::Affine3d& t) { return t * kBodyFromOptical.inv(); }); },
       {"pose-frame"}},
      {"inverted robot's body",
       [](Altered& s) { s.pose([](const cv::Affine3d& t) { return (t * kBodyFromOptical.inv()).inv(); }); },
       {"pose-inverted", "pose-frame"}},
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
      {"depth / 5", [](Altered& s) { multiplyDepth(s, 0.2F); }, {"depth-scale"}},
      {"millimeters as meters", [](Altered& s) { multiplyDepth(s, 1000); }, {"depth-scale"}},
      {"positions in millimeters", [](Altered& s) { multiplyPositions(s, 1000); }, {"pose-scale"}},
      {"positions too small", [](Altered& s) { multiplyPositions(s, 0.6); }, {"scale"}},
      {"poses a frame late", [](Altered& s) { s.shiftPoses(-1); }, {"pose-time"}},
      {"poses two frames early", [](Altered& s) { s.shiftPoses(2); }, {"pose-time"}},
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
      {"shortened",
       [](Altered& s) {
         for (std::size_t i = s.frames.size() / 2; i < s.frames.size(); ++i) s.frames[i].pose.reset();
       },
       {"pose-short"}},
      {"NaN here and there",
       [](Altered& s) {
         for (std::size_t i = 5; i < s.frames.size(); i += 11) s.frames[i].pose.reset();
       },
       {"pose-missing"}},
      {"a jump",
       [](Altered& s) {
         for (std::size_t i = s.frames.size() / 2; i < s.frames.size(); ++i) s.frames[i].pose->x += 6;
       },
       {"pose-jump"}},
      {"all the same",
       [](Altered& s) {
         for (Frame& f : s.frames) f.pose = Pose{};
       },
       {"pose-constant"}},
      {"no intrinsics", [](Altered& s) { s.camera().reset(); }, {"camera-missing"}},
      {"intrinsics of an image twice as large",
       [](Altered& s) {
         CameraIntrinsics twice = s.camera()->scaledTo(2 * s.camera()->width, 2 * s.camera()->height);
         twice.width /= 2;
         twice.height /= 2;
         s.camera() = twice;
       },
       {"camera-center"}},
      {"no poses",
       [](Altered& s) {
         for (Frame& f : s.frames) f.pose.reset();
       },
       {}},
      {"a trajectory of NaN",
       [](Altered& s) {
         for (Frame& f : s.frames) f.pose.reset();
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
  for (const Fault& fault : geometricFaults()) {
    Altered spoilt(*kitchen);
    fault.spoil(spoilt);
    EXPECT_THAT(faultsOf(spoilt), ::testing::ElementsAreArray(fault.found)) << fault.name;
  }
}

/// Three images with depth, one a second.
class ImageFolder {
 public:
  ImageFolder() {
    cv::Mat image(48, 64, CV_8UC3), depth(48, 64, CV_16U);
    for (const char* kind : {"rgb", "depth"}) std::filesystem::create_directory(folder_ / kind);
    for (const std::string name : {"1.000.png", "2.000.png", "3.000.png"}) {
      cv::randu(image, 0, 255);
      cv::randu(depth, 1000, 3000);
      cv::imwrite(folder_ / "rgb" / name, image);
      cv::imwrite(folder_ / "depth" / name, depth);
    }
    test::writeFile(folder_ / "intrinsics.txt", "60 60 31.5 23.5\n");
  }
  CheckReport checkWith(const std::string& trajectory) const {
    test::writeFile(folder_ / "poses.txt", trajectory);
    return checked(*openSequence(folder_.path()));
  }

 private:
  test::ScratchFolder folder_;
};

TEST(Check, ATrajectoryWithoutOnePoseIsAProblem) {
  const ImageFolder folder;
  const auto checked = [&](const std::string& values) {
    return folder.checkWith("1.0" + values + "\n2.0" + values + "\n3.0" + values + "\n");
  };
  for (const char* values : {" nan nan nan nan nan nan nan", " 1 2 3 0 0 0 0"}) {
    const CheckReport report = checked(values);
    EXPECT_THAT(faults(report), ElementsAre("pose-missing")) << values;
    EXPECT_EQ(report.count(Severity::problem), 1U) << values;
  }
  EXPECT_THAT(faults(checked(" 1 2 3 0 0 0 1")), ElementsAre("pose-constant"));
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
  const auto fix = [&](double from, double to) {
    Altered spoilt(room);
    spoilt.source() = PoseSource{std::pair(from, to)};
    const CheckReport report = checked(spoilt);
    EXPECT_THAT(faults(report), ElementsAre("pose-clock"));
    EXPECT_EQ(report.count(Severity::warning), 1U);
    return onlyFault(report).fix;
  };
  EXPECT_THAT(numbersIn(fix(begin * 1e3, end * 1e3)), ElementsAre(1e3));
  EXPECT_THAT(numbersIn(fix(begin * 1e9, end * 1e9)), ElementsAre(1e9));
  EXPECT_THAT(fix(begin + 500, end + 500), HasSubstr("--max-pose-gap"));
  EXPECT_THAT(fix(0, 0), HasSubstr("--max-pose-gap"));
  Altered ofTheSame(room);
  ofTheSame.source() = PoseSource{};
  EXPECT_THAT(faultsOf(ofTheSame), IsEmpty());
}

TEST(Check, TheFoldersTrajectoryOfAnotherClockIsFound) {
  const CheckReport report =
      ImageFolder().checkWith("1000 0 0 0 0 0 0 1\n2000 1 0 0 0 0 0 1\n3000 2 0 0 0 0 0 1\n");
  EXPECT_THAT(faults(report), ElementsAre("pose-clock"));
  EXPECT_THAT(numbersIn(onlyFault(report).fix), ElementsAre(1000));
  EXPECT_THAT(numbersIn(onlyFault(report).evidence), ElementsAre(1000, 3000, 3, 1, 3));
}

TEST(Check, SaysHowToMendIt) {
  const RecordedRoom room;
  Altered inverted(room), body(room), late(room), coarse(room), large(room);
  inverted.pose([](const cv::Affine3d& t) { return t.inv(); });
  EXPECT_THAT(onlyFault(checked(inverted)).fix, HasSubstr("R' = Rᵀ"));
  EXPECT_EQ(onlyFault(checked(inverted)).severity, Severity::problem);
  body.pose([](const cv::Affine3d& t) { return t * kBodyFromOptical.inv(); });
  EXPECT_THAT(onlyFault(checked(body)).fix, HasSubstr("(-0.5, 0.5, -0.5, 0.5)"));
  // The quaternion that it names is the rotation that mends the poses.
  const cv::Affine3d named = rigidOf({0, 0, 0, -0.5, 0.5, -0.5, 0.5});
  EXPECT_EQ(cv::norm(named.matrix, kBodyFromOptical.matrix, cv::NORM_INF), 0);
  late.shiftPoses(-3);
  EXPECT_THAT(numbersIn(onlyFault(checked(late)).what), ElementsAre(3, 0.1));  // frames, seconds
  EXPECT_THAT(onlyFault(checked(late)).what, HasSubstr("late"));
  multiplyDepth(large, 5);
  EXPECT_THAT(onlyFault(checked(large)).fix, HasSubstr("--depth-scale 5 times as large"));
}

TEST(Check, LooksAtDepthWithoutPosesToo) {
  const RecordedRoom room;
  const auto found = [&room](const std::function<void(Altered&)>& spoil) {
    Altered spoilt(room);
    for (Frame& f : spoilt.frames) f.pose.reset();
    spoil(spoilt);
    return faultsOf(spoilt);
  };
  EXPECT_THAT(found([](Altered&) {}), IsEmpty());
  EXPECT_THAT(found([](Altered& s) { multiplyDepth(s, 1000); }), ElementsAre("depth-scale"));
  EXPECT_THAT(found([](Altered& s) { multiplyDepth(s, 1e-3F); }), ElementsAre("depth-scale"));
  EXPECT_THAT(found([](Altered& s) {
                s.alterDepth = [](std::size_t i, cv::Mat& depth) {
                  if (i % 2 == 0) throw Error(ErrorCode::fileUnreadable, "gone");
                  depth *= 1;
                };
              }),
              ElementsAre("depth-missing"));
  EXPECT_THAT(found([](Altered& s) {
                s.alterDepth = [](std::size_t, cv::Mat&) { throw Error(ErrorCode::fileUnreadable, "gone"); };
              }),
              ElementsAre("depth-missing"));
  EXPECT_THAT(found([](Altered& s) {
                s.alterDepth = [](std::size_t, cv::Mat&) { throw std::out_of_range("no reader means this"); };
              }),
              ElementsAre("depth-missing"));
  EXPECT_THAT(found([](Altered& s) { s.alterDepth = [](std::size_t, cv::Mat& d) { d = 0; }; }),
              ElementsAre("depth-empty"));
  EXPECT_THAT(found([](Altered& s) {
                s.alterDepth = [](std::size_t, cv::Mat& d) { d = d.colRange(0, 80).clone(); };
              }),
              ElementsAre("depth-size"));
  EXPECT_THAT(found([](Altered& s) {
                s.alterDepth = [](std::size_t, cv::Mat& d) {
                  d.forEach<float>([](float& z, const int*) { z = std::round(z * 25.5F) / 25.5F; });
                };
              }),
              ElementsAre("depth-coarse"));
  EXPECT_THAT(found([](Altered& s) { s.alterDepth = [](std::size_t, cv::Mat& d) { d = cv::min(d, 2.5F); }; }),
              ElementsAre("depth-saturated"));
  EXPECT_THAT(found([](Altered& s) {
                s.alterDepth = [](std::size_t, cv::Mat& d) { d.rowRange(10, d.rows).setTo(0); };
              }),
              ElementsAre("depth-sparse"));
}

TEST(Check, DepthThatCannotBeReadIsFoundWhateverItsStamps) {
  const RecordedRoom room;
  Altered spoilt(room);
  spoilt.depthDelay = 0.001;
  const auto tear = [&spoilt](std::size_t every) {
    spoilt.alterDepth = [every](std::size_t i, cv::Mat&) {
      if (i % every == 0) throw Error(ErrorCode::malformedFile, "torn");
    };
    return onlyFault(checked(spoilt, 90));
  };
  EXPECT_EQ(tear(1).severity, Severity::problem);
  EXPECT_EQ(tear(1).name, "depth-missing");
  EXPECT_EQ(tear(2).severity, Severity::problem);
  EXPECT_THAT(numbersIn(tear(2).evidence), ElementsAre(45, 90));
  EXPECT_THAT(tear(2).evidence, HasSubstr("torn"));
  EXPECT_EQ(tear(30).severity, Severity::warning);
  EXPECT_THAT(numbersIn(tear(30).evidence), ElementsAre(3, 90));
  spoilt.depthDelay = 0.5;  // no image's own: said once
  tear(1);
  EXPECT_THAT(faultsOf(spoilt), ElementsAre("depth-time"));
}

TEST(Check, LooksAtCameraAndImages) {
  const RecordedRoom room;
  const auto found = [&room](const std::function<void(Altered&)>& spoil) {
    Altered spoilt(room);
    for (Frame& f : spoilt.frames) f.pose.reset();
    spoil(spoilt);
    return faultsOf(spoilt);
  };
  EXPECT_THAT(found([](Altered& s) { s.camera() = CameraIntrinsics{160, 120, 5850, 5850, 80, 60}; }),
              ElementsAre("camera-view"));
  EXPECT_THAT(found([](Altered& s) { s.camera() = CameraIntrinsics{1280, 720, 900, 900, 640, 360}; }),
              ElementsAre("camera-size"));
  EXPECT_THAT(found([](Altered& s) { s.camera() = CameraIntrinsics{160, 120, 140, 100, 80, 60}; }),
              ElementsAre("camera-pixels"));
  EXPECT_THAT(found([](Altered& s) { s.camera() = CameraIntrinsics{160, 120, 140, 140, 60, 80}; }),
              IsEmpty());
  EXPECT_THAT(
      found([](Altered& s) { s.alterImage = [](std::size_t i, cv::Mat& p) { p *= i < 40 ? 0 : 1; }; }),
      ElementsAre("image-black", "image-frozen"));
  EXPECT_THAT(found([](Altered& s) {
                s.alterImage = [](std::size_t i, cv::Mat& p) {
                  p.setTo(cv::Scalar::all(255 - static_cast<double>(i % 2)));
                };
              }),
              ElementsAre("image-white"));
  EXPECT_THAT(found([](Altered& s) {
                s.alterImage = [](std::size_t, cv::Mat& p) { p.setTo(cv::Scalar(10, 200, 30)); };
              }),
              ElementsAre("image-frozen"));
  EXPECT_THAT(found([](Altered& s) {
                s.alterImage = [](std::size_t i, cv::Mat&) {
                  if (i == 0) throw Error(ErrorCode::fileUnreadable, "damaged");
                };
              }),
              ElementsAre("image-unreadable"));
}

TEST(Check, LooksAtTimeStamps) {
  const RecordedRoom room;
  const auto found = [&room](const std::function<void(Altered&)>& spoil) {
    Altered spoilt(room);
    for (Frame& f : spoilt.frames) f.pose.reset();
    spoil(spoilt);
    return faultsOf(spoilt);
  };
  EXPECT_THAT(found([](Altered& s) { std::swap(s.frames[3].timestamp, s.frames[4].timestamp); }),
              ElementsAre("time-order"));
  EXPECT_THAT(found([](Altered& s) { s.frames[3].timestamp = s.frames[4].timestamp; }),
              ElementsAre("time-doubled"));
  EXPECT_THAT(found([](Altered& s) { s.frames[3].timestamp.reset(); }), ElementsAre("time-missing"));
  EXPECT_THAT(found([](Altered& s) {
                for (std::size_t i = 50; i < s.size(); ++i) *s.frames[i].timestamp += 5;
              }),
              ElementsAre("time-gap"));
  EXPECT_THAT(found([](Altered& s) {
                for (Frame& f : s.frames) f.timestamp.reset();
              }),
              IsEmpty());
  EXPECT_THAT(found([](Altered& s) { s.depthDelay = 0.012; }), IsEmpty());
  EXPECT_THAT(found([](Altered& s) { s.depthDelay = -0.35; }), ElementsAre("depth-time"));
}

TEST(Check, AGapInWhichTheCameraWaitedIsNoFaultButSaid) {
  const RecordedRoom room;
  Altered waiting(room);
  for (std::size_t i = 50; i < waiting.size(); ++i) *waiting.frames[i].timestamp += 100;
  const auto times = [&] {
    const CheckReport report = checked(waiting);
    EXPECT_THAT(faults(report), IsEmpty());
    const auto item = std::ranges::find(report.items, "times", &CheckItem::name);
    return item == report.items.end() ? "" : item->evidence;
  };
  EXPECT_THAT(times(), HasSubstr("gaps: 1, the longest 100.0 s before frame 50"));
  waiting.frames = Altered(room).frames;
  EXPECT_EQ(times().find("gaps"), std::string::npos);
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

TEST(Check, RefusesToLookAtNoFrames) {
  EXPECT_THAT([] { checked(RecordedRoom(3), 0); },
              test::FailsWith(ErrorCode::invalidOption, "check.max-frames", "0"));
}

TEST(Check, RaisesNoFalseAlarmOnOtherRealData) {
  const auto corridor = test::findData("corridor_vpr"), nyu = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(corridor && nyu, "the real data sets corridor_vpr and nyuv2_half are missing");
  EXPECT_THAT(faults(checked(*openSequence(*corridor / "ref"), 60)), IsEmpty());
  EXPECT_THAT(faults(checked(*openSequence(*corridor / "query"), 60)), IsEmpty());
  EXPECT_THAT(faults(checked(*openSequence(*nyu / "rgb"), 60)), IsEmpty());
  const CheckReport rgbd = checked(*openSequence(*nyu), 60);
  EXPECT_THAT(faults(rgbd), ElementsAre("depth-coarse")) << "it is: 3.9 cm a step";
  EXPECT_EQ(rgbd.count(Severity::problem), 0U);
}

TEST(Check, RaisesNoFalseAlarmOnPanoramas) {
  const auto panoramas = test::findFetched("panoramas");
  ESTANCIA_NEEDS(panoramas, "the panoramas are not here; script/bootstrap fetches them");
  EXPECT_THAT(faults(checked(*openSequence(*panoramas), 24)), IsEmpty());
}

TEST(Check, RaisesNoFalseAlarmOnTheTrajectoriesOfIdol) {
  const auto data = test::findData("idol2_meta");
  ESTANCIA_NEEDS(data, "the real data set idol2_meta is missing");
  for (const auto& file : std::filesystem::directory_iterator(*data)) {
    if (file.path().extension() != ".csv" || file.path().filename() == "rooms.csv") continue;
    std::vector<Frame> frames;
    std::istringstream lines(test::readFile(file.path()));
    std::string line;
    std::getline(lines, line);  // frame,timestamp,x,y,theta,room
    while (std::getline(lines, line)) {
      double time = 0, x = 0, y = 0, theta = 0;
      ASSERT_EQ(std::sscanf(line.c_str(), "%*[^,],%lf,%lf,%lf,%lf", &time, &x, &y, &theta), 4) << line;
      frames.push_back({fmt::format("frame {}", frames.size()), time, Pose::planar(x, y, theta), ""});
    }
    for (const std::string& name : faults(checked(test::FramesOnly(frames))))
      ADD_FAILURE() << file.path().filename() << ": " << name;
  }
}

}  // namespace
}  // namespace estancia
