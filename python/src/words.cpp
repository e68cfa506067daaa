// SPDX-License-Identifier: Apache-2.0
// Words: which labels a person means, and words that people use for labels.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_concepts.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/name_search.hpp"
#include "estancia/words/room_words.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

py::list searchLabels(std::vector<std::string> labels, const std::string& words) {
  const Vocabulary vocabulary(std::move(labels));
  const LabelMatches found =
      longCall([&] { return findLabelMatches(vocabulary, words, installedWordGraph); });
  return listOf(found.labels, [&](const LabelMatch& match) {
    return make("LabelMatch", vocabulary[match.label], match.probability, match.reason);
  });
}

py::list familiar(std::vector<std::string> labels, const py::object& probabilities, std::size_t count) {
  const Vocabulary vocabulary(std::move(labels));
  const std::vector<float> row = rowOf(probabilities, "probabilities");
  requireProbabilities(row, vocabulary.size(), "the row");
  const auto words = longCall([&] {
    const auto concepts = installedConcepts(vocabulary, {});
    return familiarWords(vocabulary, *concepts, row, count);
  });
  return listOf(words, [](const FamiliarWord& word) {
    return toPython(LabelProbability{word.name, word.probability});
  });
}

}  // namespace

void bindWords(py::module_& m) {
  m.def("search_labels", searchLabels);
  m.def("familiar_words", familiar);
  m.def("common_rooms", &commonRooms);
  m.def("wordnet_hint", [] { return longCall([] { return wordNetHint(); }); });
  m.def("find_name", [](const std::vector<std::string>& names, const std::string& words) -> py::object {
    const auto found = longCall([&] { return findName(names, words, installedWordGraph); });
    return found ? py::cast(names[found->name]) : py::object(py::none());
  });
}

}  // namespace estancia::python
