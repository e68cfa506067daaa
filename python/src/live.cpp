// SPDX-License-Identifier: Apache-2.0
// Live mapping: a camera's or a replayed recording's frames become a map, or are found in one, while they
// come.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/live/live_loop.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/sources/frame_source.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_options.hpp"
#include "options.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

py::object statusOf(const LiveStatus& s) {
  const auto places =
      listOf(s.places, [](const PlaceBelief& p) { return py::make_tuple(p.node, p.probability); });
  return make("LiveStatus", s.state, s.frame, s.timestamp, toPython(s.pose), toPython(s.words), places,
              s.area, s.areaName, s.unmapped, s.decision, s.frames, s.dropped, s.failed, s.latency, s.rate,
              s.troubles);
}

std::unique_ptr<LiveLoop> makeLoop(const std::string& source, Labeler& labeler,
                                   const std::filesystem::path& map, bool localize, const py::dict& sequence,
                                   const py::dict& replay, const py::dict& mapper, const py::dict& world,
                                   const py::dict& localizer) {
  FrameSourceOptions opening;
  opening.sequence = optionsFrom<SequenceOptions>(sequence);
  opening.replay = optionsFrom<ReplayOptions>(replay);
  LiveOptions options;
  options.localize = localize;
  options.localizer = optionsFrom<LocalizerOptions>(localizer);
  options.changeMapper = changing(mapper);
  options.changeWorld = changing(world);
  return longCall([&] {
    auto loop = std::make_unique<LiveLoop>(makeFrameSource(source, opening), labeler, map, options);
    return loop;
  });
}

void run(LiveLoop& loop, const py::object& each) {
  longCall([&] {
    loop.run([&](const LiveStatus& status) {
      const py::gil_scoped_acquire locked;
      if (!each.is_none()) callBack(each, py::make_tuple(statusOf(status)));
    });
  });
}

}  // namespace

void bindLive(py::module_& m) {
  py::class_<LiveLoop>(m, "LiveLoop")
      .def(py::init(&makeLoop), py::keep_alive<1, 3>())
      .def("run", run)
      .def("stop", [](LiveLoop& loop) { longCall([&] { loop.stop(); }); })
      .def("status", [](const LiveLoop& loop) { return statusOf(longCall([&] { return loop.status(); })); })
      .def("map", [](const LiveLoop& loop) {
        const auto world = longCall([&] { return loop.world(); });
        return world ? std::make_shared<WorldMap>(*world) : nullptr;
      });
}

}  // namespace estancia::python
