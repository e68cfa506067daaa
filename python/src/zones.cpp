// SPDX-License-Identifier: Apache-2.0
// Semantic zones: found in a run at once, or while it goes on.
#include "estancia/zones/zones.hpp"

#include "arrays.hpp"
#include "call.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/report/zones_page.hpp"
#include "estancia/words/label_concepts.hpp"
#include "estancia/zones/measure.hpp"
#include "estancia/zones/zone_stream.hpp"
#include "options.hpp"
#include "sequence_labels.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

py::list bestWords(const std::vector<float>& mean, const Vocabulary& vocabulary) {
  Node node;
  node.mean = mean;
  return listOf(bestLabels(node, 10), [&](std::size_t label) {
    return toPython(LabelProbability{vocabulary[label], mean[label]});
  });
}

py::list zonesOf(const Zones& zones) {
  return listOf(zones.zones, [&](const Zone& zone) {
    return make("Zone", zone.id, zone.name, zone.images, bestWords(zone.mean, zones.vocabulary), zone.room,
                zone.roomShare, toPython(zone.predicted), arrayOf(zone.mean), arrayOf(zone.sigma));
  });
}

py::list measuresOfZones(const Zones& zones) {
  return listOf(measuresOf(evaluate(zones)),
                [](const Measure& m) { return make("Measure", m.key, m.name, m.value, m.explanation); });
}

std::string pageOf(const Zones& zones, const std::string& title) {
  ZonesPage page{zones};
  if (!title.empty()) page.title = title;
  page.measures = measuresOf(evaluate(zones));
  const auto concepts = installedConcepts(zones.vocabulary, {});
  page.concepts = concepts.get();
  return renderZonesPage(page);
}

void bindStream(py::module_& m) {
  py::class_<ZoneStream>(m, "ZoneStream")
      .def(py::init([](std::vector<std::string> labels, const py::dict& zones, const py::dict& stream) {
        return ZoneStream(Vocabulary(std::move(labels)), optionsFrom<ZoneOptions>(zones),
                          optionsFrom<ZoneStreamOptions>(stream));
      }))
      .def("add",
           [](ZoneStream& stream, const py::object& probabilities) {
             const std::vector<float> row = rowOf(probabilities, "probabilities");
             return longCall([&] { return stream.add(row); });
           })
      .def("update", [](ZoneStream& stream) { longCall([&] { stream.update(); }); })
      .def("finish",
           [](ZoneStream& stream, const SequenceLabels& labels) {
             return longCall([&] { return std::make_shared<Zones>(stream.finish(*labels.sequence)); });
           })
      .def("name_of", &ZoneStream::nameOf)
      .def_property_readonly("zone_of", &ZoneStream::zoneOf)
      .def_property_readonly("zone_count", &ZoneStream::zoneCount)
      .def_property_readonly("images", &ZoneStream::images);
}

}  // namespace

void bindZones(py::module_& m) {
  py::class_<Zones, std::shared_ptr<Zones>>(m, "Zones")
      .def("__len__", [](const Zones& zones) { return zones.zones.size(); })
      .def_property_readonly("labels", [](const Zones& zones) { return zones.vocabulary.labels(); })
      .def_property_readonly("zones", zonesOf)
      .def_property_readonly("zone_of", [](const Zones& zones) { return zones.zoneOf; })
      .def_property_readonly("cut", [](const Zones& zones) { return zones.cut; })
      .def_property_readonly("cut_reason", [](const Zones& zones) { return zones.cutReason; })
      .def_property_readonly("frames", [](const Zones& zones) { return toPython(zones.frames); })
      .def_property_readonly("run_mean", [](const Zones& zones) { return arrayOf(runMean(zones)); })
      .def("measures", measuresOfZones)
      .def("page", [](const Zones& zones,
                      const std::string& title) { return longCall([&] { return pageOf(zones, title); }); })
      .def("text", [](const Zones& zones) { return longCall([&] { return zoneFileText(zones); }); })
      .def("write", [](const Zones& zones, const std::filesystem::path& file) {
        longCall([&] { writeZones(zones, file); });
      });
  m.def("find_zones", [](const SequenceLabels& labels, const py::dict& given, const py::object& callback) {
    const auto options = optionsFrom<ZoneOptions>(given);
    const auto progress = makeProgress(callback);
    return longCall([&] { return std::make_shared<Zones>(findZones(*labels.sequence, options, *progress)); });
  });
  m.def("read_zones", [](const std::filesystem::path& file) {
    return longCall([&] { return std::make_shared<Zones>(readZones(file)); });
  });
  bindStream(m);
}

}  // namespace estancia::python
