// Scene classification on made-up images whose rooms are known: four colors, four rooms.
// SPDX-License-Identifier: Apache-2.0
#include "scenes/scenes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <utility>

#include "color_drive.hpp"
#include "counting.hpp"
#include "estancia/classify/room_classifier.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/csv.hpp"
#include "runner/experiment.hpp"
#include "scenes/scenes_data.hpp"
#include "support/errors.hpp"
#include "support/golden_findings.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::ElementsAre;
namespace fs = std::filesystem;

class Scenes : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch_, "sharp", "0.02");
    test::writeColorModel(scratch_, "blind", "1e-9");
    test::writeColorDrive(scratch_ / "one", 1);
    test::writeColorDrive(scratch_ / "two", 2);
    std::string halves = "number,kind,half\n";
    for (int i = 0; i < 40; ++i)
      halves += std::to_string(i) + ",room" + std::to_string(i / 10) + (i % 10 < 5 ? ",train\n" : ",test\n");
    writeFile(scratch_ / "halves.csv", halves);
  }

  std::string models(const std::vector<std::string>& descriptors) const {
    std::string list;
    for (const std::string& descriptor : descriptors) {
      // "sharp+phog" with the folder of each model
      std::string told = descriptor;
      for (const char* model : {"sharp", "blind"})
        if (const auto at = told.find(model); at != std::string::npos)
          told.replace(at, std::string(model).size(), (scratch_ / model).string());
      list += (list.empty() ? "\"" : ", \"") + told + "\"";
    }
    return "descriptors = [" + list + "]\n";
  }

  const std::string svm_ = "classifiers = [\"svm-linear\"]\n";
  const std::string pair_ =
      "[[data]]\nname = \"one\"\npath = \"one\"\n[[data]]\nname = \"two\"\npath = \"two\"\n";
  const std::string halves_ =
      "[[data]]\nname = \"drive\"\npath = \"one\"\ntable = \"halves.csv\"\nimage_column = \"number\"\n"
      "room_column = \"kind\"\nsplit_column = \"half\"\n";

  void write(const std::string& text) { writeFile(scratch_ / "study.toml", "type = \"scenes\"\n" + text); }
  Findings run(const std::string& text, int threads = 2) {
    write(text);
    return runExperiment({scratch_ / "study.toml"}, {scratch_ / "out", {}, {"", threads}, nullptr},
                         progress_);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  /// results.csv (or another table) by its first four cells.
  std::map<std::vector<std::string>, std::vector<std::string>> rows(const std::string& file = "results.csv",
                                                                    std::size_t coordinates = 4) const {
    std::map<std::vector<std::string>, std::vector<std::string>> found;
    for (const auto& row : io::readCsv(scratch_ / "out" / file)) {
      const auto middle = row.cells.begin() + static_cast<std::ptrdiff_t>(coordinates);
      found[{row.cells.begin(), middle}] = {middle, row.cells.end()};
    }
    return found;
  }

  /// What the cell of these coordinates answered.
  std::vector<int> answers(const std::vector<std::string>& coordinates) const {
    std::vector<int> found;
    for (const auto& file : fs::directory_iterator(scratch_ / "out/cells")) {
      const auto json = nlohmann::json::parse(readFile(file.path()));
      if (json.at("cell") != nlohmann::json(coordinates)) continue;
      for (const auto& result : json.at("results"))
        if (result[0] == "answer") found.push_back(result[2].get<int>());
    }
    return found;
  }

  /// The training features of compareScenes() for the study in study.toml.
  Features learned() const {
    ConfigFile config(scratch_ / "study.toml");
    Progress silent;
    std::vector<std::string> notes;
    const ScenesData data =
        describeScenes(readScenes(config), {scratch_ / "out", {}, {"", 1}, nullptr}, silent, notes);
    return data.images[data.pairs[0].train].features;
  }

  test::ScratchFolder scratch_;
  test::Counting progress_{{"classifying rooms", "choosing labels"}};
};

TEST_F(Scenes, HaveARowACell) {
  run(models({"sharp", "blind", "blind+phog", "sharp+blind"}) + svm_ + pair_);
  EXPECT_THAT(readFile(scratch_ / "out/results.csv"),
              testing::StartsWith("descriptor,classifier,train,test,accuracy,balanced_accuracy,"));
  const auto found = rows();
  EXPECT_EQ(found.size(), 1U + 4 * 4) << "two sequences, four pairs";
  EXPECT_EQ(found.at({"sharp", "svm-linear", "one", "two"})[0], "1");
  EXPECT_EQ(found.at({"sharp", "svm-linear", "two", "two"})[1], "1");
  EXPECT_LT(std::stod(found.at({"blind", "svm-linear", "one", "two"})[0]), 0.9);
  EXPECT_EQ(found.at({"sharp+blind", "svm-linear", "one", "two"}).size(), 4U);
  EXPECT_TRUE(found.contains({"blind+phog", "svm-linear", "two", "one"}));
}

TEST_F(Scenes, ShowHowTheirDescriptorsComeAbout) {
  const auto figures = [](const Findings& findings) {
    std::size_t images = 0;
    for (const auto& section : findings.sections)
      if (const auto* gallery = std::get_if<Images>(&section)) {
        for (const auto& image : gallery->images) EXPECT_FALSE(cv::imdecode(image.file, 1).empty());
        images += gallery->images.size();
      }
    return images;
  };
  EXPECT_EQ(figures(run(models({"phog", "gist"}) + svm_ + pair_)), 3U + 1);
  EXPECT_EQ(figures(run(models({"sharp"}) + svm_ + pair_)), 0U);
}

TEST_F(Scenes, ASequenceNeedNotBeAskedAboutItself) {
  run("same_sequence = false\n" + models({"sharp"}) + svm_ + pair_);
  const auto found = rows();
  EXPECT_EQ(found.size(), 1U + 2);
  EXPECT_FALSE(found.contains({"sharp", "svm-linear", "one", "one"}));
}

TEST_F(Scenes, OneSequencePartsIntoHalves) {
  run(models({"sharp"}) + svm_ + halves_);
  EXPECT_EQ(rows().at({"sharp", "svm-linear", "drive train", "drive test"})[0], "1");
  EXPECT_EQ(rows().size(), 2U);
  EXPECT_EQ(answers({"sharp", "svm-linear", "drive train", "drive test"}).size(), 20U);
}

TEST_F(Scenes, OtherImagesAreAskedAbout) {
  run(models({"sharp"}) + svm_ + "[[data]]\nname = \"drive\"\npath = \"one\"\n[data.test]\npath = \"two\"\n");
  EXPECT_EQ(rows().at({"sharp", "svm-linear", "drive train", "drive test"})[0], "1");
  EXPECT_EQ(rows().size(), 2U);
}

TEST_F(Scenes, AreTheSameForAnyNumberOfThreadsAndComputedOnce) {
  const std::string study = models({"sharp", "blind", "sharp+phog"}) + pair_;
  run(study, 1);
  const std::size_t cells = std::exchange(progress_.computed, 0);
  EXPECT_EQ(cells, 3U * 4 * classifierTypes().size());
  const std::string first = readFile(scratch_ / "out/results.csv");
  run(study, 3);
  EXPECT_EQ(progress_.computed, 0U);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), first);
  run("folds = 3\n" + study);
  EXPECT_EQ(std::exchange(progress_.computed, 0), cells);
  run("seeds = [2]\n" + study);
  EXPECT_EQ(std::exchange(progress_.computed, 0), cells);
  fs::remove_all(scratch_ / "out");
  run(study, 4);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), first);
}

TEST_F(Scenes, OnlyCellsWhoseImagesChangedAreComputedAgain) {
  const std::string study = "same_sequence = false\n" + models({"sharp"}) + svm_ + pair_ +
                            "[[data]]\nname = \"three\"\npath = \"three\"\n";
  test::writeColorDrive(scratch_ / "three", 3);
  run(study);
  EXPECT_EQ(std::exchange(progress_.computed, 0), 6U);
  test::writeColorDrive(scratch_ / "three", 4);
  run(study);
  EXPECT_EQ(progress_.computed, 4U);
}

TEST_F(Scenes, NothingIsLearnedFromTheTest) {
  const std::string study =
      "same_sequence = false\n" + models({"sharp", "sharp+phog"}) + svm_ +
      "[[data]]\nname = \"drive\"\npath = \"one\"\n[data.test]\npath = \"two\"\n"
      "[subsets]\ndescriptor = \"sharp\"\nclassifier = \"svm-linear\"\ncounts = [1, 2, 3]\n"
      "by = [\"mean\", \"mutual-information\", \"chi2\"]\n";
  run(study);
  const std::vector<std::string> cell{"sharp+phog", "svm-linear", "drive train", "drive test"};
  const std::vector<std::string> subset{"sharp", "svm-linear", "drive train", "drive test", "chi2", "2"};
  const auto before = answers(cell), before2 = answers(subset);
  const auto modelBytes = [&] {
    Progress silent;
    writeRoomClassifier(trainRoomClassifier(learned()), scratch_ / "model");
    return readFile(scratch_ / "model");
  };
  const std::string bytes = modelBytes();
  // Every other test image becomes noise, and the rooms of these are exchanged.
  std::string rooms = "image,room\n";
  cv::RNG random(5);
  for (int i = 0; i < 40; ++i) {
    const std::string name = (i < 10 ? "000" : "00") + std::to_string(i) + ".png";
    if (i % 2 == 0) {
      cv::Mat noise(48, 64, CV_8UC3);
      random.fill(noise, cv::RNG::UNIFORM, 0, 255);
      cv::imwrite((scratch_ / "two" / name).string(), noise);
    }
    rooms += name + ",room" + std::to_string(i % 2 == 0 ? 3 - i / 10 : i / 10) + "\n";
  }
  writeFile(scratch_ / "two/rooms.csv", rooms);
  EXPECT_EQ(modelBytes(), bytes);
  fs::remove_all(scratch_ / "out");
  run(study);
  const auto after = answers(cell), after2 = answers(subset);
  ASSERT_EQ(after.size(), 40U);
  ASSERT_EQ(after2.size(), 40U);
  EXPECT_NE(after, before);
  for (std::size_t i = 1; i < 40; i += 2) {
    EXPECT_EQ(after[i], before[i]) << i;
    EXPECT_EQ(after2[i], before2[i]) << i;
  }
}

TEST_F(Scenes, CrossValidationHoldsOutWholeRuns) {
  // Each run shows one image again and again, whose look is independent of its room: who has seen the run
  // knows the room, who has not can but guess.
  Features features{
      {{"look", PartKind::energies, {"a", "b", "c", "d", "e", "f"}, "look"}}, {}, DescriptorMatrix(6)};
  std::mt19937 random(3);
  for (int run = 0; run < 60; ++run) {
    std::vector<float> look(6);
    for (float& value : look) value = static_cast<float>(random() % 1000) / 1000;
    for (int i = 0; i < 4; ++i) {
      features.frames.push_back(
          {std::to_string(run * 4 + i) + ".png", {}, {}, run % 2 == 0 ? "hall" : "lab"});
      features.values.append(look);
    }
  }
  Progress silent;
  const std::string choice = trainRoomClassifier(features, {}, silent).choice();
  const auto percent = choice.find(" %"), begin = choice.rfind(' ', percent - 1);
  ASSERT_NE(percent, std::string::npos) << choice;
  EXPECT_LT(std::stod(choice.substr(begin, percent - begin)), 75) << choice;
}

TEST_F(Scenes, ARoomThatIsNeverLearnedCountsAsWrong) {
  run(models({"sharp"}) + svm_ +
      "[[data]]\nname = \"drive\"\npath = \"one\"\ntable = \"halves.csv\"\nimage_column = \"number\"\n"
      "room_column = \"kind\"\nsplit_column = \"half\"\n");
  std::string halves = "number,kind,half\n";
  for (int i = 0; i < 40; ++i)
    halves += std::to_string(i) + ",room" + std::to_string(i / 10) +
              (i < 30 && i % 10 < 5 ? ",train\n" : ",test\n");
  writeFile(scratch_ / "halves.csv", halves);
  const Findings findings = run(models({"sharp"}) + svm_ + halves_);
  const auto row = rows().at({"sharp", "svm-linear", "drive train", "drive test"});
  EXPECT_DOUBLE_EQ(std::stod(row[0]), 15.0 / 25);
  EXPECT_DOUBLE_EQ(std::stod(row[1]), 3.0 / 4);
  EXPECT_EQ(test::notesNaming(findings, "room3"), 1U);
}

TEST_F(Scenes, SubsetsOfLabelsHaveATableOfTheirOwn) {
  const std::string subsets =
      "[subsets]\ndescriptor = \"sharp\"\nclassifier = \"svm-linear\"\ncounts = [100, \"all\", 2, 4]\n"
      "by = [\"mean\", \"chi2\"]\n";
  const Findings findings =
      run("same_sequence = false\n" + models({"sharp", "blind"}) + svm_ + subsets + pair_);
  EXPECT_EQ(rows().size(), 1U + 2 * 2) << "not in the table of all cells";
  EXPECT_THAT(readFile(scratch_ / "out/study-subsets.csv"),
              testing::StartsWith("descriptor,classifier,train,test,by,labels,accuracy,balanced_accuracy,"));
  const auto found = rows("study-subsets.csv", 6);
  EXPECT_EQ(found.size(), 1U + 2 * 2 * 2);
  EXPECT_EQ(found.at({"sharp", "svm-linear", "one", "two", "chi2", "4"}),
            rows().at({"sharp", "svm-linear", "one", "two"}))
      << "all labels are all labels";
  EXPECT_EQ(test::notesNaming(findings, "100"), 1U) << "but not 4, which are all";
  const auto chart = std::find_if(findings.sections.begin(), findings.sections.end(),
                                  [](const auto& s) { return std::holds_alternative<LineChart>(s); });
  ASSERT_NE(chart, findings.sections.end());
  EXPECT_THAT(std::get<LineChart>(*chart).x, ElementsAre(2, 4));
  EXPECT_EQ(std::get<LineChart>(*chart).lines.size(), 2U);
}

TEST_F(Scenes, TellTheBestWithItsConfusions) {
  const Findings findings = run(models({"sharp", "blind", "phog", "blind+phog"}) + pair_);
  std::vector<std::string> titles;
  for (const auto& section : findings.sections)
    std::visit([&](const auto& part) { titles.push_back(part.title); }, section);
  const auto startWith = [&](const std::string& start) {
    return std::ranges::count_if(titles, [&](const auto& title) { return title.starts_with(start); });
  };
  for (const char* best : {"sharp/", "blind+phog/", " phog/"})
    EXPECT_NE(findings.summary.find(best), std::string::npos) << findings.summary;
  EXPECT_GE(startWith("study: accuracy, different sequences"), 1);
  EXPECT_GE(startWith("study: accuracy, the same sequence"), 1);
  EXPECT_EQ(startWith("study: balanced accuracy"), 1);
  EXPECT_EQ(startWith("study: rooms taken for others by sharp/"), 1);
  EXPECT_EQ(startWith("study: rooms taken for others by blind+phog/"), 1);
  EXPECT_EQ(startWith("study: all cells, mean ranks"), 1);
  EXPECT_EQ(startWith("Table 3.2 of the thesis"), 0) << "another data set's";
  EXPECT_EQ(rows("study-confusions.csv", 6).at({"sharp", "svm-linear", "one", "two", "room0", "room0"}),
            std::vector<std::string>{"10"});
  const auto images = io::readCsv(scratch_ / "out/study-images.csv");
  ASSERT_GT(images.size(), 1U);
  EXPECT_THAT(images[0].cells, ElementsAre("train", "test", "image", "room", "wrong", "cells", "taken_for"));
  for (std::size_t i = 2; i < images.size(); ++i)
    EXPECT_GE(std::stod(images[i - 1].cells[4]), std::stod(images[i].cells[4]));
  std::vector<std::string> files;
  for (const Findings& part : findings.apart) files.push_back(part.file);
  EXPECT_THAT(files, ElementsAre("study-statistics", "study-descriptors", "study-classifiers"));
}

TEST_F(Scenes, OptionalOnesAreLeftOutWithANote) {
  const Findings findings =
      run("optional_descriptors = [\"no-such-model\", \"phog+no-such-model\", \"phog\"]\n" +
          models({"sharp"}) + svm_ + pair_ + "[[data]]\nname = \"x\"\npath = \"nowhere\"\noptional = true\n");
  EXPECT_EQ(test::notesNaming(findings, "no-such-model"), 1U) << "one note for all";
  EXPECT_EQ(test::notesNaming(findings, "phog+no-such-model"), 1U);
  EXPECT_EQ(test::notesNaming(findings, "nowhere"), 1U);
  EXPECT_EQ(progress_.computed, 2U * 4);
}

TEST_F(Scenes, UnknownNamesAreRefusedBeforeAnythingIsDescribed) {
  EXPECT_THAT(problem(models({"sharp", "gits"}) + pair_),
              FailsWith(ErrorCode::unknownName, "gits", "phog", "gist", "esf"));
  EXPECT_THAT(problem(models({"sharp"}) + "classifiers = [\"svm\"]\n" + pair_),
              FailsWith(ErrorCode::malformedFile, "study.toml:3", "`classifiers`", "\"svm-rbf\""));
  EXPECT_THAT(problem("focus = \"three\"\n" + models({"sharp"}) + pair_),
              FailsWith(ErrorCode::malformedFile, "three"));
  EXPECT_THAT(problem(models({"sharp"}) + pair_ + "turns = 7\n"),
              FailsWith(ErrorCode::malformedFile, "`turns`"));
  EXPECT_THAT(problem(models({"sharp"}) + "classifier = []\n" + pair_),
              FailsWith(ErrorCode::malformedFile, "`classifier`"));
  EXPECT_THAT(problem(models({"sharp"}) + "[[data]]\nname = \"x\"\npath = \"nowhere\"\n"),
              FailsWith(ErrorCode::fileNotFound, "nowhere"));
  EXPECT_THAT(problem(models({"sharp"}) +
                      "[subsets]\ndescriptor = \"sharp\"\nclassifier = \"svm-rbf\"\ncounts = [5]\nby = "
                      "[\"variance\"]\n" +
                      pair_),
              FailsWith(ErrorCode::malformedFile, "study.toml:7", "`by`", "\"mutual-information\""));
  EXPECT_EQ(progress_.works, 0U);
  EXPECT_FALSE(fs::exists(scratch_ / "out/results.csv"));
}

TEST_F(Scenes, WrongKeysAreNamedWithFileAndLine) {
  const std::string sharp = models({"sharp"});
  EXPECT_THAT(problem(sharp), FailsWith(ErrorCode::malformedFile, "`data`"));
  EXPECT_THAT(problem(pair_), FailsWith(ErrorCode::malformedFile, "`descriptors`"));
  EXPECT_THAT(problem("descriptors = []\n" + pair_), FailsWith(ErrorCode::malformedFile, "`descriptors`"));
  EXPECT_THAT(problem(sharp + "folds = 1\n" + pair_),
              FailsWith(ErrorCode::malformedFile, "study.toml:3", "`folds`"));
  EXPECT_THAT(problem(sharp + "seeds = [1, 1]\n" + pair_), FailsWith(ErrorCode::malformedFile, "`seeds`"));
  EXPECT_THAT(problem(sharp + "[[data]]\nname = \"x\"\npath = \"one\"\nsplit_column = \"half\"\n"),
              FailsWith(ErrorCode::malformedFile, "study.toml", "`table`"));
  EXPECT_THAT(problem(sharp + halves_ + "[data.test]\npath = \"two\"\n"),
              FailsWith(ErrorCode::malformedFile, "`split_column`"));
  EXPECT_THAT(problem(sharp + "[[data]]\npath = \"one\"\n"), FailsWith(ErrorCode::malformedFile, "`name`"));
  EXPECT_THAT(problem(sharp +
                      "[subsets]\ndescriptor = \"sharp\"\nclassifier = \"knn\"\ncounts = [0]\nby = "
                      "[\"mean\"]\n" +
                      pair_),
              FailsWith(ErrorCode::malformedFile, "`counts`"));
}

TEST_F(Scenes, DataThatCannotBeLearnedFromIsRefused) {
  const std::string sharp = models({"sharp"}) + svm_;
  EXPECT_THAT(problem(sharp + "same_sequence = false\n[[data]]\nname = \"x\"\npath = \"one\"\n"),
              FailsWith(ErrorCode::insufficientData, "x: "));
  EXPECT_THAT(problem(sharp + halves_ + "only = [\"room1\"]\n"),
              FailsWith(ErrorCode::insufficientData, "room1"));
  EXPECT_THAT(problem(sharp + halves_ + "only = [\"attic\"]\n"),
              FailsWith(ErrorCode::insufficientData, "`only`"));
  EXPECT_THAT(problem(sharp + "[[data]]\nname = \"x\"\npath = \"one\"\nonly = [\"attic\"]\n"),
              FailsWith(ErrorCode::unknownName, "attic"));
  EXPECT_THAT(problem(sharp + halves_ + "test_value = \"exam\"\n"),
              FailsWith(ErrorCode::insufficientData, "\"exam\""));
  fs::create_directories(scratch_ / "empty");
  EXPECT_THAT(problem(sharp + "[[data]]\nname = \"x\"\npath = \"empty\"\n"),
              FailsWith(ErrorCode::unsupportedFile, "empty"));
  EXPECT_THAT(problem(sharp + pair_ + pair_), FailsWith(ErrorCode::invalidInput, "one, one", "study.toml"));
  EXPECT_THAT(problem(sharp + "[[data]]\nname = \"x\"\npath = \"nowhere\"\noptional = true\n"),
              FailsWith(ErrorCode::insufficientData, "[[data]]"));
  std::string rooms = "image,room\n0000.png,cellar\n";
  for (int i = 1; i < 40; ++i)
    rooms += std::string(i < 10 ? "000" : "00") + std::to_string(i) + ".png,room1\n";
  writeFile(scratch_ / "one/rooms.csv", rooms);
  EXPECT_THAT(problem(sharp + pair_), FailsWith(ErrorCode::insufficientData, "one: ", "cellar"));
  fs::remove(scratch_ / "one/rooms.csv");
  EXPECT_THAT(problem(sharp + pair_), FailsWith(ErrorCode::insufficientData, "`table`"));
  EXPECT_EQ(progress_.computed, 0U);
}

}  // namespace
}  // namespace estancia::experiments
