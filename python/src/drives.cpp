// SPDX-License-Identifier: Apache-2.0
// Drives: those of a map, what changed between them, maps merged, a drive undone.
#include "estancia/query/drives.hpp"

#include "call.hpp"
#include "estancia/core/options.hpp"
#include "estancia/joining/merge_maps.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_query/changes.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

py::object driveOf(const DriveSummary& d) {
  const auto recognized = [&](auto member) {
    return d.recognized ? py::cast((*d.recognized).*member) : py::object(py::none());
  };
  return make("Drive", d.drive.name, d.first, d.frames, d.begins, d.ends, d.places, d.newPlaces, d.posed,
              d.drive.isAligned, toPython(d.drive.alignment), recognized(&DriveSummary::Recognized::after),
              recognized(&DriveSummary::Recognized::node));
}

py::object changeOf(const ObjectChange& c) {
  const bool was = c.kind != ObjectChange::Kind::appeared, is = c.kind != ObjectChange::Kind::gone;
  return make("ObjectChange", toString(c.kind), c.before, c.now, c.isWhole,
              was ? toPython(c.from) : py::object(py::none()), is ? toPython(c.to) : py::object(py::none()),
              c.area, was ? py::cast(c.lastBefore) : py::object(py::none()),
              is ? py::cast(c.firstNow) : py::object(py::none()));
}

py::object changesOf(const std::filesystem::path& map, const std::optional<std::size_t>& since) {
  const Changes changes = longCall([&] { return findChanges(map, since); });
  const auto places = listOf(changes.places, [&](const PlaceChange& place) {
    const auto words = listOf(place.words, [&](const PlaceChange::Word& word) {
      return py::make_tuple(word.label, word.before, word.now);
    });
    return make("PlaceChange", place.node, place.distance, words);
  });
  return make("Changes", changes.since, listOf(changes.objects, changeOf), places);
}

py::object merged(const std::vector<std::filesystem::path>& maps, const std::filesystem::path& output,
                  const std::string& existing, const py::object& callback) {
  requireChoice("value of existing", existing,
                {{"refuse", "an existing map is an error"}, {"replace", "it is made anew"}});
  const auto progress = makeProgress(callback);
  const MergedMaps done = longCall([&] {
    return mergeMaps(maps, output, existing == "replace" ? ExistingMap::replace : ExistingMap::refuse,
                     *progress);
  });
  const auto all = [&](auto member) {
    return listOf(done.parts, [&](const MergedMaps::Part& part) { return part.*member; });
  };
  return make("MergedMaps", done.drives, done.frames, done.places, all(&MergedMaps::Part::isRecognized),
              all(&MergedMaps::Part::isAligned), done.conflicts);
}

}  // namespace

void bindDrives(py::module_& m) {
  m.def("drives_of", [](const WorldMap& world) { return listOf(summarizeDrives(world.places), driveOf); });
  m.def("changes", changesOf);
  m.def("merge_maps", merged);
  m.def("undo_drive", [](const std::filesystem::path& map, std::size_t drive, const py::object& callback) {
    const auto progress = makeProgress(callback);
    return longCall([&] { return undoDrive(map, drive, *progress); });
  });
}

}  // namespace estancia::python
