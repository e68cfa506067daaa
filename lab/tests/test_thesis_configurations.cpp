// Configurations for owners of the thesis' data, run on made-up images in the published layouts.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "color_drive.hpp"
#include "counting.hpp"
#include "estancia/core/config.hpp"
#include "estancia/files/csv.hpp"
#include "recognition/model_pairs.hpp"
#include "recognition/recognition.hpp"
#include "runner/experiment.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::writeFile;
using testing::ElementsAre;
using testing::SizeIs;
namespace fs = std::filesystem;

/// An image of one color, with some noise.
cv::Mat imageOf(std::size_t room, int frame) {
  const std::vector<cv::Scalar> colors{{20, 20, 230}, {20, 230, 20}, {230, 20, 20}, {230, 230, 230}};
  cv::Mat image(24, 32, CV_8UC3, colors.at(room)), noise(image.size(), CV_8SC3);
  cv::RNG(static_cast<std::uint64_t>(frame)).fill(noise, cv::RNG::NORMAL, 0, 10);
  cv::add(image, noise, image, {}, CV_8UC3);
  return image;
}

class ThesisConfigurations : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch, "sharp", "0.02");
    setenv("ESTANCIA_DATA", (scratch / "data").c_str(), 1);
  }
  void TearDown() override { unsetenv("ESTANCIA_DATA"); }

  /// Four rooms in a row, eight images each, named as KTH-IDOL2 names them.
  void writeIdol2(const std::string& name) {
    const fs::path folder = scratch / "data" / "idol2" / name / "png";
    fs::create_directories(folder);
    const std::vector<std::string> rooms{"PA", "CR", "BO", "KT"};
    for (int i = 0; i < 32; ++i)
      cv::imwrite((folder / fmt::format("t{:.6f}_r{}_x{}_y{:g}_a-1.63046.png", 1138022369.798380 + 0.2 * i,
                                        rooms[static_cast<std::size_t>(i / 8)], 3 * (i / 8), 0.01 * (i % 8)))
                      .string(),
                  imageOf(static_cast<std::size_t>(i / 8), i));
  }

  /// A corridor of two colors and a toilet of one, six images each, with a cloud an image.
  void writeVidrilo(int sequence) {
    const fs::path root = scratch / "data" / "vidrilo", folder = root / fmt::format("Sequence{}", sequence);
    fs::create_directories(folder / "Visual");
    fs::create_directories(folder / "Depth");
    std::string cloud =
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 3\nPOINTS 12\nDATA "
        "ascii\n";
    for (int p = 0; p < 12; ++p) cloud += fmt::format("{} {} 2\n", (p % 4 - 1.5) / 10, (p / 4 - 1) / 10.0);
    const std::vector<std::string> categories{"Corridor", "Corridor", "Toilet"},
        classes{"CR-1", "CR-2", "TO-1"};
    std::string annotations, table = "image,category,class\n";
    for (int i = 0; i < 18; ++i) {
      const auto k = static_cast<std::size_t>(i / 6);
      const std::string name = fmt::format("sequence{}visual{}.png", sequence, i + 1);
      cv::imwrite((folder / "Visual" / name).string(), imageOf(k, i));
      writeFile(folder / "Depth" / fmt::format("sequence{}depth{}.pcd", sequence, i + 1), cloud);
      annotations += categories[k] + "\n";
      table += fmt::format("{},{},{}\n", name, categories[k], classes[k]);
    }
    writeFile(folder / "annotations.txt", annotations);
    writeFile(root / fmt::format("classes{}.csv", sequence), table);
  }

  fs::path config(const std::string& name) const {
    return fs::path(ESTANCIA_LAB_DIR) / "experiments" / "thesis" / name;
  }

  std::map<std::string, ResultTable> run(const std::string& name) {
    found = runExperiment({config(name)}, {scratch / "out", {scratch / "sharp"}, {"", 2}, nullptr}, progress);
    std::map<std::string, ResultTable> tables;
    for (const auto& section : found.sections)
      if (const auto* table = std::get_if<ResultTable>(&section)) tables[table->title] = *table;
    return tables;
  }

  test::ScratchFolder scratch;
  test::Counting progress{{}};
  Findings found;
};

std::vector<std::string> rowsOf(const ResultTable& table) {
  std::vector<std::string> names;
  for (const auto& row : table.rows) names.push_back(row.name);
  return names;
}

TEST_F(ThesisConfigurations, Idol2ChoosesAModelBesideTable41) {
  writeIdol2("min_cloudy1");
  writeIdol2("min_night3");
  const ResultTable beside = run("places-idol2.toml").at("Beside the thesis (Table 4.1)");
  EXPECT_THAT(found.notes, testing::Contains(testing::EndsWith("was left out")).Times(10));
  ASSERT_THAT(beside.rows, SizeIs(2 + 7));
  EXPECT_EQ(beside.rows[0].name, "sharp, l2");
  // Four colors and seven clusters: each holds images of one room, which lie 1 cm apart.
  EXPECT_LT(*beside.rows[0].values[0], 0.1);
  EXPECT_EQ(beside.rows[2].name, "(thesis: HybridAlexNet)");
  EXPECT_THAT(beside.rows[2].values, ElementsAre(5.49, 3.99, 2.50, 1.85));
}

TEST_F(ThesisConfigurations, Idol2IsMappedBesideTheAuthorsSweeps) {
  writeIdol2("min_cloudy3");
  writeIdol2("min_cloudy1");
  cv::imwrite(scratch / "data/idol2/min_cloudy1/png/odd.png", imageOf(0, 0));
  auto tables = run("maps-idol2.toml");
  EXPECT_THAT(found.notes, testing::Contains(testing::StartsWith("Cloudy 1: 1 images are left out")));
  EXPECT_THAT(rowsOf(tables.at("Images found in the map of Cloudy 1")), ElementsAre("Cloudy 1", "Cloudy 3"));
  EXPECT_EQ(tables.at("Images found in the map of Cloudy 1").columns.back().name, "author [%]");
  const ResultTable& sweep = tables.at("Cloudy 3, preset thesis");
  ASSERT_THAT(sweep.rows, SizeIs(31));
  EXPECT_EQ(sweep.columns.back().name, "author: score");
  const auto row = std::ranges::find(sweep.rows, "0.015, 0.002", &ResultTable::Row::name);
  ASSERT_NE(row, sweep.rows.end());
  EXPECT_EQ(row->values.back(), 78.461) << "his published map";
}

TEST_F(ThesisConfigurations, VidriloHasZonesOfClasses) {
  writeVidrilo(1);
  writeVidrilo(2);
  const auto tables = run("zones-vidrilo.toml");
  std::size_t within = 0;
  for (const auto& [title, table] : tables) within += std::ranges::count(rowsOf(table), "CR-1 · CR-2");
  EXPECT_GE(within, 2U) << "classes of one category are compared, by name";
  EXPECT_TRUE(std::ranges::any_of(tables, [](const auto& t) { return t.first.ends_with("(Table 5.3)"); }));
}

TEST_F(ThesisConfigurations, ShotIsReadByItsOwnPairing) {
  const fs::path root = scratch / "data" / "shot" / "Kinect";
  const std::string pose = "1 0 0 0.1\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  writeFile(root / "Meshes/Mario/mario000.ply", "");
  writeFile(root / "Scenes/2011/scene001.ply", "");
  writeFile(root / "Scenes/config/scene001-rs0.xf", pose);
  writeFile(root / "Scenes/config/Configscene001.ini",
            "[MODELS]\nNUMBER = 1\nMODEL_0 = \"/3D models/Kinect/Meshes/Mario/mario000.ply\"\n"
            "MODEL_0_GROUNDTRUTH = \"/3D models/Kinect/Scenes/2011/config/scene001-rs0.xf\"\n"
            "[SCENE]\nPATH = \"/3D models/Kinect/Scenes/2011/scene001.ply\"\n");
  ConfigFile file(config("recognition-shot.toml"));
  const auto options = readRecognition(file);
  EXPECT_THAT(readModelPairs(options.pairs, options.columns).pairs, SizeIs(1));
  EXPECT_TRUE(options.thesisTables);
}

}  // namespace
}  // namespace estancia::experiments
