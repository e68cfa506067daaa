// SPDX-License-Identifier: Apache-2.0
// Recognition: known objects and their poses in point clouds.
#include "call.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "options.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

py::object detectionOf(const Detection& d) {
  return make("Detection", d.model, toPython(d.pose), toPython(d.pose * cv::Point3d(d.center)), d.inliers,
              d.confidence, d.falseAlarmRate);
}

std::unique_ptr<Recognizer> makeRecognizer(const py::object& preset, const py::dict& given) {
  const auto base =
      preset.is_none() ? RecognitionOptions{} : RecognitionOptions::preset(preset.cast<std::string>());
  return std::make_unique<Recognizer>(optionsFrom<RecognitionOptions>(given, base));
}

/// The detections, and what may be there.
py::tuple detect(const Recognizer& recognizer, const PointCloud& scene, const py::object& callback) {
  const auto progress = makeProgress(callback);
  std::vector<Detection> maybe;
  const auto found = longCall([&] { return recognizer.detect(scene, *progress, &maybe); });
  return py::make_tuple(listOf(found, detectionOf), listOf(maybe, detectionOf));
}

}  // namespace

void bindRecognition(py::module_& m) {
  py::class_<Recognizer>(m, "Recognizer")
      .def(py::init(&makeRecognizer))
      .def("add_model", [](Recognizer& recognizer, const std::string& name,
                           const PointCloud& cloud) { longCall([&] { recognizer.addModel(name, cloud); }); })
      .def("detect", detect);
  m.def("recognition_presets", [] {
    return listOf(RecognitionOptions::presets(),
                  [](const Choice& choice) { return py::make_tuple(choice.name, choice.explanation); });
  });
}

}  // namespace estancia::python
