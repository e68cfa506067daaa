// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/ros_publisher.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <nlohmann/json.hpp>

#include "estancia/ros/messages.hpp"
#include "estancia/ros/wire.hpp"
#include "ros/dds_world.hpp"
#include "site/fake_view.hpp"

namespace estancia {
namespace {

TEST(RosPublisher, AMapBecomesMarkers) {
  const WorldMap world = test::sampleWorld();
  const std::vector<ros::Marker> markers = markersOf(world);
  EXPECT_EQ(markers.front().action, ros::Marker::Action::removeAll);
  const auto count = [&](const char* space) {
    return static_cast<std::size_t>(std::ranges::count(markers, space, &ros::Marker::space));
  };
  EXPECT_EQ(count("places"), world.places.nodes.size());
  EXPECT_EQ(count("objects"), world.objects.size());
  EXPECT_EQ(count("object names"), world.objects.size());
  EXPECT_GT(count("areas"), 0U);
  EXPECT_EQ(count("transitions"), 1U);
  const auto box = std::ranges::find(markers, "objects", &ros::Marker::space);
  EXPECT_EQ(box->position[0], world.objects.front().center.x);
  EXPECT_EQ(box->scale[2], world.objects.front().size.z);
}

TEST(RosPublisher, AMapWithoutPosesShowsNothing) {
  WorldMap world{test::sampleWorld().places};
  for (MappedFrame& frame : world.places.frames) frame.pose.reset();
  EXPECT_EQ(markersOf(world).size(), 1U);
}

TEST(RosPublisher, ANodeHearsWhereTheRobotIsAndTheMapThatWasThereBefore) {
  ESTANCIA_NEEDS_DDS();
  test::FakeView view;
  RosPublisher publisher(view, ros::makeDdsNode(test::domainOfTest()));
  std::mutex mutex;
  std::string where;
  std::size_t markers = 0;
  auto node = ros::makeDdsNode(test::domainOfTest());
  const auto map = node->subscribe("/estancia/map", "visualization_msgs/MarkerArray", [&](auto message) {
    const std::lock_guard lock(mutex);
    markers = ros::WireReader(message, ros::Encoding::cdr).number<std::uint32_t>();
  });
  const auto place = node->subscribe("/estancia/where", "std_msgs/String", [&](auto message) {
    const std::lock_guard lock(mutex);
    where = ros::readString({message, ros::Encoding::cdr});
  });
  ASSERT_TRUE(test::eventually([&] {
    view.change([](LiveStatus& status, auto&) { ++status.frames; });
    const std::lock_guard lock(mutex);
    return !where.empty() && markers > 0;
  }));
  EXPECT_EQ(nlohmann::json::parse(where)["area"]["name"], "kitchen");
  EXPECT_EQ(markers, markersOf(*view.world()).size());
}

}  // namespace
}  // namespace estancia
