// Drawings: their texts, colors and layouts, and images of clouds, objects and floors.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "estancia/core/error.hpp"
#include "estancia/figures/annotated_image.hpp"
#include "estancia/figures/cloud_image.hpp"
#include "estancia/figures/color.hpp"
#include "estancia/figures/html.hpp"
#include "estancia/figures/layout.hpp"
#include "support/errors.hpp"
#include "support/report_map.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia::report {
namespace {

using test::FailsWith;
using test::sampleMap;
using test::sampleWorld;

TEST(Text, BrokenUtf8BecomesReplacementCharacters) {
  EXPECT_EQ(cleanText("caf\xC3\xA9"), "café");
  EXPECT_EQ(cleanText("a\xFF"
                      "b"),
            "a\uFFFDb");
  EXPECT_EQ(cleanText("cut \xE2\x82"), "cut \uFFFD\uFFFD");
  EXPECT_EQ(cleanText("\xC0\xAF"), "\uFFFD\uFFFD") << "an overlong slash";
  EXPECT_EQ(cleanText("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD") << "a surrogate";
}

TEST(Text, ControlCharactersAndLineBreaksBecomeBlanks) {
  EXPECT_EQ(cleanText(std::string("a\0b\nc\x1B", 6)), "a b c ");
  EXPECT_EQ(cleanText("a\u2028b"), "a b");
}

TEST(Text, IsShortenedToAWidthInAnyScript) {
  EXPECT_EQ(shortenToWidth("corridor", 10), "corridor");
  for (const std::string text : {"a corridor with a view", "日本語の名前の廊下"}) {
    const std::string cut = shortenToWidth(text, 5);
    EXPECT_LE(textWidth(cut), 5) << cut;
    EXPECT_GT(textWidth(cut), 3) << cut;
    EXPECT_TRUE(cut.ends_with("…"));
  }
  EXPECT_EQ(shortenToWidth("corridor", 0), "…");
  EXPECT_LT(textWidth("éé"), textWidth("日本"));
  EXPECT_EQ(firstSynonym("mug , cup"), "mug");
  EXPECT_EQ(firstSynonym(" , cup"), " , cup") << "nothing stands before the comma";
}

TEST(Text, NumbersHaveNoTrailingZeros) {
  EXPECT_EQ(number(1.5), "1.5");
  EXPECT_EQ(number(-0.001), "0");
  EXPECT_EQ(number(100), "100");
  EXPECT_EQ(significant(0.0123), "0.0123");
  EXPECT_EQ(significant(123.4), "123");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1234567), "1,234,567");
  EXPECT_EQ(significant(0.0 / 0.0), "n/a");
}

TEST(Html, EscapesEverythingThatCouldEndATextOrAnAttribute) {
  EXPECT_EQ(escapeHtml("<a href=\"x\" id='y'>&"), "&lt;a href=&quot;x&quot; id=&#39;y&#39;&gt;&amp;");
  Markup markup;
  markup.element("p", {{"title", "\"><script>"}}, "</p><script>");
  EXPECT_EQ(markup.str(), "<p title=\"&quot;&gt;&lt;script&gt;\">&lt;/p&gt;&lt;script&gt;</p>");
}

TEST(Html, JsonCannotCloseItsScript) {
  EXPECT_EQ(jsonForScript("[\"</script><!--\"]"), "[\"\\u003c/script>\\u003c!--\"]");
  EXPECT_EQ(jsonForScript("\"a\u2028b\u2029\""), "\"a\\u2028b\\u2029\"");
}

TEST(Html, ImagesAreEmbeddedByTheirBytesAndOthersRefused) {
  EXPECT_EQ(imageUri({0xFF, 0xD8, 0xFF, 0xE0}, "x"), "data:image/jpeg;base64,/9j/4A==");
  for (const auto& [type, head] : {std::pair<std::string, std::string>{"gif", "GIF89a"},
                                   {"webp", "RIFF1234WEBPVP8"},
                                   {"png", "\x89PNG\r\n\x1A\n"}})
    EXPECT_EQ(imageUri({head.begin(), head.end()}, "x").find("data:image/" + type + ";base64,"), 0U);
  for (const std::string riff : {"RIFF1234WAVEfmt", "RIFF"})
    EXPECT_THROW(imageUri({riff.begin(), riff.end()}, "sound"), Error);
  const std::string svg = "<svg onload='x'/>";
  EXPECT_THROW(imageUri({svg.begin(), svg.end()}, "plan.svg"), Error);
  EXPECT_THROW(imageUri({}, "empty.jpg"), Error);
}

TEST(Color, ViridisRunsFromPurpleToYellowAndStaysInside) {
  EXPECT_EQ(viridis(0).hex(), "#440154");
  EXPECT_EQ(viridis(1).hex(), "#fde725");
  EXPECT_EQ(viridis(-3).hex(), viridis(0).hex());
  EXPECT_EQ(viridis(7).hex(), viridis(1).hex());
  EXPECT_EQ(viridis(0.0 / 0.0).hex(), viridis(0).hex());
  EXPECT_EQ(viridis(0).ink(), "#fff");
  EXPECT_EQ(viridis(1).ink(), "#000");
}

TEST(Color, ManyClassesLookDifferent) {
  for (const auto style : {classStyle, symbolStyle}) {
    std::set<std::pair<std::string, std::size_t>> seen;
    for (std::size_t i = 0; i < distinctClasses; ++i) seen.emplace(style(i).fill.hex(), style(i).shape);
    EXPECT_EQ(seen.size(), distinctClasses);
  }
}

double distance(const Point& a, const Point& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

void expectFiniteAndApart(const std::vector<Point>& points, double least) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_TRUE(std::isfinite(points[i].x) && std::isfinite(points[i].y)) << "node " << i;
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE(distance(points[i], points[j]), least) << i << " and " << j;
  }
}

std::vector<Link> ring(std::size_t n) {
  std::vector<Link> links;
  for (std::size_t i = 0; i + 1 < n; ++i) links.push_back({i, i + 1, 1, 0});
  if (n > 2) links.push_back({0, n - 1, 1, 0});
  return links;
}

TEST(GraphLayout, ARingIsDrawnRound) {
  const auto points = layoutGraph(12, ring(12));
  expectFiniteAndApart(points, 0.3);
  Point center;
  for (const Point& p : points) center = {center.x + p.x / 12, center.y + p.y / 12};
  const double radius = distance(points[0], center);
  for (const Point& p : points) EXPECT_NEAR(distance(p, center), radius, 0.15 * radius);
}

TEST(GraphLayout, UnconnectedAndLonelyNodesFindAPlace) {
  expectFiniteAndApart(layoutGraph(6, {{0, 1, 1, 0}, {2, 3, 1, 1}}), 0.1);
  expectFiniteAndApart(layoutGraph(1, {}), 0);
  EXPECT_TRUE(layoutGraph(0, {}).empty());
}

TEST(Separation, NodesAtOnePlacePartAndStayInTheBox) {
  std::vector<Point> centers(15, Point{100, 100});
  const std::vector<double> radii(15, 10);
  separate(centers, radii, 4, {0, 0, 200, 200});
  expectFiniteAndApart(centers, 23.5);
  for (const Point& p : centers) {
    EXPECT_GE(std::min(p.x, p.y), 10);
    EXPECT_LE(std::max(p.x, p.y), 190);
  }
}

TEST(MapPlane, AMapInACamerasFrameIsSeenFromAbove) {
  const GroundPlane plane = planeOf({{0, 0, 0}, {3, 0.01, 1}, {-2, 0, 5}, {4, 0.02, 4}});  // y points down
  const Point p = plane.project({3, 7, 1});
  EXPECT_DOUBLE_EQ(p.x, 3);
  EXPECT_DOUBLE_EQ(p.y, 1);
}

TEST(MapPlane, OfNothingOrOnePointOrAWallIsThatOfTheFloorOrTheWall) {
  for (const std::vector<cv::Vec3d>& positions :
       {std::vector<cv::Vec3d>{}, {{1, 2, 3}, {1, 2, 3}}, {{0, 0, 1}, {3, 1, 1}, {1, 4, 1}}}) {
    const Point p = planeOf(positions).project({3, 7, 1});
    EXPECT_EQ(p.x, 3);
    EXPECT_EQ(p.y, 7);
  }
  EXPECT_EQ(planeOf({{1, 0, 0}, {1, 3, 1}, {1, 1, 4}}).project({3, 7, 1}).x, 7);
}

TEST(MapPlane, ATiltedMapIsSeenAlongItsLeastSpread) {
  for (const auto& [x, y] : {std::pair{0.5, 0.4}, {-0.5, 0.4}, {0.5, -0.4}, {1.0, 3.0}, {1.0, -3.0}}) {
    std::vector<cv::Vec3d> positions;  // a curve in the plane z = x + y, or in one that leans elsewhere
    positions.reserve(40);
    for (int i = 0; i < 40; ++i)
      positions.push_back({std::cos(i), std::sin(i), x * std::cos(i) + y * std::sin(i)});
    const GroundPlane plane = planeOf(positions);
    for (const auto& p : positions) {
      const Point flat = plane.project(p);
      EXPECT_NEAR(std::hypot(flat.x, flat.y), std::hypot(p[0], p[1], p[2]), 1e-9);
    }
    const cv::Vec3d normal = plane.right.cross(plane.up);
    EXPECT_GT(std::abs(y) > 2 ? -normal[1] : normal[2], 0) << "the map is mirrored";
  }
}

TEST(MapLayout, NodesWithoutPosesLieAmongTheirNeighbors) {
  TopologicalMap map = sampleMap();
  for (MappedFrame& frame : map.frames)
    if (frame.node == 2) frame.pose.reset();
  const MapLayout layout = layoutMap(summarize(map), false);
  EXPECT_TRUE(layout.metric);
  EXPECT_NEAR(layout.nodes[2].x, (layout.nodes[1].x + layout.nodes[3].x) / 2, 1e-9);
}

TEST(MapLayout, AbsurdPosesAreNoPlaces) {
  TopologicalMap map = sampleMap();
  map.frames[0].pose->x = std::numeric_limits<double>::quiet_NaN();
  map.frames[1].pose->y = 1e300;
  const MapLayout layout = layoutMap(summarize(map), false);
  EXPECT_FALSE(layout.frames[0].has_value());
  EXPECT_FALSE(layout.frames[1].has_value());
  expectFiniteAndApart(layout.nodes, 0.1);
}

/// A square of `half` at distance z before the sensor.
PointCloud square(float half, float z) {
  PointCloud cloud;
  for (float x = -half; x <= half; x += half / 40)
    for (float y = -half; y <= half; y += half / 40) cloud.points.emplace_back(x, y, z);
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

CloudLayer layer(const PointCloud& cloud, const cv::Vec3b& color) {
  return {&cloud, cv::Affine3d::Identity(), color, {}};
}

int count(const cv::Mat& image, const cv::Vec3b& color) {
  cv::Mat same;
  cv::inRange(image, color, color, same);
  return cv::countNonZero(same);
}

const cv::Vec3b red(0, 0, 255), blue(255, 0, 0);

TEST(CloudImage, FillsTheImageAndKeepsShapes) {
  const PointCloud wall = square(1, 3);
  const std::array layers{layer(wall, red)};
  const cv::Mat image = drawClouds(layers, {.width = 400, .height = 300});
  ASSERT_EQ(image.size(), cv::Size(400, 300));
  cv::Mat drawn;
  cv::inRange(image, red, red, drawn);
  const cv::Rect box = cv::boundingRect(drawn);
  EXPECT_NEAR(box.height, 282, 12);                       // 94 % of the height …
  EXPECT_NEAR(box.width, box.height, 4);                  // … and square
  EXPECT_GT(cv::countNonZero(drawn), 0.95 * box.area());  // without holes
}

TEST(CloudImage, WhatIsNearerHidesWhatIsBehindIt) {
  const PointCloud wall = square(1, 3), thing = square(0.3F, 2);
  const std::array front{layer(wall, red), layer(thing, blue)};
  EXPECT_GT(count(drawClouds(front), blue), 10000);
  const PointCloud hidden = square(0.3F, 4);
  const std::array behind{layer(wall, red), layer(hidden, blue)};
  EXPECT_EQ(count(drawClouds(behind), blue), 0);
}

TEST(CloudImage, LeavesOutWhatLiesBesideItOrIsNoPoint) {
  PointCloud wall = square(1, 3);
  const int alone = count(drawClouds(std::array{layer(wall, red)}), red);
  for (const cv::Point3f& far : {cv::Point3f(50, 0, 3), {-50, 0, 3}, {0, 50, 3}, {0, -50, 3}, {0, 0, -50}})
    wall.points.push_back(far);
  wall.points.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.F, 0.F);
  wall.width = wall.points.size();
  EXPECT_NEAR(count(drawClouds(std::array{layer(wall, red)}), red), alone, 0.1 * alone);
  CloudLayer plain{&wall, cv::Affine3d::Identity(), std::nullopt, {}};
  const cv::Mat gray = drawClouds(std::array{plain});
  wall.colors.assign(wall.points.size(), blue);
  EXPECT_EQ(count(gray, blue), 0);
  EXPECT_GT(count(drawClouds(std::array{plain}), blue), 10000) << "a cloud's own colors";
  const std::array<std::array<std::uint32_t, 2>, 3> edges{{{0, 70000}, {70000, 0}, {0, 6561}}};
  plain.edges = edges;
  EXPECT_NO_THROW(drawClouds(std::array{plain}));
}

TEST(CloudImage, ShowsCloudsAroundTheOriginAndBelowIt) {
  for (const float z : {0.F, 5.F}) {
    PointCloud lying = square(1, z);
    for (cv::Point3f& p : lying.points) p = {p.x, p.z, p.y};
    const std::array layers{layer(lying, red)};
    EXPECT_GT(count(drawClouds(layers, {.elevation = 40}), red), 10000) << z;
  }
}

TEST(CloudImage, MovesWithPoseAndDrawsEdges) {
  const PointCloud wall = square(1, 3);
  PointCloud pair;
  pair.points = {{-0.5F, 0, 2}, {0.5F, 0, 2}};
  pair.width = 2;
  pair.height = 1;
  const std::array<std::array<std::uint32_t, 2>, 2> edges{
      {{0, 1}, {0, 7}}};  // color of a point that is not finite: left out
  const std::array layers{layer(wall, red), CloudLayer{&pair, cv::Affine3d::Identity(), blue, edges}};
  const int across = count(drawClouds(layers), blue);
  EXPECT_GT(across, 200);
  const std::array away{layer(wall, red),
                        CloudLayer{&pair, cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, 5)), blue, edges}};
  EXPECT_EQ(count(drawClouds(away), blue), 0);
}

TEST(CloudImage, RefusesNothingToDraw) {
  EXPECT_THAT([] { drawClouds({}); }, FailsWith(ErrorCode::invalidInput));
  PointCloud none;
  none.points = {{std::numeric_limits<float>::quiet_NaN(), 0, 0}};
  none.width = none.height = 1;
  const std::array layers{layer(none, red)};
  EXPECT_THAT([&] { drawClouds(layers); }, FailsWith(ErrorCode::invalidInput));
  const PointCloud wall = square(1, 3);
  const std::array one{layer(wall, red)};
  for (const CloudView& view : {CloudView{2, 960}, {1280, 2}, {20000, 960}, {1280, 20000}})
    EXPECT_THAT([&] { drawClouds(one, view); }, FailsWith(ErrorCode::invalidOption));
}

PredictedObject thingAt(const cv::Rect& box, FusedAnswer::Source source, int word) {
  PredictedObject object;
  object.box = box;
  object.answer = {source, word, 0.8, ""};
  return object;
}

int pixelsOf(const cv::Mat& image, const cv::Vec3b& color) {
  int count = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) count += image.at<cv::Vec3b>(y, x) == color ? 1 : 0;
  return count;
}

TEST(ObjectImage, ColorsTellWhatIsBelieved) {
  const cv::Mat image(240, 320, CV_8UC3, cv::Scalar::all(7));
  const cv::Vec3b green(115, 158, 0), blue(178, 114, 0), orange(0, 159, 230), gray(128, 128, 128);
  const cv::Mat drawn =
      drawObjects(image,
                  std::vector<PredictedObject>{thingAt({20, 50, 60, 60}, FusedAnswer::Source::both, 0),
                                               thingAt({120, 50, 60, 60}, FusedAnswer::Source::shape, 1),
                                               thingAt({220, 50, 60, 60}, FusedAnswer::Source::image, 0),
                                               thingAt({20, 150, 60, 60}, FusedAnswer::Source::none, -1)},
                  {"mug", "Töpfe"});
  for (const cv::Vec3b& color : {green, blue, orange, gray}) EXPECT_GT(pixelsOf(drawn, color), 200);
  EXPECT_EQ(pixelsOf(image, {7, 7, 7}), 240 * 320) << "what was given stays as it is";
  EXPECT_EQ(drawn.at<cv::Vec3b>(80, 50), cv::Vec3b(7, 7, 7)) << "the thing can be seen in its box";
}

TEST(ObjectImage, BoxesMayTouchTheBorder) {
  const cv::Mat image(50, 40, CV_8UC3, cv::Scalar::all(7));
  EXPECT_EQ(drawObjects(image, std::vector{thingAt({0, 0, 40, 50}, FusedAnswer::Source::both, 0)},
                        {"a word that is wider than the image"})
                .size(),
            image.size());
}

TEST(ObjectImage, RefusesGrayImagesAndWordsWithoutAName) {
  EXPECT_THAT([] { drawObjects(cv::Mat(9, 9, CV_8U), {}, {}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(([] {
                drawObjects(cv::Mat(9, 9, CV_8UC3),
                            std::vector{thingAt({0, 0, 5, 5}, FusedAnswer::Source::both, 3)}, {"mug"});
              }),
              FailsWith(ErrorCode::mismatch));
}

TEST(FloorPlan, ShowsAreasOrHeat) {
  const WorldMap world = sampleWorld();
  std::vector<Pose> poses;
  Zones zones{world.places.vocabulary};
  for (const MappedFrame& frame : world.places.frames) {
    zones.frames.push_back(frame);
    poses.push_back(*frame.pose);
  }
  const Areas areas{*world.plan, std::move(zones), WordMap(Floor(poses), 6)};
  const cv::Mat plan = drawFloorPlan(areas, nullptr, 300);
  EXPECT_NEAR(plan.cols, 300, 60);
  EXPECT_LT(pixelsOf(plan, {255, 255, 255}), static_cast<int>(plan.total()));
  const FloorHeat heat{areas.cells,
                       cv::Mat(areas.cells.rows(), areas.cells.columns(), CV_32F, cv::Scalar(0.5F))};
  EXPECT_GT(cv::norm(drawFloorPlan(areas, &heat, 300), plan), 0);
  const FloorHeat cold{areas.cells, heat.values * 0}, nowhere{FloorCells(0.1, {-900, -900, 1, 1}), {}};
  EXPECT_EQ(cv::norm(drawFloorPlan(areas, &cold, 300), drawFloorPlan(areas, &nowhere, 300)), 0);
}

}  // namespace
}  // namespace estancia::report
