// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/observation.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/png.hpp"
#include "estancia/objects/object_instance.hpp"
#include "estancia/segmentation/inverse_depth.hpp"
#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {
namespace {

constexpr int maxColumns = 320;  // a fifth of a degree: small things have some pixels
constexpr int largestSide = 4096;
/// Max distance to a plane, in tolerances of its points: a wall is not quite flat.
constexpr double planeMargin = 2;
constexpr double uprightCosine = 0.3;  // between a wall's normal and up: 17°

void writeSegments(ByteWriter& writer, const Observation& observation) {
  writer.numbers(toPng(observation.segments));
  writer.number(static_cast<std::uint8_t>(observation.info.size()));
  for (const Observation::Segment& segment : observation.info) {
    for (const int side : {segment.box.x, segment.box.y, segment.box.width, segment.box.height})
      writer.number(static_cast<std::uint16_t>(side));
    writer.number(static_cast<std::uint8_t>((segment.flat ? 1 : 0) | (segment.atBorder ? 2 : 0)));
    for (const std::uint8_t channel : segment.color) writer.number(channel);
  }
}

void readSegments(ByteReader& reader, Observation& seen) {
  const auto damaged = [&reader](const char* what) { reader.fail(what, ErrorCode::corruptFile); };
  seen.segments = fromPng(reader.numbers<unsigned char>(), {largestSide, largestSide});
  seen.info.resize(reader.number<std::uint8_t>());
  if (seen.segments.type() != CV_8U || seen.segments.size() != seen.depth.size() ||
      std::any_of(seen.segments.begin<std::uint8_t>(), seen.segments.end<std::uint8_t>(),
                  [&](std::uint8_t pixel) { return inSegment(pixel) && pixel > seen.info.size(); }))
    damaged("its segments are damaged");
  for (Observation::Segment& segment : seen.info) {
    std::array<int, 4> box{};
    for (int& side : box) side = reader.number<std::uint16_t>();
    segment.box = {box[0], box[1], box[2], box[3]};
    if ((segment.box & cv::Rect({}, seen.depth.size())) != segment.box || segment.box.empty())
      damaged("a segment leaves its image");
    const auto flags = reader.number<std::uint8_t>();
    segment.flat = (flags & 1) != 0;
    segment.atBorder = (flags & 2) != 0;
    for (std::uint8_t& channel : segment.color) channel = reader.number<std::uint8_t>();
  }
}

/// Marks pixels in no segment: walls, and surfaces on no plane of the room at all.
void markTheRest(const cv::Mat& depth, const CameraIntrinsics& camera, const Clusters& found,
                 double tolerance, cv::Mat& segments) {
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      std::uint8_t& pixel = segments.at<std::uint8_t>(v, u);
      const double z = depth.at<float>(v, u);
      if (pixel != 0 || !(z > 0)) continue;
      const cv::Vec3d point(camera.slopeX(u) * z, camera.slopeY(v) * z, z);
      const double near = planeMargin * tolerance * std::max(1.0, z * z);
      const auto plane = std::ranges::find_if(found.planes, [&](const Plane& p) {
        return p.structural && std::abs(p.normal.dot(point) - p.offset) < near;
      });
      if (plane == found.planes.end())
        pixel = loosePixel;
      else if (std::abs(plane->normal.dot(found.up)) < uprightCosine)
        pixel = wallPixel;
    }
}

}  // namespace

Observation observe(const cv::Mat& depth, const CameraIntrinsics& camera) {
  if (depth.type() != CV_32F || depth.empty())
    fail(ErrorCode::invalidInput, "an observation needs a depth image of float32");
  if (!(camera.width > 0 && camera.height > 0 && camera.fx > 0 && camera.fy > 0))
    fail(ErrorCode::invalidInput, "an observation needs a camera with size and focal length");
  const int step = (depth.cols + maxColumns - 1) / maxColumns;
  const CameraIntrinsics whole = camera.scaledTo(depth.cols, depth.rows);
  Observation seen;
  seen.depth = cv::Mat((depth.rows + step - 1) / step, (depth.cols + step - 1) / step, CV_16U);
  seen.camera = {seen.depth.cols, seen.depth.rows, whole.fx / step,
                 whole.fy / step, whole.cx / step, whole.cy / step};
  for (int v = 0; v < seen.depth.rows; ++v)
    for (int u = 0; u < seen.depth.cols; ++u) {
      const float z = depth.at<float>(v * step, u * step);
      seen.depth.at<std::uint16_t>(v, u) =
          z > 0 && z < farthestDepth ? static_cast<std::uint16_t>(std::lround(1000 * z)) : std::uint16_t{0};
    }
  return seen;
}

cv::Mat depthOf(const Observation& observation) {
  cv::Mat depth;
  observation.depth.convertTo(depth, CV_32F, 0.001);
  return depth;
}

PointCloud segmentCloud(const cv::Mat& depth, const cv::Mat& segment, const CameraIntrinsics& camera) {
  PointCloud cloud;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      if (segment.at<std::uint8_t>(v, u) == 0 || !(z > 0)) continue;
      cloud.points.emplace_back(static_cast<float>(camera.slopeX(u)) * z,
                                static_cast<float>(camera.slopeY(v)) * z, z);
    }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

std::vector<Plane> findSegments(Observation& observation, const cv::Mat& image,
                                const ClusterOptions& options) {
  const cv::Mat depth = depthOf(observation);
  Clusters found = findClusters(depth, observation.camera, options, image);
  observation.segments = cv::Mat(observation.depth.size(), CV_8U, cv::Scalar(0));
  observation.info.clear();
  cv::Mat colors;
  if (!image.empty()) cv::resize(image, colors, observation.depth.size(), 0, 0, cv::INTER_AREA);
  for (const Cluster& cluster : found.clusters) {
    if (observation.info.size() == maxSegments) break;
    const auto number = static_cast<std::uint8_t>(observation.info.size() + 1);
    cv::Vec3d sum;
    for (const std::uint32_t pixel : cluster.points) {
      observation.segments.data[pixel] = number;
      if (!colors.empty()) sum += colors.ptr<cv::Vec3b>()[pixel];
    }
    const auto mean = [&](int channel) {
      return cv::saturate_cast<std::uint8_t>(sum[channel] / static_cast<double>(cluster.points.size()));
    };
    observation.info.push_back({cluster.box, cluster.flat, cluster.atBorder, {mean(2), mean(1), mean(0)}});
  }
  markTheRest(depth, observation.camera, found, options.planeTolerance, observation.segments);
  return std::move(found.planes);
}

std::vector<Plane> planesOf(const Observation& observation, const ClusterOptions& options) {
  validate(options);
  return removePlanes(inverseDepth(depthOf(observation), observation.camera, options.threads), options)
      .planes;
}

std::string toBytes(const Observation& observation) {
  ByteWriter writer;
  for (const double value :
       {observation.camera.fx, observation.camera.fy, observation.camera.cx, observation.camera.cy})
    writer.number(value);
  writer.numbers(toPng(observation.depth));
  writer.number(static_cast<std::uint8_t>(!observation.segments.empty()));
  if (!observation.segments.empty()) writeSegments(writer, observation);
  if (observation.seenFrom) {
    const Pose& p = *observation.seenFrom;
    for (const double value : {p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw}) writer.number(value);
  }
  return writer.bytes();
}

Observation observationFromBytes(std::string_view bytes) {
  ByteReader reader(bytes, "an observation", "map the sequence again");
  const auto damaged = [&reader](const char* what) { reader.fail(what, ErrorCode::corruptFile); };
  Observation seen;
  const auto fx = reader.number<double>(), fy = reader.number<double>(), cx = reader.number<double>(),
             cy = reader.number<double>();
  seen.depth = fromPng(reader.numbers<unsigned char>(), {largestSide, largestSide});
  if (seen.depth.type() != CV_16U) damaged("its depth image is damaged");
  seen.camera = {seen.depth.cols, seen.depth.rows, fx, fy, cx, cy};
  for (const double value : {fx, fy, cx, cy})
    if (!std::isfinite(value)) damaged("its camera is damaged");
  if (fx <= 0 || fy <= 0) damaged("its camera is damaged");
  if (reader.number<std::uint8_t>() != 0) readSegments(reader, seen);
  if (reader.remaining() == 0) return seen;
  std::array<double, 7> from{};
  for (double& value : from) value = reader.number<double>();
  seen.seenFrom = Pose{from[0], from[1], from[2], from[3], from[4], from[5], from[6]};
  if (!seen.seenFrom->isPlausible()) damaged("its pose is damaged");
  return seen;
}

}  // namespace estancia
