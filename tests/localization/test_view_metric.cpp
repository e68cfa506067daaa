// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/view_metric.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <random>

#include "estancia/distances/distance.hpp"

namespace estancia {
namespace {

constexpr std::size_t metricLabels = 24;
constexpr Neighborhoods::Reach metricReach{0.25, 10};

using Rows = std::vector<float>;

std::span<const float> rowOf(const Rows& rows, std::size_t i) {
  return std::span(rows).subspan(i * metricLabels, metricLabels);
}

void toUnit(Rows& rows) {
  for (std::size_t first = 0; first < rows.size(); first += metricLabels) {
    const std::span row(rows.data() + first, metricLabels);
    const float length = std::sqrt(dot(row, row));
    for (float& value : row) value /= length;
  }
}

/// `each` images of every place, 5 cm apart, places 5 m apart. What differs within a place are the first two
/// labels.
struct MetricDrive {
  explicit MetricDrive(std::size_t places = 12, std::size_t each = 6, unsigned seed = 1, float differs = 2) {
    std::mt19937 random(7), chance(seed);
    std::normal_distribution<float> normal;
    for (std::size_t place = 0; place < places; ++place) {
      Rows words(metricLabels);
      for (float& value : words) value = normal(random);
      for (std::size_t k = 0; k < each; ++k) {
        Rows image = words;
        for (std::size_t l = 0; l < metricLabels; ++l) image[l] += (l < 2 ? differs : 0.3F) * normal(chance);
        images.insert(images.end(), image.begin(), image.end());
        poses.push_back(Pose{.x = 5.0 * static_cast<double>(place) + 0.05 * static_cast<double>(k)});
      }
    }
    toUnit(images);
  }

  Rows images;
  std::vector<std::optional<Pose>> poses;
};

void expectWhole(const Neighborhoods& around) {
  for (std::size_t i = 0; i < around.size(); ++i) {
    double sum = 0;
    float own = 0, most = 0;
    for (const auto& [image, weight] : around.of(i)) {
      sum += weight;
      most = std::max(most, weight);
      if (image == i) own = weight;
    }
    EXPECT_NEAR(sum, 1, 1e-5) << i;
    EXPECT_FLOAT_EQ(own, most) << i;
  }
}

TEST(Neighborhoods, AreTheImagesTakenNear) {
  const MetricDrive drive;
  const Neighborhoods around(drive.images, drive.poses, metricReach);
  ASSERT_EQ(around.size(), 72U);
  expectWhole(around);
  std::size_t neighbors = 0;
  for (std::size_t i = 0; i < around.size(); ++i)
    for (const auto& [image, weight] : around.of(i)) {
      EXPECT_EQ(image / 6, i / 6);
      ++neighbors;
    }
  EXPECT_GT(neighbors, 72U * 5);

  MetricDrive turned;
  for (std::size_t i = 1; i < turned.poses.size(); i += 2) {  // by 90° about y
    turned.poses[i]->qy = std::sqrt(0.5);
    turned.poses[i]->qw = std::sqrt(0.5);
  }
  const Neighborhoods others(turned.images, turned.poses, metricReach);
  for (std::size_t i = 0; i < others.size(); ++i)
    for (const auto& [image, weight] : others.of(i)) EXPECT_EQ(image % 2, i % 2) << "looks another way";
}

TEST(Neighborhoods, OfACameraThatStandsAreBounded) {
  const Rows same(400 * metricLabels, 1 / std::sqrt(static_cast<float>(metricLabels)));
  for (const bool posed : {false, true}) {
    const std::vector<std::optional<Pose>> poses(400, posed ? std::optional(Pose{}) : std::nullopt);
    const Neighborhoods around(same, poses, metricReach);
    expectWhole(around);
    for (std::size_t i = 0; i < around.size(); ++i) EXPECT_LE(around.of(i).size(), 33U);
    ViewMetric metric(same, around);  // nothing differs
    Rows changed = same;
    metric.apply(changed);
    for (std::size_t i = 0; i < same.size(); ++i) ASSERT_FLOAT_EQ(changed[i], same[i]);
  }
}

TEST(ViewMetric, IsTheInverseRootOfTheCovariance) {
  const MetricDrive drive;
  const Neighborhoods around(drive.images, drive.poses, metricReach);
  Rows changed = drive.images;
  ViewMetric(drive.images, around).apply(changed);

  const auto images = static_cast<int>(around.size()), labels = static_cast<int>(metricLabels);
  cv::Mat_<double> residuals(images, labels);
  for (int i = 0; i < images; ++i) {
    const auto own = static_cast<std::size_t>(i);
    const Rows mean = around.mean(drive.images, own);
    for (int l = 0; l < labels; ++l)
      residuals(i, l) =
          rowOf(drive.images, own)[static_cast<std::size_t>(l)] - mean[static_cast<std::size_t>(l)];
  }
  const cv::Mat_<double> sigma = residuals.t() * residuals / images;
  cv::Mat_<double> values, vectors;
  cv::eigen(sigma, values, vectors);
  const double typical = cv::norm(values, cv::NORM_L2SQR) / cv::sum(values)[0];
  cv::Mat_<double> roots = cv::Mat_<double>::zeros(labels, labels);
  for (int l = 0; l < labels; ++l) roots(l, l) = 1 / std::sqrt(1 + values(l) / typical);
  const cv::Mat_<double> whitening = vectors.t() * roots * vectors;
  for (const std::size_t i : {0U, 17U, 71U}) {
    cv::Mat_<double> expected(labels, 1);
    for (int l = 0; l < labels; ++l) expected(l) = rowOf(drive.images, i)[static_cast<std::size_t>(l)];
    expected = whitening * expected;
    expected /= cv::norm(expected);
    // Directions of less than 1 % are left out.
    for (int l = 0; l < labels; ++l)
      EXPECT_NEAR(rowOf(changed, i)[static_cast<std::size_t>(l)], expected(l), 0.01) << i << " " << l;
  }
}

}  // namespace
}  // namespace estancia
