// SPDX-License-Identifier: Apache-2.0
#include "values.hpp"

#include "arrays.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"

namespace estancia::python {
namespace {

void require(const py::object& object, const char* name) {
  if (!py::isinstance(object, py::module_::import("estancia").attr(name)))
    fail(ErrorCode::invalidInput, "an estancia.{} is needed, not {}", name,
         py::str(py::type::of(object)).cast<std::string>());
}

template <class Value>
Value get(const py::object& object, const char* name) {
  return object.attr(name).cast<Value>();
}

}  // namespace

py::object toPython(const Pose& p) {
  return make("Pose", p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw);
}

py::object toPython(const std::optional<Pose>& pose) {
  return pose ? toPython(*pose) : py::object(py::none());
}

py::object toPython(const cv::Affine3d& transform) {
  py::array_t<double> matrix({4, 4});
  for (int i = 0; i < 16; ++i) matrix.mutable_data()[i] = transform.matrix.val[i];
  return matrix;
}

py::object toPython(const CameraIntrinsics& c) {
  return make("Camera", c.width, c.height, c.fx, c.fy, c.cx, c.cy);
}

py::object toPython(const Frame& frame) {
  return make("Frame", frame.name, frame.timestamp, toPython(frame.pose), frame.room);
}

py::object toPython(const LabelProbability& label) {
  return make("LabelProbability", label.label, static_cast<double>(label.probability));
}

py::object toPython(const RoomProbability& room) {
  return make("RoomProbability", room.room, room.probability);
}

py::object toPython(const cv::Rect& box) {
  return py::make_tuple(box.x, box.y, box.width, box.height);
}

py::object toPython(const cv::Point3d& p) {
  return py::make_tuple(p.x, p.y, p.z);
}

py::object toPython(const cv::Point2d& p) {
  return py::make_tuple(p.x, p.y);
}

std::optional<Pose> poseFrom(const py::object& pose) {
  if (pose.is_none()) return {};
  require(pose, "Pose");
  return Pose{get<double>(pose, "x"),  get<double>(pose, "y"),  get<double>(pose, "z"),
              get<double>(pose, "qx"), get<double>(pose, "qy"), get<double>(pose, "qz"),
              get<double>(pose, "qw")};
}

CameraIntrinsics cameraFrom(const py::object& camera) {
  require(camera, "Camera");
  return {get<int>(camera, "width"), get<int>(camera, "height"), get<double>(camera, "fx"),
          get<double>(camera, "fy"), get<double>(camera, "cx"),  get<double>(camera, "cy")};
}

Frame frameFrom(const py::object& frame) {
  require(frame, "Frame");
  return {get<std::string>(frame, "name"), get<std::optional<double>>(frame, "timestamp"),
          poseFrom(frame.attr("pose")), get<std::string>(frame, "room")};
}

cv::Affine3d transformFrom(const py::object& matrix) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(matrix);
  if (!array || array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4) {
    PyErr_Clear();
    fail(ErrorCode::invalidInput, "a transform is a matrix of 4 rows and 4 columns");
  }
  return cv::Affine3d(cv::Matx44d(array.data()));
}

}  // namespace estancia::python
