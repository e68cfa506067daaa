// Values: poses, cameras, frames and answers as the dataclasses of the Python package, and back.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <opencv2/core/affine.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia::python {

namespace py = pybind11;
using namespace pybind11::literals;

/// An object of the public class `name` of the package; all its arguments are given by position.
template <class... Arguments>
py::object make(const char* name, Arguments&&... arguments) {
  return py::module_::import("estancia").attr(name)(std::forward<Arguments>(arguments)...);
}

/// A list of what `convert` makes of each.
template <class Range, class Convert>
py::list listOf(const Range& values, Convert&& convert) {
  py::list list;
  for (const auto& value : values) list.append(convert(value));
  return list;
}

py::object toPython(const Pose& pose);
py::object toPython(const std::optional<Pose>& pose);
py::object toPython(const cv::Affine3d& transform);
py::object toPython(const CameraIntrinsics& camera);
py::object toPython(const Frame& frame);
py::object toPython(const LabelProbability& label);
py::object toPython(const RoomProbability& room);
py::object toPython(const cv::Rect& box);
py::object toPython(const cv::Point3d& point);
py::object toPython(const cv::Point2d& point);
template <class Value>
py::list toPython(const std::vector<Value>& values) {
  return listOf(values, [](const Value& value) { return toPython(value); });
}
/// None where there is none.
template <class Value>
py::object toPython(const std::optional<Value>& value) {
  return value ? toPython(*value) : py::object(py::none());
}

/// Throw Error (invalidInput) on other objects; None is nothing.
std::optional<Pose> poseFrom(const py::object& pose);
CameraIntrinsics cameraFrom(const py::object& camera);
Frame frameFrom(const py::object& frame);
cv::Affine3d transformFrom(const py::object& matrix);

void bindSequences(py::module_& m);
void bindLabelers(py::module_& m);
void bindLabels(py::module_& m);
void bindMapping(py::module_& m);
void bindDrives(py::module_& m);
void bindMaps(py::module_& m);
void bindZones(py::module_& m);
void bindClassifiers(py::module_& m);
void bindClouds(py::module_& m);
void bindRecognition(py::module_& m);
void bindObjects(py::module_& m);
void bindOdometry(py::module_& m);
void bindStatistics(py::module_& m);
void bindWords(py::module_& m);
void bindLive(py::module_& m);
void bindOptions(py::module_& m);

}  // namespace estancia::python
