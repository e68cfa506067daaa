// SPDX-License-Identifier: Apache-2.0
// RGB-D odometry: the camera's poses, of a recording or frame by frame.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/odometry/rgbd.hpp"
#include "estancia/odometry/tracker.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "options.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

py::object trajectoryOf(const RgbdTrajectory& t) {
  const auto untracked = [](const std::vector<RgbdTrajectory::Untracked>& frames) {
    return listOf(frames, [](const auto& each) { return py::make_tuple(each.frame, each.why); });
  };
  return make("RgbdTrajectory",
              listOf(t.poses, [](const std::optional<Pose>& pose) { return toPython(pose); }),
              untracked(t.lost), untracked(t.bridged), t.keyframes, t.loops, t.notes);
}

py::object trackSequence(const Sequence& sequence, const py::dict& given, const py::object& callback) {
  const auto options = optionsFrom<RgbdOptions>(given);
  const auto progress = makeProgress(callback);
  return trajectoryOf(longCall([&] { return trackRgbd(sequence, options, {}, *progress); }));
}

py::object addFrame(RgbdTracker& tracker, const py::object& imageArray, const py::object& depthArray,
                    const std::optional<double>& timestamp, const py::object& prior) {
  const BorrowedImage image = borrowImage(imageArray), depth = borrowDepth(depthArray);
  FrameFacts facts;
  facts.timestamp = timestamp;
  facts.prior = poseFrom(prior);
  const auto placed = longCall([&] { return tracker.add(image.pixels, depth.pixels, facts); });
  return make("TrackedFrame", toPython(placed.pose), placed.why);
}

}  // namespace

void bindOdometry(py::module_& m) {
  m.def("track_rgbd", trackSequence);
  py::class_<RgbdTracker>(m, "RgbdTracker")
      .def(py::init([](const py::object& camera, const py::dict& given) {
        return std::make_unique<RgbdTracker>(cameraFrom(camera), optionsFrom<RgbdOptions>(given));
      }))
      .def("add", addFrame)
      .def("__len__", &RgbdTracker::size)
      .def("at",
           [](const RgbdTracker& tracker, std::size_t frame) {
             const auto placed = tracker.at(frame);
             return make("TrackedFrame", toPython(placed.pose), placed.why);
           })
      .def_property_readonly("revision", &RgbdTracker::revision)
      .def("settle", [](RgbdTracker& tracker) { longCall([&] { tracker.settle(); }); })
      .def("trajectory", [](const RgbdTracker& tracker) {
        return trajectoryOf(longCall([&] { return tracker.trajectory(); }));
      });
}

}  // namespace estancia::python
