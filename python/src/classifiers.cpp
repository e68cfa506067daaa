// SPDX-License-Identifier: Apache-2.0
// Classifiers: descriptors of images, classifiers of numbers, and room classifiers.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/classify/classifier.hpp"
#include "estancia/classify/room_classifier.hpp"
#include "estancia/classify/zero_shot_rooms.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/word_graph.hpp"
#include "options.hpp"
#include "sequence_labels.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

using SharedFeatures = std::shared_ptr<const Features>;

/// Features, with what was wrong with the frames that were left out.
struct DescribedSequence {
  SharedFeatures features;
  std::vector<std::string> problems = {};
};

std::shared_ptr<Classifier> train(const py::object& x, std::vector<int> classes, std::vector<int> groups,
                                  int classCount, const py::dict& given, const py::object& callback) {
  const auto options = optionsFrom<ClassifierOptions>(given);
  const Samples samples{matrixOf(x, "samples"), std::move(classes), std::move(groups), classCount};
  const auto progress = makeProgress(callback);
  return longCall([&] { return std::shared_ptr<Classifier>(trainClassifier(samples, options, *progress)); });
}

std::shared_ptr<DescribedSequence> describeFrames(const Sequence& sequence, const std::string& descriptors,
                                                  LabelCache* cache, const py::object& callback) {
  DescribeOptions options;
  options.cache = cache;
  const auto progress = makeProgress(callback);
  auto described = std::make_shared<DescribedSequence>();
  described->features = longCall([&] {
    return std::make_shared<const Features>(
        describeSequence(sequence, descriptors, options, *progress, &described->problems));
  });
  return described;
}

py::list probabilitiesOf(const RoomPredictions& predictions) {
  py::list images;
  for (std::size_t i = 0; i < predictions.probabilities.size(); ++i)
    images.append(toPython(rankedRooms(predictions, i)));
  return images;
}

py::list roomsByName(const SequenceLabels& labels, const std::vector<std::string>& rooms) {
  const WordGraph* graph = installedWordGraph();
  if (graph == nullptr)
    fail(ErrorCode::missingDependency, "rooms cannot be told by their names: {}", wordNetHint());
  return probabilitiesOf(longCall([&] {
    return predictRoomsByNames(*graph, labels.sequence->vocabulary, labels.sequence->descriptors, rooms);
  }));
}

void bindFeatures(py::module_& m) {
  py::class_<DescribedSequence, std::shared_ptr<DescribedSequence>>(m, "Features")
      .def("__len__", [](const DescribedSequence& d) { return d.features->frames.size(); })
      .def_property_readonly("name", [](const DescribedSequence& d) { return d.features->name(); })
      .def_property_readonly("problems", [](const DescribedSequence& d) { return d.problems; })
      .def_property_readonly("frames",
                             [](const DescribedSequence& d) { return toPython(d.features->frames); })
      .def_property_readonly("columns",
                             [](const DescribedSequence& d) {
                               std::vector<std::string> columns;
                               for (const DescriptorPart& part : d.features->parts)
                                 columns.insert(columns.end(), part.columns.begin(), part.columns.end());
                               return columns;
                             })
      .def_property_readonly("values", [](const DescribedSequence& d) {
        const DescriptorMatrix& rows = d.features->values;
        return viewOf(rows.values().data(),
                      {static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(rows.labels())},
                      d.features);
      });
  m.def("describe_sequence", describeFrames, "sequence"_a, "descriptors"_a, "cache"_a.none(true),
        "progress"_a);
  m.def("features_of_labels", [](const SequenceLabels& labels) {
    return std::make_shared<DescribedSequence>(
        DescribedSequence{std::make_shared<const Features>(featuresOf(*labels.sequence))});
  });
  m.def("describe_image", [](const py::object& imageArray, const std::string& name,
                             const py::object& depthArray, const py::object& camera) {
    const BorrowedImage image = borrowImage(imageArray), depth = borrowDepth(depthArray);
    View view{image.pixels, depth.pixels, {}, {}};
    if (!camera.is_none()) view.camera = cameraFrom(camera);
    return arrayOf(longCall([&] { return loadDescriptor(name)->describe(view); }));
  });
}

}  // namespace

void bindClassifiers(py::module_& m) {
  bindFeatures(m);
  py::class_<Classifier, std::shared_ptr<Classifier>>(m, "Classifier")
      .def_property_readonly("choice", &Classifier::choice)
      .def("predict", [](const Classifier& classifier, const py::object& x) {
        const DescriptorMatrix samples = matrixOf(x, "samples");
        return arrayOf(longCall([&] { return classifier.predict(samples); }));
      });
  m.def("train_classifier", train);
  py::class_<RoomClassifier>(m, "RoomClassifier")
      .def_property_readonly("rooms", &RoomClassifier::rooms)
      .def_property_readonly("choice", &RoomClassifier::choice)
      .def_property_readonly("training_images", &RoomClassifier::trainingImages)
      .def("predict_image",
           [](const RoomClassifier& rooms, const py::object& array) {
             const BorrowedImage image = borrowImage(array);
             return toPython(longCall([&] { return rooms.predict(image.pixels); }));
           })
      .def("predict",
           [](const RoomClassifier& rooms, const DescribedSequence& described) {
             return arrayOf(longCall([&] { return rooms.predict(*described.features); }));
           })
      .def("write", [](const RoomClassifier& rooms, const std::filesystem::path& file) {
        longCall([&] { writeRoomClassifier(rooms, file); });
      });
  m.def("train_room_classifier",
        [](const DescribedSequence& described, const py::dict& given, const py::object& callback) {
          const auto options = optionsFrom<ClassifierOptions>(given);
          const auto progress = makeProgress(callback);
          return longCall([&] { return trainRoomClassifier(*described.features, options, *progress); });
        });
  m.def("read_room_classifier",
        [](const std::filesystem::path& file) { return longCall([&] { return readRoomClassifier(file); }); });
  m.def("rooms_by_name", roomsByName);
}

}  // namespace estancia::python
