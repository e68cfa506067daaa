// SPDX-License-Identifier: Apache-2.0
// Sequences: recordings, their frames, and what is wrong with them.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/check/check.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/trajectory.hpp"
#include "options.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

py::list reportOf(const Sequence& sequence, const py::dict& given, const py::object& callback) {
  const auto options = optionsFrom<CheckOptions>(given);
  const auto progress = makeProgress(callback);
  const CheckReport report = longCall([&] { return checkSequence(sequence, options, *progress); });
  return listOf(report.items, [](const CheckItem& item) {
    static constexpr const char* severities[] = {"fine", "warning", "problem"};
    return make("CheckItem", severities[static_cast<int>(item.severity)], item.name, item.what, item.evidence,
                item.fix);
  });
}

py::list trajectoryRows(const std::filesystem::path& file) {
  const Trajectory trajectory = longCall([&] { return readTrajectory(file); });
  return listOf(trajectory.points, [](const TrajectoryPoint& point) {
    return py::make_tuple(point.timestamp, toPython(point.pose));
  });
}

void writeTrajectoryOf(const py::sequence& points, const std::filesystem::path& file) {
  std::vector<TrajectoryPoint> trajectory;
  for (const py::handle point : points) {
    const auto pair = py::cast<py::tuple>(point);
    trajectory.push_back({pair[0].cast<std::optional<double>>(), poseFrom(pair[1])});
  }
  writeTrajectory(trajectory, file);
}

}  // namespace

void bindSequences(py::module_& m) {
  py::class_<Sequence, std::shared_ptr<Sequence>>(m, "Sequence")
      .def_property_readonly("name", &Sequence::name)
      .def("__len__", &Sequence::size)
      .def("frame", [](const Sequence& sequence, std::size_t i) { return toPython(sequence.frame(i)); })
      .def("image", [](const Sequence& sequence,
                       std::size_t i) { return arrayOf(longCall([&] { return sequence.image(i); })); })
      .def("depth", [](const Sequence& sequence,
                       std::size_t i) { return arrayOf(longCall([&] { return sequence.depth(i); })); })
      .def_property_readonly("has_depth", &Sequence::hasDepth)
      .def_property_readonly("camera",
                             [](const Sequence& sequence) { return toPython(sequence.intrinsics()); })
      .def_property_readonly("warnings", &Sequence::warnings);
  m.def("open_sequence", [](const std::filesystem::path& path, const py::dict& given) {
    const auto options = optionsFrom<SequenceOptions>(given);
    return std::shared_ptr<Sequence>(longCall([&] { return openSequence(path, options); }));
  });
  m.def("open_images", [](const std::vector<std::filesystem::path>& files) {
    return std::shared_ptr<Sequence>(openImages(files));
  });
  m.def("pose_of_matrix", [](const py::object& matrix) { return toPython(poseOf(transformFrom(matrix))); });
  m.def("check_sequence", reportOf);
  m.def("read_image",
        [](const std::filesystem::path& file) { return arrayOf(longCall([&] { return readImage(file); })); });
  m.def("read_trajectory", trajectoryRows);
  m.def("write_trajectory", writeTrajectoryOf);
}

}  // namespace estancia::python
