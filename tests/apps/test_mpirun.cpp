// `mpirun estancia merge` as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "estancia/session/session.hpp"
#include "support/mpirun.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;

/// Map of a robot that has driven through twenty places from this one on.
void driveFrom(std::size_t first, const fs::path& map) {
  SyntheticPlaces places(40, 60, 0.5);
  std::vector<std::string> names;
  for (int i = 0; i < 60; ++i) names.push_back("word " + std::to_string(i));
  MappingSession session = MappingSession::create(map, Vocabulary(names), "test", {});
  for (std::size_t i = 0; i < 80; ++i) {
    Frame frame;
    frame.name = fmt::format("{} {}", first, i);
    session.add(frame, places.image(first + i / 4));
  }
}

TEST_F(MpirunTest, MergesAsASingleProcessDoes) {
  std::vector<std::string> merge{"merge"};
  for (std::size_t robot = 0; robot < 21; ++robot) {  // six blocks of pairs
    merge.push_back(scratch_ / fmt::format("{}.estancia", robot));
    driveFrom(robot, merge.back());
  }
  auto alone = merge, together = merge;
  for (const std::string& word : {std::string("-o"), (scratch_ / "alone").string()}) alone.push_back(word);
  for (const std::string& word : {std::string("-o"), (scratch_ / "together").string()})
    together.push_back(word);
  ASSERT_EQ(run(alone).exitCode, 0);
  const auto merged = finish(start(3, together));
  ASSERT_EQ(merged.exitCode, 0) << merged.err;
  EXPECT_THAT(merged.out, testing::HasSubstr("21 drives, 1,680 frames"));
  const TopologicalMap a = readMap(scratch_ / "alone"), b = readMap(scratch_ / "together");
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  EXPECT_NEAR(static_cast<double>(a.nodes.size()), 40, 4);
  for (std::size_t i = 0; i < a.nodes.size(); ++i) EXPECT_EQ(a.nodes[i].mean, b.nodes[i].mean) << i;
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) EXPECT_EQ(a.frames[i].node, b.frames[i].node) << i;
  const auto again = finish(start(3, together));
  EXPECT_EQ(again.exitCode, 2) << "it is there already";
  EXPECT_THAT(again.err, testing::HasSubstr("[file-exists]"));
}

TEST(MpirunModule, IsLoadedByNobodyElse) {
  std::string maps;
  {
    const ScratchFolder scratch;
    const std::string command =
        fmt::format("LD_DEBUG=files '{}' merge '{}' '{}' -o '{}' 2>'{}' >/dev/null", ESTANCIA_COMMAND,
                    (scratch / "none").string(), (scratch / "neither").string(), (scratch / "out").string(),
                    (scratch / "log").string());
    EXPECT_NE(std::system(command.c_str()), 0);
    maps = readFile(scratch / "log");
  }
  EXPECT_NE(maps.find("libfmt"), std::string::npos) << "the loader logs";
  EXPECT_EQ(maps.find("libmpi"), std::string::npos);
  EXPECT_EQ(maps.find("estancia_mpi"), std::string::npos);
}

}  // namespace
}  // namespace estancia::test
