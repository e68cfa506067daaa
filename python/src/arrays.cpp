// SPDX-License-Identifier: Apache-2.0
#include "arrays.hpp"

#include <fmt/format.h>

#include <string>

#include "estancia/core/error.hpp"
#include "estancia/core/fail.hpp"

namespace estancia::python {
namespace {

std::string describeArray(const py::object& object) {
  if (!py::isinstance<py::array>(object))
    return py::str(py::type::of(object).attr("__name__")).cast<std::string>();
  const auto array = py::reinterpret_borrow<py::array>(object);
  return fmt::format("an array of {} of shape {}", py::str(array.dtype()).cast<std::string>(),
                     py::str(array.attr("shape")).cast<std::string>());
}

/// Whether the rows are in order and the pixels in each row lie side by side.
bool hasRows(const py::array& array) {
  py::ssize_t expected = array.itemsize();
  for (py::ssize_t axis = array.ndim() - 1; axis > 0; --axis) {
    if (array.shape(axis) > 1 && array.strides(axis) != expected) return false;
    expected *= array.shape(axis);
  }
  return array.shape(0) <= 1 || array.strides(0) >= expected;
}

py::array contiguous(const py::array& array) {
  return py::module_::import("numpy").attr("ascontiguousarray")(array);
}

cv::Mat headerOf(const py::array& array, int type) {
  constexpr py::ssize_t maxPixels = py::ssize_t{1} << 30;  // cv::Mat counts with int
  if (array.shape(0) > maxPixels / array.shape(1))
    fail(ErrorCode::tooLarge, "an image of {} × {} pixels is too large", array.shape(1), array.shape(0));
  const auto step =
      array.shape(0) > 1 ? static_cast<std::size_t>(array.strides(0)) : std::size_t{cv::Mat::AUTO_STEP};
  return {static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), type,
          const_cast<void*>(array.data()), step};
}

py::array numbersOf(const py::object& object, std::string_view what) {
  const auto array = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(object);
  if (!array) {
    PyErr_Clear();
    fail(ErrorCode::invalidInput, "{} must be numbers, not {}", what, describeArray(object));
  }
  return array;
}

}  // namespace

BorrowedImage borrowImage(const py::object& object, std::string_view what) {
  if (object.is_none()) return {};
  const bool isArray = py::isinstance<py::array>(object);
  auto array = isArray ? py::reinterpret_borrow<py::array>(object) : py::array();
  const bool bytes = isArray && array.dtype().is(py::dtype::of<std::uint8_t>());
  const bool words = isArray && array.dtype().is(py::dtype::of<std::uint16_t>());
  const py::ssize_t channels = isArray && array.ndim() == 3 ? array.shape(2) : 1;
  if ((!bytes && !words) || array.ndim() < 2 || array.ndim() > 3 || array.size() == 0 ||
      (channels != 1 && channels != 3 && channels != 4))
    fail(ErrorCode::invalidInput,
         "the {} must be an array of uint8 or uint16 of shape (height, width) or (height, width, 3), BGR; "
         "got {}",
         what, describeArray(object));
  if (!hasRows(array)) array = contiguous(array);
  return {array, headerOf(array, CV_MAKETYPE(bytes ? CV_8U : CV_16U, static_cast<int>(channels)))};
}

BorrowedImage borrowDepth(const py::object& object) {
  if (object.is_none()) return {};
  auto array = py::isinstance<py::array>(object) ? py::reinterpret_borrow<py::array>(object) : py::array();
  if (py::isinstance<py::array>(object) && array.dtype().is(py::dtype::of<double>()))
    array = numbersOf(object, "depth");
  if (!array.dtype().is(py::dtype::of<float>()) || array.ndim() != 2 || array.size() == 0)
    fail(ErrorCode::invalidInput,
         "depth must be an array of float32 of shape (height, width) in meters (millimeters: array / "
         "1000.0); got {}",
         describeArray(object));
  if (!hasRows(array)) array = contiguous(array);
  return {array, headerOf(array, CV_32F)};
}

py::array arrayOf(const cv::Mat& image) {
  const auto type = [&]() -> py::dtype {
    switch (image.depth()) {
      case CV_8U:
        return py::dtype::of<std::uint8_t>();
      case CV_16U:
        return py::dtype::of<std::uint16_t>();
      case CV_32S:
        return py::dtype::of<std::int32_t>();
      case CV_32F:
        return py::dtype::of<float>();
      default:
        fail(ErrorCode::invalidInput, "images of type {} have no array", cv::depthToString(image.depth()));
    }
  }();
  if (image.empty()) return py::array(type, std::vector<py::ssize_t>{0, 0});
  // Pixels that the library only borrowed may be gone when the array is looked at.
  const cv::Mat owned = image.u == nullptr ? image.clone() : image;
  std::vector<py::ssize_t> shape{image.rows, image.cols};
  std::vector<py::ssize_t> strides{static_cast<py::ssize_t>(owned.step[0]),
                                   static_cast<py::ssize_t>(image.elemSize())};
  if (image.channels() > 1) {
    shape.push_back(image.channels());
    strides.push_back(static_cast<py::ssize_t>(image.elemSize1()));
  }
  const py::capsule keeper(new cv::Mat(owned), [](void* kept) { delete static_cast<cv::Mat*>(kept); });
  return {type, std::move(shape), std::move(strides), owned.data, keeper};
}

std::vector<float> rowOf(const py::object& object, std::string_view what) {
  const py::array array = numbersOf(object, what);
  if (array.ndim() != 1)
    fail(ErrorCode::invalidInput, "{} must be one row of numbers, not {}", what, describeArray(object));
  const auto* numbers = static_cast<const float*>(array.data());
  return {numbers, numbers + array.size()};
}

DescriptorMatrix matrixOf(const py::object& object, std::string_view what) {
  const py::array array = numbersOf(object, what);
  if (array.ndim() != 2)
    fail(ErrorCode::invalidInput, "{} must be rows of numbers, not {}", what, describeArray(object));
  const auto rows = static_cast<std::size_t>(array.shape(0)),
             columns = static_cast<std::size_t>(array.shape(1));
  DescriptorMatrix matrix(columns);
  matrix.reserve(rows);
  const auto* numbers = static_cast<const float*>(array.data());
  for (std::size_t i = 0; i < rows; ++i) matrix.append({numbers + i * columns, columns});
  return matrix;
}

py::array arrayOf(const std::vector<float>& row) {
  return py::array_t<float>(static_cast<py::ssize_t>(row.size()), row.data());
}

py::array arrayOf(DescriptorMatrix matrix) {
  const auto owner = std::make_shared<const DescriptorMatrix>(std::move(matrix));
  return viewOf(owner->values().data(),
                {static_cast<py::ssize_t>(owner->size()), static_cast<py::ssize_t>(owner->labels())}, owner);
}

}  // namespace estancia::python
