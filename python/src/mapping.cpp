// SPDX-License-Identifier: Apache-2.0
// Mapping: images or labels → a map file, all at once or frame by frame.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/map_sequence.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_options.hpp"
#include "options.hpp"
#include "sequence_labels.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

MapSequenceOptions::Existing existingFrom(const std::string& name) {
  requireChoice(
      "value of existing", name,
      {{"refuse", "an existing map is an error"}, {"replace", "it is made anew"}, {"continue", "it grows"}});
  using Existing = MapSequenceOptions::Existing;
  return name == "replace" ? Existing::replace : name == "continue" ? Existing::resume : Existing::refuse;
}

/// The options of the mapper and of the layers come in one dict; `world` is the group of the latter.
py::object mapSequenceOf(const Sequence& sequence, Labeler& labeler, const std::filesystem::path& map,
                         LabelCache* cache, const std::string& existing, const py::dict& mapper,
                         const py::dict& world, const py::dict& budget, const py::object& callback) {
  MapSequenceOptions options;
  options.existing = existingFrom(existing);
  options.stream.cache = cache;
  optionsFrom<MapperOptions>(mapper);  // fails at once on a wrong option
  optionsFrom<WorldOptions>(world);
  optionsFrom<MapBudget>(budget);
  options.changeBudget = changing(budget);
  options.changeMapper = changing(mapper);
  options.changeWorld = changing(world);
  const auto progress = makeProgress(callback);
  const MappedSequence done =
      longCall([&] { return mapSequence(sequence, labeler, map, options, *progress); });
  return py::make_tuple(done.frames, done.newFrames, done.problems);
}

/// The frames of a drive of which only the labels are known.
class RecordedFrames final : public Sequence {
 public:
  explicit RecordedFrames(std::shared_ptr<const DescriptorSequence> labels) : labels_(std::move(labels)) {}
  std::string name() const override { return labels_->model; }
  std::size_t size() const override { return labels_->frames.size(); }
  const Frame& frame(std::size_t i) const override { return labels_->frames[i]; }
  cv::Mat image(std::size_t i) const override {
    fail(ErrorCode::invalidInput, "{} has labels alone, and no image", frame(i).name);
  }

 private:
  std::shared_ptr<const DescriptorSequence> labels_;
};

/// A drive's labels as a labeler, so that they are mapped as images are.
std::shared_ptr<Labeler> recordedLabeler(const SequenceLabels& labels) {
  return std::make_shared<RecordedLabeler>(*labels.sequence);
}

int addImage(MappingSession& session, const py::object& array, const std::optional<double>& timestamp,
             const py::object& pose) {
  const BorrowedImage image = borrowImage(array);
  const auto at = poseFrom(pose);
  return longCall([&] { return session.add(image.pixels, timestamp, at); });
}

int addLabels(MappingSession& session, const py::object& frame, const py::object& probabilities,
              const py::object& array) {
  const Frame named = frameFrom(frame);
  const std::vector<float> row = rowOf(probabilities, "probabilities");
  const BorrowedImage image = borrowImage(array);
  return longCall([&] {
    return image.pixels.empty() ? session.add(named, row)
                                : session.add(named, row, [&] { return encodeImage(image.pixels); });
  });
}

py::object localizationOf(const Localization& at) {
  return make("Localization", at.node, at.nearestImage, at.distance, at.beliefNode, at.beliefImage,
              at.confidence, at.unmapped, at.unvisited, at.beliefZone, at.zoneConfidence);
}

py::list answersOf(const std::vector<Localization>& answers) {
  return listOf(answers, localizationOf);
}

py::dict changesOf(Mapper& mapper) {
  const MapChanges changes = mapper.takeChanges();
  py::list decisions, merges;
  for (const auto& event : changes.events)
    if (const auto* d = std::get_if<Decision>(&event))
      decisions.append(make("Decision", d->frame, toString(d->kind), d->node, d->current, d->toCurrent,
                            d->other, d->toOther, d->tauJoin, d->tauRevisit));
    else if (const auto* m = std::get_if<Merge>(&event))
      merges.append(make("Merge", m->frame, m->kept, m->absorbed, m->distance, m->threshold));
  py::dict all;
  all["restarted"] = changes.restarted;
  all["decisions"] = decisions;
  all["merges"] = merges;
  return all;
}

void bindMapper(py::module_& m) {
  py::class_<Mapper>(m, "Mapper")
      .def(py::init([](std::size_t labels, const py::dict& given) {
        return Mapper(DescriptorLayout(labels), optionsFrom<MapperOptions>(given));
      }))
      .def("add",
           [](Mapper& mapper, const py::object& probabilities, const py::object& pose) {
             const std::vector<float> row = rowOf(probabilities, "probabilities");
             const auto at = poseFrom(pose);
             return longCall([&] { return mapper.add(row, at); });
           })
      .def("finish", [](Mapper& mapper) { longCall([&] { mapper.finish(); }); })
      .def("take_changes", changesOf)
      .def_property_readonly("frames", &Mapper::frames)
      .def_property_readonly("nodes", &Mapper::nodes)
      .def_property_readonly("current_node", &Mapper::currentNode)
      .def_property_readonly("thresholds",
                             [](const Mapper& mapper) {
                               const Thresholds& t = mapper.thresholds();
                               return py::dict("join"_a = t.join, "revisit"_a = t.revisit,
                                               "merge"_a = t.merge, "view"_a = t.view,
                                               "sequence"_a = t.sequence);
                             })
      .def_property_readonly("transitions", [](const Mapper& mapper) {
        return listOf(mapper.transitions(), [](const auto& entry) {
          const Transition& t = entry.second;
          return make("Transition", t.from, t.to, t.count, t.firstFrame);
        });
      });
}

void bindLocalizer(py::module_& m) {
  py::class_<Localizer>(m, "Localizer")
      .def(py::init([](const std::filesystem::path& map, const py::dict& given) {
        const auto options = optionsFrom<LocalizerOptions>(given);
        return longCall([&] { return std::make_unique<Localizer>(map, options); });
      }))
      .def_property_readonly("labels", [](const Localizer& l) { return l.map().vocabulary.labels(); })
      .def("set_zones", &Localizer::setZones)
      .def("add",
           [](Localizer& localizer, const py::object& probabilities, const py::object& odometry) {
             const std::vector<float> row = rowOf(probabilities, "probabilities");
             const auto pose = poseFrom(odometry);
             return answersOf(longCall([&] { return localizer.add(row, pose); }));
           })
      .def("finish", [](Localizer& l) { return answersOf(longCall([&] { return l.finish(); })); });
}

}  // namespace

void bindMapping(py::module_& m) {
  m.def("map_sequence", mapSequenceOf, "sequence"_a, "labeler"_a, "map"_a, "cache"_a.none(true), "existing"_a,
        "mapper"_a, "world"_a, "budget"_a, "progress"_a);
  m.def("compact_map", [](const std::filesystem::path& map, std::optional<std::uint64_t> budget) {
    const CompactedMap done = longCall([&] { return compactMap(map, budget); });
    return make("CompactedMap", done.bytesBefore, done.bytesAfter, done.framesBefore, done.framesAfter);
  });
  m.def("recorded_labeler", recordedLabeler);
  m.def("frames_of_labels", [](const SequenceLabels& labels) {
    return std::shared_ptr<Sequence>(std::make_shared<RecordedFrames>(labels.sequence));
  });
  py::class_<MappingSession>(m, "MappingSession")
      .def(py::init([](const std::filesystem::path& path, Labeler& labeler, const py::object& given) {
             std::optional<MapperOptions> options;
             if (!given.is_none()) options = optionsFrom<MapperOptions>(given);
             return longCall([&] { return std::make_unique<MappingSession>(path, labeler, options); });
           }),
           py::keep_alive<1, 3>())
      .def("set_budget",
           [](MappingSession& session, const py::dict& given) {
             const auto change = changing(given);
             longCall([&] { session.changeBudget(change); });
           })
      .def("begin_drive",
           [](MappingSession& session, const std::string& name, bool posesInMap) {
             longCall([&] { session.beginDrive({name, "", posesInMap}); });
           })
      .def("add", addImage)
      .def("add_labels", addLabels)
      .def("finish", [](MappingSession& session) { longCall([&] { session.finish(); }); })
      .def_property_readonly("frames", &MappingSession::frames);
  bindMapper(m);
  bindLocalizer(m);
}

}  // namespace estancia::python
