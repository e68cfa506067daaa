// SPDX-License-Identifier: Apache-2.0
// Objects: samples collected from drives, shape classifiers trained on them, and their answers.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/objects/collect.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/objects/training.hpp"
#include "estancia/readers/object_views.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "options.hpp"
#include "sequence_labels.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

py::object collect(const Sequence& sequence, const std::filesystem::path& folder, const py::dict& given,
                   const py::object& callback) {
  const auto options = optionsFrom<CollectOptions>(given);
  const auto progress = makeProgress(callback);
  std::vector<std::string> problems;
  const Collected c =
      longCall([&] { return collectObjects(sequence, folder, options, *progress, &problems); });
  return make("Collected", c.frames, c.samples, c.instances, c.flat, c.atBorder, problems);
}

/// Trains on the views in a folder, with the labels of their images, which make their own classes if none are
/// given; or without them by their categories.
py::tuple train(const std::vector<std::filesystem::path>& folders,
                const std::vector<std::shared_ptr<SequenceLabels>>& labels, const py::object& classes,
                const py::dict& given, const py::object& callback) {
  const auto options = optionsFrom<TrainingOptions>(given);
  const auto progress = makeProgress(callback);
  std::optional<TargetClasses> targets;
  if (!classes.is_none()) targets = readTargetClasses(classes.cast<std::filesystem::path>());
  std::vector<std::string> problems;
  auto model = longCall([&] {
    std::vector<std::unique_ptr<ObjectViews>> views;
    std::vector<LabeledViews> sources;
    for (std::size_t i = 0; i < folders.size(); ++i) {
      views.push_back(openObjectViews(folders[i]));
      sources.push_back({views.back().get(), {}});
      if (i < labels.size()) sources.back().labels = *labels[i]->sequence;
    }
    const TargetClasses wanted = targets           ? *targets
                                 : !labels.empty() ? TargetClasses{}
                                                   : targetClassesOf(categoriesOf(sources));
    const TrainingSet set = gatherTraining(sources, wanted, options, *progress, &problems);
    return std::make_shared<ObjectModel>(trainObjectModel(set.training, options.classifier, *progress));
  });
  return py::make_tuple(model, problems);
}

py::list predict(ObjectPredictor& predictor, const ObjectModel& model, const py::object& imageArray,
                 const py::object& depthArray, const py::object& cameraObject, const py::object& poseObject) {
  const BorrowedImage image = borrowImage(imageArray), depth = borrowDepth(depthArray);
  const CameraIntrinsics camera = cameraFrom(cameraObject);
  const auto pose = poseFrom(poseObject);
  const auto objects = longCall([&] { return predictor.predict(image.pixels, depth.pixels, camera, pose); });
  const std::vector<std::string> names = model.targets().names();
  return listOf(objects, [&](const PredictedObject& object) {
    const int best = object.answer.classIndex;
    return make("PredictedObject", object.instance, object.views, toPython(object.box),
                best < 0 ? "" : names[static_cast<std::size_t>(best)], object.answer.probability,
                object.answer.why, arrayOf(object.image), arrayOf(object.shape), object.problem);
  });
}

}  // namespace

void bindObjects(py::module_& m) {
  m.def("collect_objects", collect);
  py::class_<ObjectModel, std::shared_ptr<ObjectModel>>(m, "ObjectModel")
      .def_property_readonly("classes", [](const ObjectModel& model) { return model.targets().names(); })
      .def_property_readonly("labeler", &ObjectModel::labeler)
      .def_property_readonly("choice", &ObjectModel::choice)
      .def_property_readonly("held_out_accuracy",
                             [](const ObjectModel& o) { return arrayOf(o.heldOutAccuracy()); })
      .def("write", [](const ObjectModel& model, const std::filesystem::path& file) {
        writeObjectModel(model, file);
      });
  m.def("read_object_model", [](const std::filesystem::path& file) {
    return longCall([&] { return std::make_shared<ObjectModel>(readObjectModel(file)); });
  });
  m.def("train_object_model", train);
  py::class_<ObjectPredictor>(m, "ObjectPredictor")
      .def(py::init([](const ObjectModel& model, Labeler* labeler, const py::dict& given) {
             const auto options = optionsFrom<PredictOptions>(given);
             return longCall([&] { return std::make_unique<ObjectPredictor>(model, labeler, options); });
           }),
           "model"_a, "labeler"_a.none(true), "options"_a, py::keep_alive<1, 2>(), py::keep_alive<1, 3>())
      .def("predict", predict);
}

}  // namespace estancia::python
