// Rooms stood in and rooms seen on made-up images: colors that a camera sees through a door.
// SPDX-License-Identifier: Apache-2.0
#include "places/room_agreement.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "color_drive.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
namespace fs = std::filesystem;

class RoomAgreement : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch_, "sharp", "0.02");
    test::writeColorDrive(scratch_ / "drive", 1);
  }

  /// The four colors of the drive are the things of as many rooms, but room1 is seen from room0 and room1.
  void writeTruth() {
    std::string rooms,
        instances = "id,category,model,model_name,room,x,y,z,size_x,size_y,size_z,yaw_degrees\n",
        visible = "image,id,pixels,pixels_with_depth\n";
    for (int i = 0; i < 4; ++i) {
      rooms += fmt::format("{}{{\"name\": \"room{}\", \"polygon\": [[{}, 0], [{}, 0], [{}, 9]]}}",
                           i == 0 ? "" : ", ", i, i, i + 1, i + 1);
      instances += fmt::format("{},thing,m,n,room{},0,0,0,1,1,1,0\n", 10 + i, i);
    }
    for (int i = 0; i < 40; ++i)
      visible += fmt::format("{:04}.png,{},50,0\n", i, i < 5 ? 10 : i < 20 ? 11 : 10 + i / 10);
    writeFile(scratch_ / "drive/home.json", "{\"rooms\": [" + rooms + "]}");
    writeFile(scratch_ / "drive/instances.csv", instances);
    writeFile(scratch_ / "drive/visible.csv", visible);
  }

  const std::string drive_ = "[[drive]]\nname = \"four\"\npath = \"drive\"\n";

  Findings run(const std::string& text) {
    writeFile(scratch_ / "rooms.toml", "type = \"room-agreement\"\n" + text);
    return runExperiment({scratch_ / "rooms.toml"},
                         {scratch_ / "out", {scratch_ / "sharp"}, {"", 1}, nullptr}, progress_);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  test::ScratchFolder scratch_;
  Progress progress_;
};

/// Value of the first drive in the table of a method.
double cellOf(const Findings& findings, const std::string& method, const std::string& column) {
  for (const auto& section : findings.sections) {
    const auto& table = std::get<ResultTable>(section);
    for (std::size_t c = 0; table.title == method && c < table.columns.size(); ++c)
      if (table.columns[c].name == column) return table.rows.at(0).values[c].value();
  }
  ADD_FAILURE() << "no " << column << " of " << method;
  return -1;
}

TEST_F(RoomAgreement, TellsRoomsSeenFromRoomsStoodIn) {
  writeTruth();
  const Findings found = run(drive_);
  ASSERT_EQ(found.sections.size(), 8U) << "all methods where none is named";
  EXPECT_EQ(cellOf(found, "rooms", "frames"), 40);
  EXPECT_EQ(cellOf(found, "rooms", "rooms"), 4);
  EXPECT_EQ(cellOf(found, "rooms", "V-measure"), 1);
  EXPECT_EQ(cellOf(found, "rooms", "see another room"), 5.0 / 40);
  EXPECT_EQ(cellOf(found, "rooms", "seen: purity"), 35.0 / 40);
  EXPECT_EQ(cellOf(found, "rooms-seen", "purity"), 35.0 / 40)
      << "an oracle that sees, but does not know where";
  EXPECT_EQ(cellOf(found, "rooms-seen", "seen: V-measure"), 1);
  EXPECT_EQ(cellOf(found, "zones-as-rooms", "clusters"), 4) << "as many zones as rooms";
  EXPECT_GT(cellOf(found, "places", "V-measure"), 0.9);
  EXPECT_LT(cellOf(found, "places", "seen: V-measure"), cellOf(found, "places", "V-measure"));
  for (const auto& entry : fs::directory_iterator(scratch_ / "out"))
    EXPECT_NE(entry.path().extension(), ".estancia") << "maps are made and gone";
}

TEST_F(RoomAgreement, KnowsOnlyTheRoomsStoodInWithoutAHome) {
  const Findings found = run(drive_ + "[[drive]]\nname = \"absent\"\npath = \"nowhere\"\noptional = true\n");
  EXPECT_GT(cellOf(found, "places", "V-measure"), 0.9);
  for (const auto& column : std::get<ResultTable>(found.sections[0]).columns)
    EXPECT_EQ(column.name.find("seen"), std::string::npos);
  EXPECT_EQ(found.notes.size(), 1U);
}

TEST_F(RoomAgreement, IsTheSameAgainAndComputedOnce) {
  writeTruth();
  run(drive_);
  const std::string before = readFile(scratch_ / "out/results.csv");
  run(drive_);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), before);
  fs::remove_all(scratch_ / "out");
  run(drive_);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), before);
}

TEST_F(RoomAgreement, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(problem(""), FailsWith(ErrorCode::malformedFile, "`drive`"));
  EXPECT_THAT(problem("methods = [\"areaz\"]\n" + drive_), FailsWith(ErrorCode::malformedFile, "areaz"));
  EXPECT_THAT(problem(drive_ + drive_), FailsWith(ErrorCode::invalidInput, "four"));
  EXPECT_THAT(problem(drive_ + "paht = \"x\"\n"), FailsWith(ErrorCode::malformedFile, "`paht`"));
  EXPECT_THAT(problem("[[drive]]\nname = \"x\"\npath = \"nowhere\"\n"),
              FailsWith(ErrorCode::fileNotFound, "nowhere"));
  EXPECT_THAT(problem("[[drive]]\nname = \"x\"\npath = \"nowhere\"\noptional = true\n"),
              FailsWith(ErrorCode::insufficientData));
  writeFile(scratch_ / "drive/home.json", "{}");
  EXPECT_THAT(problem(drive_), FailsWith(ErrorCode::malformedFile, "home.json"));
}

}  // namespace
}  // namespace estancia::experiments
