// Arrays: images, depth, points and probabilities between NumPy and the library, without copies where that is
// safe. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia::python {

namespace py = pybind11;

/// An image that NumPy owns: `pixels` is valid as long as this lives.
struct BorrowedImage {
  py::object owner;
  cv::Mat pixels;
};

/// height×width(×1, 3 or 4) of uint8 or uint16, BGR; rows may be apart, other layouts are copied. None:
/// empty. Throws Error (invalidInput) on other arrays; `what` names them ("image").
BorrowedImage borrowImage(const py::object& array, std::string_view what = "image");
/// height×width of float32 [m]; float64 is converted. None: empty. Throws Error (invalidInput) on other
/// arrays.
BorrowedImage borrowDepth(const py::object& array);
/// An array that shares the image's pixels and keeps them alive; a copy if the image does not own them.
py::array arrayOf(const cv::Mat& image);

/// A row of probabilities, or features, as float32; other numbers are converted. Throws Error (invalidInput)
/// on what is no list of numbers.
std::vector<float> rowOf(const py::object& array, std::string_view what);
/// N×L of float32. Throws Error (invalidInput) on other shapes.
DescriptorMatrix matrixOf(const py::object& array, std::string_view what);
py::array arrayOf(const std::vector<float>& row);

/// An array of `shape` over numbers that `owner` keeps alive; it cannot be written, as the library relies on
/// them.
template <class Number>
py::array viewOf(const Number* numbers, std::vector<py::ssize_t> shape, const py::object& owner) {
  py::array view(py::dtype::of<Number>(), std::move(shape), {}, numbers, owner);
  py::detail::array_proxy(view.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return view;
}

/// An array whose numbers a shared object keeps alive.
template <class Number, class Owner>
py::array viewOf(const Number* numbers, std::vector<py::ssize_t> shape, std::shared_ptr<Owner> owner) {
  const py::capsule keeper(new std::shared_ptr<Owner>(std::move(owner)),
                           [](void* kept) { delete static_cast<std::shared_ptr<Owner>*>(kept); });
  return viewOf(numbers, std::move(shape), keeper);
}

/// A matrix that is handed over.
py::array arrayOf(DescriptorMatrix matrix);

}  // namespace estancia::python
