// The live page in a browser, wide and on a phone.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <future>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <variant>

#include "estancia/live/map_file_view.hpp"
#include "estancia/site/page_server.hpp"
#include "fake_view.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FakeView;
using test::optionsAt;

/// A browser (Debian's chromium, by npm's puppeteer-core) that page.mjs leads over a live page. `kind`:
/// "live" or "at rest"; ESTANCIA_SCREENSHOTS names a folder to see what the browser shows. What comes is not
/// valid without a browser.
std::future<test::CommandResult> browse(const PageServer& server, int width, const std::string& kind) {
  const auto modules = test::findFetched("test-tools/node_modules");
  if (!modules) return {};
  std::vector<std::string> arguments{std::string(ESTANCIA_SOURCE_DIR) + "/tests/site/page.mjs",
                                     modules->string(), server.url(), std::to_string(width), kind};
  if (const char* folder = std::getenv("ESTANCIA_SCREENSHOTS")) arguments.emplace_back(folder);
  return std::async(std::launch::async, [arguments] { return test::runProgram("node", arguments); });
}

std::vector<unsigned char> colorfulImage() {
  cv::Mat image(240, 320, CV_8UC3);
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.cols; ++column)
      image.at<cv::Vec3b>(row, column) =
          cv::Vec3b(static_cast<uchar>(row), static_cast<uchar>(column / 2), 140);
  std::vector<unsigned char> jpeg;
  cv::imencode(".jpg", image, jpeg);
  return jpeg;
}

class LivePage : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Widths, LivePage, testing::Values(1280, 390),
                         [](const auto& of) { return std::to_string(of.param); });

/// The last object comes and goes; the robot turns.
void moveOn(FakeView& view, int step) {
  view.change([step](LiveStatus& status, std::shared_ptr<const WorldMap>& world) {
    WorldMap next = *world;
    if (next.objects.size() == 6)
      next.objects.pop_back();
    else
      next.objects.push_back(test::sampleObjects().back());
    world = std::make_shared<const WorldMap>(std::move(next));
    ++status.mapRevision;
    ++status.frames;
    status.pose = Pose::planar(2, 2, 0.1 * step);
  });
}

TEST_P(LivePage, ShowsAnswersAndKeepsCorrections) {
  FakeView view;
  view.setImage(colorfulImage());
  view.change([](LiveStatus& status, auto&) { status.troubles = {"no frame <for> 3 s"}; });
  auto server = std::make_unique<PageServer>(view, optionsAt(0));
  auto browser = browse(*server, GetParam(), "live");
  if (!browser.valid()) GTEST_SKIP() << "needs the tests' npm packages";
  for (int step = 0; browser.wait_for(std::chrono::milliseconds(300)) != std::future_status::ready; ++step) {
    if (step % 5 == 0) moveOn(view, step);
    if (view.world()->areas[1].givenName != "restart") continue;
    view.edit(NameArea{1, ""});
    const int port = server->port();
    server.reset();
    server = std::make_unique<PageServer>(view, optionsAt(port));
  }
  const test::CommandResult result = browser.get();
  EXPECT_EQ(result.exitCode, 0) << result.out << result.err;

  std::vector<std::size_t> kinds;
  for (const MapEdit& edit : view.edits()) kinds.push_back(edit.index());
  EXPECT_THAT(kinds, testing::ElementsAre(0, 4, 1, 2, 0, 0));
  if (kinds.size() < 4) return;
  EXPECT_EQ(std::get<NameArea>(view.edits()[0]).name, "Spa & \"Sauna\" <i>");
  EXPECT_EQ(std::get<DeleteObject>(view.edits()[1]).object, 1);
  EXPECT_EQ(std::get<MergeAreas>(view.edits()[2]).other, 2);
  const auto split = std::get<SplitArea>(view.edits()[3]);
  EXPECT_NEAR(split.from.x, 7, 0.2);
  EXPECT_NEAR(split.to.x, 9, 0.2);
  EXPECT_NEAR(split.to.y, 4, 0.2);
}

TEST_P(LivePage, ShowsAMapAtRest) {
  const test::ScratchFolder folder;
  const auto file = folder / "home.estancia";
  test::writeWorld(test::sampleWorld(), file);
  MapFileView view(file);
  const PageServer server(view, optionsAt(0));
  auto browser = browse(server, GetParam(), "at rest");
  if (!browser.valid()) GTEST_SKIP() << "needs the tests' npm packages";
  const test::CommandResult result = browser.get();
  EXPECT_EQ(result.exitCode, 0) << result.out << result.err;
  EXPECT_EQ(readWorld(file).areas[1].givenName, "Spa & \"Sauna\" <i>");
}

}  // namespace
}  // namespace estancia
