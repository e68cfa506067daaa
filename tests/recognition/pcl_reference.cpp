// SPDX-License-Identifier: Apache-2.0
#ifdef ESTANCIA_HAS_PCL

#include "recognition/pcl_reference.hpp"

#include <pcl/features/fpfh.h>
#include <pcl/features/shot.h>
#include <pcl/features/spin_image.h>
#include <pcl/keypoints/harris_3d.h>
#include <pcl/keypoints/iss_3d.h>
#include <pcl/registration/correspondence_rejection_sample_consensus.h>
#include <pcl/search/kdtree.h>
#include <pcl/recognition/impl/cg/geometric_consistency.hpp>  // lies in a library of its own

namespace estancia::test {
namespace {

pcl::PointCloud<pcl::PointXYZ>::Ptr toPcl(std::span<const cv::Point3f> points) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const cv::Point3f& p : points) cloud->emplace_back(p.x, p.y, p.z);
  return cloud;
}

pcl::PointCloud<pcl::Normal>::Ptr normalsOf(const Surface& surface) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
  for (const cv::Point3f& n : surface.normals()) cloud->emplace_back(n.x, n.y, n.z);
  return cloud;
}

template <class Estimation, class Output>
std::vector<float> rowsOf(Estimation& estimation, std::size_t length, float* (*row)(Output&)) {
  pcl::PointCloud<Output> out;
  estimation.compute(out);
  std::vector<float> values;
  for (Output& o : out) values.insert(values.end(), row(o), row(o) + length);
  return values;
}

pcl::PointCloud<pcl::PointXYZ>::Ptr pointsAt(const Surface& surface,
                                             std::span<const std::uint32_t> keypoints) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const std::uint32_t i : keypoints) {
    const cv::Point3f& p = surface.points()[i];
    cloud->emplace_back(p.x, p.y, p.z);
  }
  return cloud;
}

template <class Estimation>
void prepare(Estimation& estimation, const Surface& surface, std::span<const std::uint32_t> keypoints,
             double radius) {
  const auto cloud = toPcl(surface.points());
  estimation.setInputCloud(pointsAt(surface, keypoints));
  estimation.setSearchSurface(cloud);
  estimation.setInputNormals(normalsOf(surface));
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(radius);
}

}  // namespace

std::vector<float> pclShot(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius) {
  pcl::SHOTEstimation<pcl::PointXYZ, pcl::Normal, pcl::SHOT352> shot;
  prepare(shot, surface, keypoints, radius);
  return rowsOf<decltype(shot), pcl::SHOT352>(shot, 352, [](pcl::SHOT352& s) { return s.descriptor; });
}

std::vector<float> pclColorShot(const PointCloud& surface, std::span<const std::uint32_t> keypoints,
                                double radius) {
  using Points = pcl::PointCloud<pcl::PointXYZRGB>;
  const auto cloud = pcl::make_shared<Points>(), chosen = pcl::make_shared<Points>();
  const auto normals = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const cv::Point3f &p = surface.points[i], &n = surface.normals[i];
    const cv::Vec3b& c = surface.colors[i];
    cloud->emplace_back(p.x, p.y, p.z, c[2], c[1], c[0]);
    normals->emplace_back(n.x, n.y, n.z);
  }
  for (const std::uint32_t i : keypoints) chosen->push_back((*cloud)[i]);
  pcl::SHOTColorEstimation<pcl::PointXYZRGB, pcl::Normal, pcl::SHOT1344> shot;
  shot.setInputCloud(chosen);
  shot.setSearchSurface(cloud);
  shot.setInputNormals(normals);
  shot.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZRGB>>());
  shot.setRadiusSearch(radius);
  return rowsOf<decltype(shot), pcl::SHOT1344>(shot, 1344, [](pcl::SHOT1344& s) { return s.descriptor; });
}

std::vector<float> pclFpfh(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius) {
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> fpfh;
  prepare(fpfh, surface, keypoints, radius);
  return rowsOf<decltype(fpfh), pcl::FPFHSignature33>(fpfh, 33,
                                                      [](pcl::FPFHSignature33& s) { return s.histogram; });
}

std::vector<float> pclSpinImage(const Surface& surface, std::span<const std::uint32_t> keypoints,
                                double radius) {
  pcl::SpinImageEstimation<pcl::PointXYZ, pcl::Normal, pcl::Histogram<153>> spin(8, 0.5, 5);
  const auto indices = pcl::make_shared<pcl::Indices>(keypoints.begin(), keypoints.end());
  spin.setInputCloud(toPcl(surface.points()));  // it takes the axes from the input's normals
  spin.setInputNormals(normalsOf(surface));
  spin.setIndices(indices);
  spin.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  spin.setRadiusSearch(radius);
  return rowsOf<decltype(spin), pcl::Histogram<153>>(spin, 153,
                                                     [](pcl::Histogram<153>& s) { return s.histogram; });
}

std::vector<std::uint32_t> pclIss(const Surface& surface, double radius) {
  pcl::ISSKeypoint3D<pcl::PointXYZ, pcl::PointXYZ> iss;
  iss.setInputCloud(toPcl(surface.points()));
  iss.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  iss.setSalientRadius(radius);
  iss.setNonMaxRadius(radius * 2 / 3);
  iss.setThreshold21(0.975);
  iss.setThreshold32(0.975);
  iss.setMinNeighbors(5);
  pcl::PointCloud<pcl::PointXYZ> out;
  iss.compute(out);
  const auto& indices = iss.getKeypointsIndices()->indices;
  return {indices.begin(), indices.end()};
}

std::vector<std::uint32_t> pclHarris(const Surface& surface, double radius) {
  pcl::HarrisKeypoint3D<pcl::PointXYZ, pcl::PointXYZI, pcl::Normal> harris;
  harris.setInputCloud(toPcl(surface.points()));
  harris.setNormals(normalsOf(surface));
  harris.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  harris.setRadius(static_cast<float>(radius));
  harris.setNonMaxSupression(true);
  harris.setRefine(false);
  harris.setThreshold(1e-6F);
  pcl::PointCloud<pcl::PointXYZI> out;
  harris.compute(out);
  const auto& indices = harris.getKeypointsIndices()->indices;
  return {indices.begin(), indices.end()};
}

std::vector<std::vector<Match>> pclConsistentSets(std::span<const cv::Point3f> model,
                                                  std::span<const cv::Point3f> scene,
                                                  std::span<const Match> matches, double tolerance,
                                                  std::size_t minimum) {
  pcl::GeometricConsistencyGrouping<pcl::PointXYZ, pcl::PointXYZ> grouping;
  const auto correspondences = pcl::make_shared<pcl::Correspondences>();
  for (const Match& m : matches)
    correspondences->emplace_back(static_cast<int>(m.model), static_cast<int>(m.scene), m.squared);
  grouping.setGCSize(tolerance);
  grouping.setGCThreshold(static_cast<int>(minimum) - 1);
  grouping.setInputCloud(toPcl(model));
  grouping.setSceneCloud(toPcl(scene));
  grouping.setModelSceneCorrespondences(correspondences);
  std::vector<Eigen::Matrix4f, Eigen::aligned_allocator<Eigen::Matrix4f>> poses;
  std::vector<pcl::Correspondences> clustered;
  grouping.recognize(poses, clustered);
  std::vector<std::vector<Match>> sets;
  for (const auto& cluster : clustered) {
    sets.emplace_back();
    for (const auto& c : cluster)
      sets.back().push_back(
          {static_cast<std::uint32_t>(c.index_query), static_cast<std::uint32_t>(c.index_match), c.distance});
  }
  return sets;
}

std::vector<Match> pclRansac(std::span<const cv::Point3f> model, std::span<const cv::Point3f> scene,
                             std::span<const Match> matches, double tolerance) {
  pcl::registration::CorrespondenceRejectorSampleConsensus<pcl::PointXYZ> rejector;
  rejector.setMaximumIterations(10000);
  rejector.setInlierThreshold(tolerance);
  rejector.setInputSource(toPcl(model));
  rejector.setInputTarget(toPcl(scene));
  pcl::Correspondences all, left;
  for (const Match& m : matches)
    all.emplace_back(static_cast<int>(m.model), static_cast<int>(m.scene), m.squared);
  rejector.getRemainingCorrespondences(all, left);
  std::vector<Match> kept;
  for (const auto& c : left)
    kept.push_back(
        {static_cast<std::uint32_t>(c.index_query), static_cast<std::uint32_t>(c.index_match), c.distance});
  return kept;
}

}  // namespace estancia::test

#endif
