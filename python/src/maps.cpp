// SPDX-License-Identifier: Apache-2.0
// Maps: a map file read with all its layers, asked, driven, edited and shown.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/query/explain.hpp"
#include "estancia/query/export.hpp"
#include "estancia/query/quality.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_concepts.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_store.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/export_world.hpp"
#include "estancia/world_query/route_world.hpp"
#include "options.hpp"
#include "sequence_labels.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

py::list placesOfMap(const WorldMap& world) {
  const std::vector<Place> places = placesOf(world.places);
  py::list list;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Node& node = world.places.nodes[i];
    const auto words = listOf(bestLabels(node, 10), [&](std::size_t label) {
      return toPython(LabelProbability{world.places.vocabulary[label], node.mean[label]});
    });
    const Place& place = places[i];
    py::object position = py::none();
    if (place.position)
      position = py::make_tuple((*place.position)[0], (*place.position)[1], (*place.position)[2]);
    const bool isNamed = place.predictedRoom() != nullptr;
    list.append(make("Place", node.id, node.frames, words, position, place.room,
                     isNamed ? place.predictedRoom()->room : "", toPython(place.predicted),
                     world.areaOfNode(node.id)));
  }
  return list;
}

py::array meansOfMap(const WorldMap& world) {
  DescriptorMatrix means(world.places.vocabulary.size());
  for (const Node& node : world.places.nodes) means.append(node.mean);
  return arrayOf(std::move(means));
}

py::object areaOf(const WorldArea& area) {
  return make("Area", area.id, area.displayName(), area.name, area.givenName, area.roomName,
              area.predictedRoom, area.roomProbability, area.size, toPython(area.center),
              toPython(area.outline), area.frames);
}

py::object objectOfMap(const WorldObject& object) {
  return make("MapObject", object.id, object.displayName(), object.givenName, object.probability(),
              toPython(object.words), toPython(object.shapeClasses), toPython(object.center),
              toPython(object.size), object.yaw, py::cast(object.color), object.flat, object.views,
              object.bestFrame, supportNames[static_cast<std::size_t>(object.support)], object.onObject,
              object.area, object.known ? object.known->name : "",
              object.known ? toPython(object.known->pose) : py::object(py::none()));
}

py::list framesOfMap(const WorldMap& world) {
  return listOf(world.places.frames, [](const MappedFrame& f) {
    return make("MappedFrame", f.name, f.timestamp, toPython(f.pose), f.room, f.node);
  });
}

py::list decisionsOfMap(const WorldMap& world) {
  return listOf(world.places.decisions, [](const Decision& d) {
    return make("Decision", d.frame, toString(d.kind), d.node, d.current, d.toCurrent, d.other, d.toOther,
                d.tauJoin, d.tauRevisit);
  });
}

py::object answerOf(const PlaceAnswer& answer, const WorldMap& world) {
  const std::string matched = answer.room.empty() ? world.places.vocabulary[answer.label] : answer.room;
  return make("PlaceAnswer", answer.node, answer.probability, answer.lift, answer.rank, matched,
              answer.isLikely());
}

py::object answerOf(const ObjectAnswer& answer) {
  return make("ObjectAnswer", answer.object, answer.probability, answer.lift, answer.rank, answer.label,
              answer.isLikely());
}

py::list matchesOf(const Meaning& meaning, const WorldMap& world) {
  return listOf(meaning.matches, [&](const LabelMatch& match) {
    return make("LabelMatch", world.places.vocabulary[match.label], match.probability, match.reason);
  });
}

WordGraphSource sourceOf(bool words) {
  return words ? installedWordGraph : nullptr;
}

py::object askMap(const WorldMap& world, const std::string& words, std::size_t count, bool understand) {
  const WorldAnswers answers =
      longCall([&] { return askWorld(world, words, count, count, sourceOf(understand)); });
  return make("Answers", words,
              listOf(answers.places, [&](const PlaceAnswer& a) { return answerOf(a, world); }),
              listOf(answers.objects, [](const ObjectAnswer& a) { return answerOf(a); }), answers.areas,
              answers.rooms, matchesOf(answers, world), answers.corrected);
}

py::object routeOf(const WorldRoute& route, const WorldMap& world) {
  const auto pose =
      route.pose ? make("ViewPose", route.pose->x, route.pose->y, route.pose->yaw, route.pose->distance)
                 : py::object(py::none());
  const auto path = route.driven ? py::object(toPython(route.driven->points)) : py::object(py::none());
  const auto crossed =
      listOf(route.crossed, [](const CrossedRegion& region) { return py::str(region.name); });
  const auto place = route.place ? answerOf(*route.place, world) : py::object(py::none());
  const auto object = route.object ? answerOf(*route.object) : py::object(py::none());
  return make("Route", route.route.nodes, route.route.cost, route.route.metric, route.areas, path, place,
              object, route.area, pose, crossed);
}

py::object routeInMap(const WorldMap& world, const py::object& to, int from, std::vector<std::string> avoid,
                      std::vector<std::string> prefer, const py::dict& given, bool understand) {
  const auto options = optionsFrom<RouteOptions>(given);
  const RegionPreferences preferences{std::move(avoid), std::move(prefer)};
  const bool isNode = py::isinstance<py::int_>(to);
  const int node = isNode ? to.cast<int>() : 0;
  const auto words = isNode ? std::string() : to.cast<std::string>();
  const WordGraphSource source = sourceOf(understand);
  const WorldRoute route = longCall([&] {
    return isNode ? routeInWorld(world, from, node, preferences, options, source)
                  : routeInWorld(world, from, words, preferences, options, source);
  });
  return routeOf(route, world);
}

py::list measuresOfMap(const WorldMap& world) {
  const auto measures = longCall([&] { return measuresOf(evaluate(world.places)); });
  return listOf(measures,
                [](const Measure& m) { return make("Measure", m.key, m.name, m.value, m.explanation); });
}

/// The page of a map file, as `estancia report` writes it.
std::string pageOf(const std::filesystem::path& file, const std::string& title, std::size_t imageBytes) {
  MapStore store = MapStore::open(file, MapStore::Access::read);
  store.beginReading();
  WorldMap world{store.load()};
  const WorldStore layers(store, MapStore::Access::read);
  layers.read(world);
  const WorldPage above{.world = world,
                        .image = [&layers](int object) { return layers.objectImage(object); },
                        .bytes = imageBytes};
  MapPage page{world.places};
  page.world = &above;
  page.title = title.empty() ? file.stem().string() : title;
  page.measures = measuresOf(evaluate(world.places));
  const auto words = installedAssociations(world.places.vocabulary);
  page.words = words.get();
  if (const WordGraph* graph = installedWordGraph()) page.lexicon = &graph->lexicon;
  const auto concepts = installedConcepts(world.places.vocabulary, {});
  page.concepts = concepts.get();
  page.images.frames = store.imageFrames();
  page.images.read = [&store](std::size_t frame) { return store.image(frame); };
  page.images.bytes = imageBytes;
  std::string html = renderMapPage(page);
  store.endReading();
  return html;
}

void bindEdits(py::module_& m) {
  m.def("name_area", [](const std::filesystem::path& map, const std::string& area, const std::string& name) {
    longCall([&] { nameArea(map, area, name); });
  });
  m.def("merge_areas", [](const std::filesystem::path& map, const std::string& area,
                          const std::string& other) { longCall([&] { mergeAreas(map, area, other); }); });
  m.def("split_area", [](const std::filesystem::path& map, const std::array<double, 2>& from,
                         const std::array<double, 2>& to) {
    longCall([&] { splitArea(map, {from[0], from[1]}, {to[0], to[1]}); });
  });
  m.def("name_object", [](const std::filesystem::path& map, const std::string& object,
                          const std::string& name) { longCall([&] { nameObject(map, object, name); }); });
  m.def("delete_object", [](const std::filesystem::path& map, const std::string& object) {
    longCall([&] { deleteObject(map, object); });
  });
  m.def("name_rooms", [](const std::filesystem::path& map, const std::vector<std::string>& rooms) {
    longCall([&] { nameRoomsByNames(map, rooms); });
  });
}

}  // namespace

void bindMaps(py::module_& m) {
  py::class_<WorldMap, std::shared_ptr<WorldMap>>(m, "Map")
      .def_property_readonly("labels", [](const WorldMap& w) { return w.places.vocabulary.labels(); })
      .def_property_readonly("model", [](const WorldMap& w) { return w.places.model; })
      .def_property_readonly("distance", [](const WorldMap& w) { return w.places.distance; })
      .def_property_readonly("places", placesOfMap)
      .def_property_readonly("means", meansOfMap)
      .def_property_readonly("transitions",
                             [](const WorldMap& w) {
                               return listOf(w.places.transitions, [](const Transition& t) {
                                 return make("Transition", t.from, t.to, t.count, t.firstFrame);
                               });
                             })
      .def_property_readonly("frames", framesOfMap)
      .def_property_readonly("decisions", decisionsOfMap)
      .def_property_readonly("areas", [](const WorldMap& w) { return listOf(w.areas, areaOf); })
      .def_property_readonly("objects", [](const WorldMap& w) { return listOf(w.objects, objectOfMap); })
      .def_property_readonly("zones",
                             [](const WorldMap& w) {
                               return listOf(w.zones, [](const WorldZone& zone) {
                                 return make("MapZone", zone.id, zone.name, zone.frames);
                               });
                             })
      .def_property_readonly("zone_of_frame", [](const WorldMap& w) { return w.zoneOfFrame; })
      .def_property_readonly("area_of_frame", [](const WorldMap& w) { return w.areaOfFrame; })
      .def_property_readonly("counts",
                             [](const WorldMap& w) {
                               return py::make_tuple(w.places.frames.size(), w.places.nodes.size(),
                                                     w.areas.size(), w.objects.size());
                             })
      .def("ask", askMap)
      .def("route", routeInMap)
      .def("measures", measuresOfMap)
      .def("explain", [](const WorldMap& w,
                         const std::string& frame) { return explain(w.places, getFrame(w.places, frame)); })
      .def("export", [](const WorldMap& w, const std::string& format, const py::dict& given) {
        return exportWorld(w, format, optionsFrom<ExportOptions>(given));
      });
  m.def("read_map", [](const std::filesystem::path& file) {
    return longCall([&] { return std::make_shared<WorldMap>(readWorld(file)); });
  });
  m.def("read_map_labels", [](const std::filesystem::path& file) {
    return std::make_shared<SequenceLabels>(SequenceLabels{
        longCall([&] { return std::make_shared<const DescriptorSequence>(readMapDescriptors(file)); })});
  });
  m.def("map_page", [](const std::filesystem::path& file, const std::string& title, std::size_t imageBytes) {
    return longCall([&] { return pageOf(file, title, imageBytes); });
  });
  m.def("object_image", [](const std::filesystem::path& file, int object) {
    const auto jpeg = longCall([&] { return readObjectImage(file, object); });
    return py::bytes(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  });
  bindEdits(m);
}

}  // namespace estancia::python
