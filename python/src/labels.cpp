// SPDX-License-Identifier: Apache-2.0
// Labels: the probabilities of a sequence's frames, from a labeler, a file or NumPy.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/core/fail.hpp"
#include "options.hpp"
#include "sequence_labels.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

std::shared_ptr<SequenceLabels> makeLabels(const py::object& probabilities, std::vector<std::string> names,
                                           const py::sequence& frames, const std::string& model) {
  DescriptorSequence sequence{
      Vocabulary(std::move(names)), model, {}, matrixOf(probabilities, "probabilities")};
  for (const py::handle frame : frames)
    sequence.frames.push_back(frameFrom(py::reinterpret_borrow<py::object>(frame)));
  const DescriptorMatrix& rows = sequence.descriptors;
  if (rows.labels() != sequence.vocabulary.size() || rows.size() != sequence.frames.size())
    fail(ErrorCode::mismatch, "{} rows of {} probabilities do not fit {} frames and {} labels", rows.size(),
         rows.labels(), sequence.frames.size(), sequence.vocabulary.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    requireProbabilities(rows.row(i), rows.labels(), "row " + std::to_string(i));
  return std::make_shared<SequenceLabels>(
      SequenceLabels{std::make_shared<const DescriptorSequence>(std::move(sequence))});
}

}  // namespace

void bindLabels(py::module_& m) {
  py::class_<SequenceLabels, std::shared_ptr<SequenceLabels>>(m, "Labels")
      .def(py::init(&makeLabels))
      .def("__len__", [](const SequenceLabels& labels) { return labels.sequence->frames.size(); })
      .def_property_readonly("labels",
                             [](const SequenceLabels& l) { return l.sequence->vocabulary.labels(); })
      .def_property_readonly("model", [](const SequenceLabels& l) { return l.sequence->model; })
      .def_property_readonly("problems", [](const SequenceLabels& l) { return l.problems; })
      .def_property_readonly("frames", [](const SequenceLabels& l) { return toPython(l.sequence->frames); })
      .def_property_readonly("probabilities", [](const SequenceLabels& l) {
        const DescriptorMatrix& rows = l.sequence->descriptors;
        return viewOf(rows.values().data(),
                      {static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(rows.labels())},
                      l.sequence);
      });
  m.def("read_labels", [](const std::filesystem::path& file, const py::dict& given) {
    const auto options = optionsFrom<DescriptorFileOptions>(given);
    return std::make_shared<SequenceLabels>(SequenceLabels{longCall(
        [&] { return std::make_shared<const DescriptorSequence>(readDescriptors(file, options)); })});
  });
  m.def("write_labels", [](const SequenceLabels& labels, const std::filesystem::path& file) {
    longCall([&] { writeDescriptors(*labels.sequence, file); });
  });
}

}  // namespace estancia::python
