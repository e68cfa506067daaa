// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/objects/shape.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

/// The surface of an ellipsoid with these half axes [m].
PointCloud ellipsoid(const std::array<float, 3>& axes, const cv::Point3f& center = {}, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  PointCloud cloud;
  for (int i = 0; i < 2000; ++i) {
    const cv::Point3f p(normal(random), normal(random), normal(random));
    const float length = std::sqrt(p.dot(p));
    cloud.points.emplace_back(axes[0] * p.x / length + center.x, axes[1] * p.y / length + center.y,
                              axes[2] * p.z / length + center.z);
  }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

/// Some views can be described, others are holes, lines, or unreadable.
class Views final : public ObjectViews {
 public:
  explicit Views(std::vector<PointCloud> clouds) : clouds_(std::move(clouds)) {
    for (std::size_t i = 0; i < clouds_.size(); ++i) {
      ObjectView& view = views_.emplace_back();
      view.name = "view " + std::to_string(i);
      view.category = i % 2 == 0 ? "even" : "odd";
    }
  }
  std::string name() const override { return "made up"; }
  std::size_t size() const override { return clouds_.size(); }
  const ObjectView& view(std::size_t i) const override { return views_[i]; }
  PointCloud cloud(std::size_t i) const override {
    if (clouds_[i].points.empty()) throw Error(ErrorCode::fileUnreadable, "its file is damaged");
    return clouds_[i];
  }
  ObjectImage image(std::size_t) const override { return {}; }

 private:
  std::vector<PointCloud> clouds_;
  std::vector<ObjectView> views_;
};

ShapeOptions quickShape(bool size = false, int threads = 0) {
  return {300, size, 1, threads};
}

TEST(Shape, PartsAreWhatIsDescribed) {
  const PointCloud ball = ellipsoid({0.1F, 0.1F, 0.1F});
  for (const bool size : {false, true}) {
    const std::vector<DescriptorPart> parts = noShapes(quickShape(size)).parts;
    std::size_t columns = 0;
    for (const DescriptorPart& part : parts) columns += part.size();
    EXPECT_EQ(describeShape(ball, quickShape(size)).size(), columns);
    EXPECT_EQ(parts.size(), size ? 2U : 1U);
  }
  ShapeOptions other = quickShape();
  other.samples = 301;
  EXPECT_NE(noShapes(other).parts[0].identity, noShapes(quickShape()).parts[0].identity);
}

TEST(Shape, SizeIsInMetersWhereverTheThingLies) {
  std::vector<float> numbers = describeShape(ellipsoid({0.1F, 0.4F, 0.2F}, {1, 2, 3}), quickShape(true));
  numbers.erase(numbers.begin(), numbers.end() - 4);
  const float root3 = std::sqrt(3.0F);  // an even sphere spreads by its radius / √3
  EXPECT_NEAR(numbers[0], 0.4F / root3, 0.01);
  EXPECT_NEAR(numbers[1], 0.2F / root3, 0.01);
  EXPECT_NEAR(numbers[2], 0.1F / root3, 0.01);
  EXPECT_NEAR(numbers[3], 0.4F, 0.01);
  PointCloud ball = ellipsoid({0.1F, 0.2F, 0.3F});
  const std::vector<float> whole = describeShape(ball, quickShape(true));
  ball.points.insert(ball.points.begin() + 7, cv::Point3f(NAN, 0, 0));
  ball.width = ball.points.size();
  EXPECT_EQ(describeShape(ball, quickShape(true)), whole) << "holes do not count";
}

TEST(Shape, WhatIsNoShapeIsRefused) {
  PointCloud line;
  for (int i = 0; i < 50; ++i) line.points.emplace_back(0.01F * static_cast<float>(i), 0, 0);
  line.width = 50;
  line.height = 1;
  PointCloud nothing;
  nothing.points.assign(60, {NAN, NAN, NAN});
  for (const bool size : {false, true}) {
    EXPECT_THAT([&] { describeShape(line, quickShape(size)); }, FailsWith(ErrorCode::insufficientData));
    EXPECT_THAT([&] { describeShape(nothing, quickShape(size)); }, FailsWith(ErrorCode::insufficientData));
    EXPECT_THAT([&] { describeShape({}, quickShape(size)); }, FailsWith(ErrorCode::insufficientData));
  }
  EXPECT_THAT([] { noShapes({.samples = 0}); }, FailsWith(ErrorCode::invalidOption));
  const Views unreadable({{}, {}});
  EXPECT_THAT([&] { describeShapes(unreadable, quickShape()); }, FailsWith(ErrorCode::insufficientData));
}

TEST(Shapes, OfAllViewsWhateverTheThreads) {
  PointCloud holes;
  holes.points.assign(100, {NAN, NAN, NAN});
  const Views views({ellipsoid({1, 1, 1}), holes, ellipsoid({1, 2, 1}), {}, ellipsoid({3, 1, 1})});
  std::vector<std::string> problems, again;
  const Features one = describeShapes(views, quickShape(true, 1), Progress::none(), &problems),
                 four = describeShapes(views, quickShape(true, 4), Progress::none(), &again);
  EXPECT_EQ(one.values.values(), four.values.values());
  EXPECT_EQ(problems, again);
  ASSERT_EQ(problems.size(), 2U);
  EXPECT_EQ(problems[0].substr(0, 6), "view 1");
  EXPECT_EQ(problems[1].substr(0, 6), "view 3");
  ASSERT_EQ(one.frames.size(), 3U);
  EXPECT_EQ(one.frames[1].name, "view 2");
  EXPECT_EQ(one.frames[1].room, "even");
  const std::vector<float> second(one.values.row(1).begin(), one.values.row(1).end());
  EXPECT_EQ(second, describeShape(ellipsoid({1, 2, 1}), quickShape(true)));
  EXPECT_EQ(one.parts, noShapes(quickShape(true)).parts);
}

}  // namespace
}  // namespace estancia
