// SPDX-License-Identifier: Apache-2.0
// Point clouds: files, filters, neural gas, normals, noise, segmentation and rendering.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/cloud/filter.hpp"
#include "estancia/cloud/growing_neural_gas.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/figures/cloud_image.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/segmentation/clusters.hpp"
#include "options.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

static_assert(sizeof(cv::Point3f) == 3 * sizeof(float) && sizeof(cv::Vec3b) == 3);

/// N×3 of float32, each row a point.
std::vector<cv::Point3f> pointsFrom(const py::object& object, const char* what) {
  const auto array = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(object);
  if (!array || array.ndim() < 2 || array.ndim() > 3 || array.shape(array.ndim() - 1) != 3) {
    PyErr_Clear();
    fail(ErrorCode::invalidInput, "{} must be an array of shape (N, 3), or (height, width, 3)", what);
  }
  const auto* points = reinterpret_cast<const cv::Point3f*>(array.data());
  return {points, points + array.size() / 3};
}

std::shared_ptr<PointCloud> makeCloud(const py::object& points, const py::object& colors,
                                      const py::object& normals, const py::object& viewpoint) {
  auto cloud = std::make_shared<PointCloud>();
  cloud->points = pointsFrom(points, "points");
  const py::tuple shape = points.attr("shape");
  const bool organized = shape.size() == 3;
  cloud->height = organized ? shape[0].cast<std::size_t>() : 1;
  cloud->width = organized ? shape[1].cast<std::size_t>() : cloud->points.size();
  if (!colors.is_none()) {
    const auto array = py::array_t<std::uint8_t, py::array::c_style>::ensure(colors);
    if (!array || array.size() != static_cast<py::ssize_t>(3 * cloud->points.size())) {
      PyErr_Clear();
      fail(ErrorCode::invalidInput, "colors must be uint8, BGR, one a point");
    }
    const auto* first = reinterpret_cast<const cv::Vec3b*>(array.data());
    cloud->colors.assign(first, first + cloud->points.size());
  }
  if (!normals.is_none()) cloud->normals = pointsFrom(normals, "normals");
  cloud->viewpoint = poseFrom(viewpoint);
  validate(*cloud);
  return cloud;
}

template <class Number, class Vector>
py::object rows(const std::shared_ptr<PointCloud>& cloud, const Vector& values) {
  if (values.empty() && !cloud->points.empty()) return py::none();
  return viewOf(reinterpret_cast<const Number*>(values.data()), {static_cast<py::ssize_t>(values.size()), 3},
                cloud);
}

py::array indices(const std::vector<std::uint32_t>& points) {
  return py::array_t<std::uint32_t>(static_cast<py::ssize_t>(points.size()), points.data());
}

py::array edgesOf(const NeuralGas& gas) {
  return py::array_t<std::uint32_t>({static_cast<py::ssize_t>(gas.edges.size()), py::ssize_t{2}},
                                    gas.edges.empty() ? nullptr : gas.edges.front().data());
}

py::object gasOf(NeuralGas gas) {
  static constexpr const char* stops[] = {"neurons", "quantization-error", "seconds", "points", "stalled"};
  const py::array edges = edgesOf(gas);
  auto cloud = std::make_shared<PointCloud>(std::move(gas.cloud));
  return make("NeuralGas", cloud, edges, gas.signals, gas.quantizationError,
              stops[static_cast<int>(gas.stop)]);
}

py::object growGas(const PointCloud& cloud, const py::dict& given, const py::object& callback) {
  const auto options = optionsFrom<GngOptions>(given);
  const auto progress = makeProgress(callback);
  return gasOf(longCall([&] { return growNeuralGas(cloud, options, *progress); }));
}

std::shared_ptr<PointCloud> filtered(const PointCloud& cloud, const py::dict& given,
                                     const py::object& callback) {
  const auto options = optionsFrom<FilterOptions>(given);
  const auto progress = makeProgress(callback);
  return longCall([&] { return std::make_shared<PointCloud>(filterCloud(cloud, options, *progress)); });
}

py::object clustersOf(const Clusters& found) {
  const auto planes = listOf(found.planes, [](const Plane& plane) {
    return make("Plane", py::make_tuple(plane.normal[0], plane.normal[1], plane.normal[2]), plane.offset,
                plane.area, plane.structural);
  });
  const auto clusters = listOf(found.clusters, [](const Cluster& cluster) {
    return make("Cluster", indices(cluster.points), toPython(cluster.box),
                toPython(cv::Point3d(cluster.center)), cluster.atBorder, cluster.flat);
  });
  return make("Clusters", clusters, planes, py::make_tuple(found.up[0], found.up[1], found.up[2]));
}

py::object clustersOfDepth(const py::object& depthArray, const py::object& cameraObject,
                           const py::object& imageArray, const py::dict& given) {
  const BorrowedImage depth = borrowDepth(depthArray), image = borrowImage(imageArray);
  const CameraIntrinsics camera = cameraFrom(cameraObject);
  const auto options = optionsFrom<ClusterOptions>(given);
  return clustersOf(longCall([&] { return findClusters(depth.pixels, camera, options, image.pixels); }));
}

py::array drawing(const std::vector<std::shared_ptr<PointCloud>>& clouds,
                  const std::vector<py::object>& poses, int width, int height, double azimuth,
                  double elevation) {
  std::vector<CloudLayer> layers;
  for (std::size_t i = 0; i < clouds.size(); ++i)
    layers.push_back(
        {clouds[i].get(),
         i < poses.size() && !poses[i].is_none() ? transformFrom(poses[i]) : cv::Affine3d::Identity(),
         std::nullopt,
         {}});
  const CloudView view{width, height, azimuth, elevation};
  return arrayOf(longCall([&] { return drawClouds(layers, view); }));
}

void bindCloud(py::module_& m) {
  py::class_<PointCloud, std::shared_ptr<PointCloud>>(m, "PointCloud")
      .def(py::init(&makeCloud))
      .def("__len__", [](const PointCloud& cloud) { return cloud.points.size(); })
      .def_property_readonly("points",
                             [](const std::shared_ptr<PointCloud>& c) { return rows<float>(c, c->points); })
      .def_property_readonly(
          "colors", [](const std::shared_ptr<PointCloud>& c) { return rows<std::uint8_t>(c, c->colors); })
      .def_property_readonly("normals",
                             [](const std::shared_ptr<PointCloud>& c) { return rows<float>(c, c->normals); })
      .def_property_readonly("width", [](const PointCloud& cloud) { return cloud.width; })
      .def_property_readonly("height", [](const PointCloud& cloud) { return cloud.height; })
      .def_property_readonly("viewpoint", [](const PointCloud& cloud) { return toPython(cloud.viewpoint); });
}

}  // namespace

void bindClouds(py::module_& m) {
  bindCloud(m);
  using Cloud = std::shared_ptr<PointCloud>;
  m.def("read_cloud", [](const std::filesystem::path& file, const std::string& unit, const py::dict& given) {
    auto options = optionsFrom<CloudFileOptions>(given);
    options.unit = unit;
    return longCall([&] { return std::make_shared<PointCloud>(readCloud(file, options)); });
  });
  m.def("write_cloud", [](const PointCloud& cloud, const std::filesystem::path& file) {
    longCall([&] { writeCloud(cloud, file); });
  });
  m.def("back_project", [](const py::object& array, const py::object& camera) {
    const BorrowedImage depth = borrowDepth(array);
    return std::make_shared<PointCloud>(backProject(depth.pixels, cameraFrom(camera)));
  });
  m.def("filter_cloud", filtered);
  m.def("grow_neural_gas", growGas);
  m.def("with_normals", [](const PointCloud& cloud, const py::dict& given) {
    const auto options = optionsFrom<NormalOptions>(given);
    return longCall([&] {
      auto result = std::make_shared<PointCloud>(cloud);
      result->normals = estimateNormals(cloud, options);
      return result;
    });
  });
  m.def("with_gaussian_noise", [](const PointCloud& cloud, double sigma, std::uint64_t seed) -> Cloud {
    return longCall([&] { return std::make_shared<PointCloud>(withGaussianNoise(cloud, sigma, seed)); });
  });
  m.def("points_of", [](const PointCloud& cloud, const std::vector<std::uint32_t>& points) -> Cloud {
    return std::make_shared<PointCloud>(pointsOf(cloud, points));
  });
  m.def("cloud_resolution", [](const PointCloud& c) { return longCall([&] { return resolutionOf(c); }); });
  m.def("cloud_noise", [](const PointCloud& c) { return longCall([&] { return estimateNoise(c); }); });
  m.def("find_clusters", clustersOfDepth);
  m.def("find_clusters_of_cloud", [](const PointCloud& cloud, const py::dict& given) {
    const auto options = optionsFrom<ClusterOptions>(given);
    return clustersOf(longCall([&] { return findClusters(cloud, options); }));
  });
  m.def("draw_clouds", drawing);
}

}  // namespace estancia::python
