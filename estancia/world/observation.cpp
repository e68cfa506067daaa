// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/observation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

constexpr int mostColumns = 160;  // a third of a degree is fine enough for walls and words
constexpr int largestSide = 4096;

}  // namespace

Observation observe(const cv::Mat& depth, const CameraIntrinsics& camera) {
  if (depth.type() != CV_32F || depth.empty())
    fail(ErrorCode::invalidInput, "an observation needs a depth image of float32");
  if (!(camera.width > 0 && camera.height > 0 && camera.fx > 0 && camera.fy > 0))
    fail(ErrorCode::invalidInput, "an observation needs a camera with size and focal length");
  const int step = std::max(1, depth.cols / mostColumns);
  const CameraIntrinsics whole = camera.scaledTo(depth.cols, depth.rows);
  Observation seen;
  seen.depth = cv::Mat((depth.rows + step - 1) / step, (depth.cols + step - 1) / step, CV_16U);
  seen.camera = {seen.depth.cols, seen.depth.rows, whole.fx / step,
                 whole.fy / step, whole.cx / step, whole.cy / step};
  for (int v = 0; v < seen.depth.rows; ++v)
    for (int u = 0; u < seen.depth.cols; ++u) {
      const float z = 1000 * depth.at<float>(v * step, u * step);
      seen.depth.at<std::uint16_t>(v, u) =
          z > 0 && z < 65535 ? static_cast<std::uint16_t>(std::lround(z)) : std::uint16_t{0};
    }
  return seen;
}

cv::Mat depthOf(const Observation& observation) {
  cv::Mat depth;
  observation.depth.convertTo(depth, CV_32F, 0.001);
  return depth;
}

std::string toBytes(const Observation& observation) {
  ByteWriter writer;
  for (const double value :
       {observation.camera.fx, observation.camera.fy, observation.camera.cx, observation.camera.cy})
    writer.number(value);
  std::vector<unsigned char> png;
  cv::imencode(".png", observation.depth, png);
  writer.numbers(png);
  return writer.bytes();
}

Observation observationFromBytes(std::string_view bytes) {
  ByteReader reader(bytes, "an observation", "map the sequence again");
  Observation seen;
  const auto fx = reader.number<double>(), fy = reader.number<double>(), cx = reader.number<double>(),
             cy = reader.number<double>();
  const auto png = reader.numbers<unsigned char>();
  // The size stands in the PNG's header: nothing large is decoded.
  const auto side = [&png](std::size_t at) {
    return png.size() < at + 4 ? 0 : png[at] << 24 | png[at + 1] << 16 | png[at + 2] << 8 | png[at + 3];
  };
  if (const int columns = side(16), rows = side(20);
      columns < 1 || rows < 1 || columns > largestSide || rows > largestSide)
    reader.fail("its depth image is damaged", ErrorCode::corruptFile);
  seen.depth = cv::imdecode(png, cv::IMREAD_UNCHANGED);
  if (seen.depth.empty() || seen.depth.type() != CV_16U)
    reader.fail("its depth image is damaged", ErrorCode::corruptFile);
  seen.camera = {seen.depth.cols, seen.depth.rows, fx, fy, cx, cy};
  for (const double value : {fx, fy, cx, cy})
    if (!std::isfinite(value)) reader.fail("its camera is damaged", ErrorCode::corruptFile);
  if (fx <= 0 || fy <= 0) reader.fail("its camera is damaged", ErrorCode::corruptFile);
  return seen;
}

}  // namespace estancia
