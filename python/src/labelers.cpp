// SPDX-License-Identifier: Apache-2.0
// Labelers: networks, ensembles, services, and any callable of Python.
#include <algorithm>
#include <numeric>

#include "arrays.hpp"
#include "call.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model.hpp"
#include "options.hpp"
#include "sequence_labels.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

/// Asks a callable: image → probabilities. Its frames are labeled one after the other, with the interpreter's
/// lock.
class CallableLabeler final : public Labeler {
 public:
  CallableLabeler(py::function function, Vocabulary vocabulary, std::string identity)
      : function_(std::move(function)), vocabulary_(std::move(vocabulary)), identity_(std::move(identity)) {}
  ~CallableLabeler() override {
    const py::gil_scoped_acquire locked;
    function_ = py::function();
  }

  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return identity_; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override { return {bgr, frame, {}}; }
  LexicalDescriptor infer(const Prepared& prepared) override {
    const py::gil_scoped_acquire locked;
    const py::object answer = callBack(function_, py::make_tuple(arrayOf(prepared.input)));
    LexicalDescriptor descriptor =
        py::isinstance<py::dict>(answer) ? fromDict(answer) : rowOf(answer, "probabilities");
    requireProbabilities(descriptor, vocabulary_.size(), identity_);
    return descriptor;
  }

 private:
  LexicalDescriptor fromDict(const py::dict& answer) const {
    LexicalDescriptor descriptor(vocabulary_.size());
    for (const auto& [label, probability] : answer) {
      const auto name = label.cast<std::string>();
      const auto found = std::find(vocabulary_.labels().begin(), vocabulary_.labels().end(), name);
      if (found == vocabulary_.labels().end())
        fail(ErrorCode::unknownName, "{} answers \"{}\", which is none of its {} labels", identity_, name,
             vocabulary_.size());
      descriptor[static_cast<std::size_t>(found - vocabulary_.labels().begin())] = probability.cast<float>();
    }
    return descriptor;
  }

  py::function function_;
  Vocabulary vocabulary_;
  std::string identity_;
};

py::object bestOf(const Labeler& labeler, const LexicalDescriptor& p, std::size_t count) {
  std::vector<std::size_t> best(p.size());
  std::iota(best.begin(), best.end(), std::size_t{0});
  count = std::min(count, best.size());
  std::partial_sort(best.begin(), best.begin() + static_cast<std::ptrdiff_t>(count), best.end(),
                    [&](std::size_t a, std::size_t b) { return p[a] > p[b]; });
  best.resize(count);
  return listOf(best, [&](std::size_t label) {
    return toPython(LabelProbability{labeler.vocabulary()[label], p[label]});
  });
}

LexicalDescriptor labelImage(Labeler& labeler, const py::object& array, const std::string& frame) {
  const BorrowedImage image = borrowImage(array);
  return longCall([&] { return labeler.label(image.pixels, frame); });
}

LabelStreamOptions streamOptions(const py::dict& given, LabelCache* cache) {
  auto options = optionsFrom<LabelStreamOptions>(given);
  options.cache = cache;
  return options;
}

std::shared_ptr<SequenceLabels> labelSequence(const Sequence& sequence, Labeler& labeler, LabelCache* cache,
                                              const py::dict& given, const py::object& callback) {
  const LabelStreamOptions options = streamOptions(given, cache);
  const auto progress = makeProgress(callback);
  auto labels = std::make_shared<SequenceLabels>();
  labels->sequence = longCall([&] {
    return std::make_shared<DescriptorSequence>(
        labelAll(sequence, labeler, "labeling", options, *progress, [&](const LabeledFrame& frame) {
          if (!frame.labeled()) labels->problems.push_back(frame.problem);
        }));
  });
  return labels;
}

py::object nextFrame(LabelStream& stream) {
  const std::optional<LabeledFrame> frame = longCall([&] { return stream.next(); });
  if (!frame) throw py::stop_iteration();
  return make("LabeledFrame", frame->index, arrayOf(frame->descriptor),
              frame->image.empty() ? py::object(py::none()) : arrayOf(frame->image), frame->problem);
}

py::object modelOf(const InstalledModel& model) {
  return make("InstalledModel", model.spec ? model.spec->name : model.folder.filename().string(),
              model.folder, model.spec ? model.spec->type : "", model.spec ? model.spec->license : "",
              model.problem);
}

}  // namespace

void bindLabelers(py::module_& m) {
  py::class_<LabelCache, std::shared_ptr<LabelCache>>(m, "LabelCache")
      .def(py::init([](const std::optional<std::filesystem::path>& folder) {
        return folder ? std::make_shared<LabelCache>(*folder) : std::make_shared<LabelCache>();
      }))
      .def_property_readonly("folder", &LabelCache::folder)
      .def_property_readonly("problem", &LabelCache::problem)
      .def("clear", &LabelCache::clear);
  py::class_<Labeler, std::shared_ptr<Labeler>>(m, "Labeler")
      .def_property_readonly("labels", [](const Labeler& labeler) { return labeler.vocabulary().labels(); })
      .def_property_readonly("identity", &Labeler::identity)
      .def_property_readonly("discovers", &Labeler::discovers)
      .def("label", [](Labeler& labeler, const py::object& image,
                       const std::string& frame) { return arrayOf(labelImage(labeler, image, frame)); })
      .def("best", [](Labeler& labeler, const py::object& image, std::size_t count) {
        const LexicalDescriptor p = labelImage(labeler, image, "");
        return bestOf(labeler, p, count);
      });
  m.def("load_model", [](const std::string& model, const py::dict& given) {
    const auto options = optionsFrom<LabelerOptions>(given);
    return std::shared_ptr<Labeler>(longCall([&] { return loadModel(model, options); }));
  });
  m.def("callable_labeler",
        [](const py::function& function, std::vector<std::string> labels, std::string identity) {
          return std::shared_ptr<Labeler>(std::make_shared<CallableLabeler>(
              function, Vocabulary(std::move(labels)), std::move(identity)));
        });
  m.def("label_sequence", labelSequence, "sequence"_a, "labeler"_a, "cache"_a.none(true), "options"_a,
        "progress"_a);
  py::class_<LabelStream>(m, "LabelStream")
      .def(py::init([](const Sequence& sequence, Labeler& labeler, LabelCache* cache, const py::dict& given) {
             const LabelStreamOptions options = streamOptions(given, cache);
             return longCall([&] { return std::make_unique<LabelStream>(sequence, labeler, options); });
           }),
           py::keep_alive<1, 2>(), py::keep_alive<1, 3>(), py::keep_alive<1, 4>())
      .def("next", nextFrame);
  m.def("installed_models", [] { return listOf(longCall([] { return installedModels(); }), modelOf); });
  m.def("model_home", &modelHome);
  m.def("check_model", [](const std::string& model, const py::dict& given) {
    const auto options = optionsFrom<LabelerOptions>(given);
    const ModelCheck check = longCall([&] { return checkModel(model, options); });
    return make("ModelCheck", check.spec.name, check.identity, check.labels, check.millisecondsPerImage,
                check.best, check.bestProbability);
  });
}

}  // namespace estancia::python
