// Rooms by their names alone: a made-up home with the real WordNet, and the figures that the project
// promises. SPDX-License-Identifier: Apache-2.0
#include "words/rooms_by_name.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "runner/experiment.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::HasSubstr;

/// Eight images each of a kitchen, a bathroom and a bedroom, labeled by hand: the last bedroom shows a stove.
class RoomsByName : public testing::Test {
 protected:
  void SetUp() override {
    const std::vector<std::string> rooms{"kitchen", "bathroom", "bed_room"},
        things{"stove", "bathtub", "four-poster"};
    std::string truth = "image,room\n", labels;
    fs::create_directory(scratch_ / "home");
    for (std::size_t i = 0; i < 24; ++i) {
      const std::string image = fmt::format("{:02}.png", i);
      cv::imwrite((scratch_ / "home" / image).string(), cv::Mat(8, 8, CV_8UC3, cv::Scalar(10.0 * i, 0, 0)));
      truth += fmt::format("{},{}\n", image, rooms[i / 8]);
      labels += fmt::format("{},{}\n", image, i == 23 ? things[0] : things[i / 8]);
    }
    writeFile(scratch_ / "home/rooms.csv", truth);
    writeFile(scratch_ / "person/labels.txt", "stove\nbathtub\nfour-poster\ntabby\n");
    writeFile(scratch_ / "person/h.csv", labels);
    writeFile(scratch_ / "person/model.toml",
              "name = \"person\"\ntype = \"human\"\nfile = \"h.csv\"\nlabels = \"labels.txt\"\n");
  }

  const std::string task_ = "[[task]]\nname = \"three\"\nrooms = [\"kitchen\", \"bathroom\", \"bed-room\"]\n",
                    data_ = "[[data]]\nname = \"home\"\npath = \"home\"\n";

  Findings run(const std::string& text) {
    writeFile(scratch_ / "rooms.toml", "type = \"rooms-by-name\"\n" + text);
    return runExperiment({scratch_ / "rooms.toml"},
                         {scratch_ / "out", {(scratch_ / "person").string()}, {"", 1}, nullptr}, progress_);
  }

  test::ScratchFolder scratch_;
  Progress progress_;
};

TEST_F(RoomsByName, AreMeasuredImageByImageAndInBlocks) {
  const Findings findings = run("block = 4\n" + task_ + data_);
  EXPECT_THAT(findings.summary, HasSubstr("95.8 % of the images and 100.0 % of the groups of home"));
  const std::string csv = readFile(scratch_ / "out/results.csv");
  EXPECT_THAT(csv, testing::StartsWith("model,data,task,of,images,chance,accuracy,"));
  EXPECT_THAT(csv, HasSubstr("\nperson,home,three,(all),24,0.333"));
  EXPECT_THAT(csv, HasSubstr("\nperson,home,three,bed_room,8,,0.875,,,2,1,"));
  EXPECT_THAT(csv, HasSubstr("\nperson,home,three,kitchen,8,,1,,,2,1,"));
  EXPECT_FALSE(csv.find("area") < csv.size());
}

TEST_F(RoomsByName, AskAboutTheImagesOfSomeRoomsAndWithoutAList) {
  run("[[task]]\nname = \"any\"\nonly = [\"kitchen\", \"bathroom\"]\n" + data_);
  const std::string csv = readFile(scratch_ / "out/results.csv");
  EXPECT_THAT(csv, HasSubstr("\nperson,home,any,(all),16,0.5,1,"));
  EXPECT_THAT(csv, HasSubstr("\nperson,home,any,bathroom,8,,1,"));
  EXPECT_FALSE(csv.find("bed_room") < csv.size());
}

TEST_F(RoomsByName, TellWhatIsWrong) {
  EXPECT_THAT([&] { run(task_); }, FailsWith(ErrorCode::malformedFile, "rooms.toml", "data"));
  EXPECT_THAT([&] { run(data_); }, FailsWith(ErrorCode::malformedFile, "rooms.toml", "task"));
  EXPECT_THAT([&] { run(task_ + task_ + data_); },
              FailsWith(ErrorCode::malformedFile, "rooms.toml:5", "three"));
  EXPECT_THAT([&] { run(task_ + "[[data]]\nname = \"home\"\npath = \"nowhere\"\noptional = true\n"); },
              FailsWith(ErrorCode::insufficientData, "nowhere", "path"));
  EXPECT_THAT([&] { run("groups = \"zones\"\n" + task_ + data_); },
              FailsWith(ErrorCode::malformedFile, "rooms.toml:2", "\"areas\""));
  EXPECT_THAT([&] { run("block = 0\n" + task_ + data_); },
              FailsWith(ErrorCode::malformedFile, "rooms.toml:2", "block"));
  EXPECT_THAT([&] { run("[[task]]\nname = \"none\"\nonly = [\"attic\"]\n" + data_); },
              FailsWith(ErrorCode::insufficientData, "home", "none"));
  EXPECT_THAT([&] { run("[[task]]\nname = \"x\"\nrooms = [\"kitchen\", \"xyzzy\"]\n" + data_); },
              FailsWith(ErrorCode::unknownName, "xyzzy"));
  EXPECT_THAT([&] { run("groups = \"areas\"\n" + task_ + data_); }, FailsWith(ErrorCode::insufficientData));
}

/// The figures that the project promises, by its own configurations with fewer models and data.
class RoomsOfTheProject : public testing::Test {
 protected:
  void SetUp() override {
    const auto inception = test::findFetched("models/inception-v3/inception-v3.onnx"),
               coco = test::findFetched("models/coco-ssd/coco-ssd.onnx");
    ESTANCIA_NEEDS(inception && coco, "the networks are not here; script/bootstrap fetches them");
  }

  /// Without the [[data]] that are called so. Returns results.csv.
  std::string results(const std::string& config, const std::vector<std::string>& without,
                      const std::string& models) {
    std::string text = readFile(fs::path(ESTANCIA_LAB_DIR) / "experiments/words" / config);
    for (const std::string& name : without) {
      const auto named = text.find("name = \"" + name + "\""), begin = text.rfind("[[data]]", named);
      text.erase(begin, text.find("\n[[data]]", named) - begin);
    }
    writeFile(scratch_ / config, text);
    const auto result =
        test::run({"experiment", "run", scratch_ / config, "-o", scratch_ / "out", "--models", models});
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return readFile(scratch_ / "out/results.csv");
  }

  test::ScratchFolder scratch_;
};

/// Value in a row by its first cells.
double valueIn(const std::string& csv, const std::string& row, std::size_t column) {
  const auto begin = csv.find("\n" + row + ",");
  if (begin == std::string::npos) throw std::runtime_error("no row " + row);
  std::size_t cell = begin + 1;
  for (std::size_t c = 0; c < column; ++c) cell = csv.find(',', cell) + 1;
  return std::stod(csv.substr(cell));
}

constexpr std::size_t accuracyColumn = 6, groupsColumn = 9, pooledColumn = 10, sureAccuracyColumn = 14;

TEST_F(RoomsOfTheProject, AreToldApartWithoutAnExample) {
  ESTANCIA_NEEDS(test::findData("nyuv2_half"), "the rooms are not here");
  const std::string csv = results("rooms.toml", {"train"}, "inception-v3,inception-v3+coco-ssd");
  EXPECT_GE(valueIn(csv, "inception-v3,test,five rooms,(all)", pooledColumn), 0.90);
  EXPECT_GE(valueIn(csv, "inception-v3+coco-ssd,test,five rooms,(all)", pooledColumn), 0.90);
  EXPECT_GE(valueIn(csv, "inception-v3+coco-ssd,test,five rooms,(all)", accuracyColumn), 0.72);
}

TEST_F(RoomsOfTheProject, NameTheAreasOfAHome) {
  ESTANCIA_NEEDS(test::findData("home_a/day") && test::findData("home_a/evening"), "the home is not here");
  const std::string csv = results("home-rooms.toml", {"slow"}, "inception-v3+coco-ssd");
  for (const std::string drive : {"day", "evening"}) {
    const std::string all = fmt::format("inception-v3+coco-ssd,{},six rooms,(all)", drive);
    EXPECT_EQ(valueIn(csv, all, groupsColumn), 6);
    EXPECT_GE(valueIn(csv, all, pooledColumn), 5.0 / 6 - 1e-9);
    EXPECT_EQ(valueIn(csv, all, sureAccuracyColumn), 1) << "no area has a wrong name";
  }
  for (const std::string area : {"living_room: living room", "study: study"})
    EXPECT_THAT(csv, testing::ContainsRegex(",evening,six rooms,area [0-9] in " + area + ","));
}

}  // namespace
}  // namespace estancia::experiments
