// SPDX-License-Identifier: Apache-2.0
#include "places/kmeans.hpp"

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/seeded_generator.hpp"

namespace estancia::experiments {
std::vector<int> kMeans(const DescriptorMatrix& rows, std::size_t k, const KMeansOptions& options) {
  if (k < 1 || k > rows.size())
    throw Error(
        ErrorCode::invalidInput,
        fmt::format("{} rows cannot be split into {} clusters; choose 1 to {}", rows.size(), k, rows.size()));
  if (options.restarts < 1) throw Error(ErrorCode::invalidOption, "restarts is 0; give at least 1");
  const SeededGenerator generator(options.seed);
  const cv::Mat points(static_cast<int>(rows.size()), static_cast<int>(rows.labels()), CV_32F,
                       const_cast<float*>(rows.values().data()));  // only read
  std::vector<int> clusters;
  cv::kmeans(points, static_cast<int>(k), clusters,
             {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, static_cast<int>(options.iterations), 0.0},
             static_cast<int>(options.restarts), cv::KMEANS_PP_CENTERS);
  return clusters;
}

}  // namespace estancia::experiments
