// Rooms of maps: by `estancia classify`, and by their names alone.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/json_of.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/session/session.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;

const std::vector<std::string> rooms{"kitchen", "bath", "bedroom"};

class ClassifyCommand : public testing::Test {
 protected:
  void SetUp() override {
    writeWords(words_, 5, true);
    writeWords(others_, 6, true);
    writeWords(unknown_, 7, false);
  }

  /// Three rooms, thrice visited: words that no room is called by.
  static void writeWords(const fs::path& file, unsigned seed, bool withRooms) {
    SyntheticPlaces places(3, 12, 0.4);
    DescriptorSequence recording{Vocabulary({"stove", "fridge", "tub", "sink", "bed", "sofa", "desk", "lamp",
                                             "plant", "door", "window", "chair"}),
                                 "test 1",
                                 {},
                                 DescriptorMatrix(12)};
    for (unsigned skip = 0; skip < 100 * seed; ++skip) places.image(0);
    for (const std::size_t place : {0U, 1U, 2U, 0U, 1U, 2U, 2U, 1U, 0U})
      for (int i = 0; i < 6; ++i) {
        Frame frame;
        frame.name = "frame " + std::to_string(recording.frames.size());
        if (withRooms) frame.room = rooms[place];
        recording.frames.push_back(frame);
        recording.descriptors.append(places.image(place));
      }
    writeDescriptors(recording, file);
  }

  /// `count` images of lines that lie or stand, and what they are.
  void writeLines(const fs::path& folder, int count) {
    std::string table = "image,room\n";
    fs::create_directories(folder);
    cv::RNG random(5);
    for (int i = 0; i < count; ++i) {
      const bool lying = i / 4 % 2 == 0;
      cv::Mat image(48, 64, CV_8UC3, cv::Scalar(30, 30, 30));
      for (int line = 0; line < 4; ++line) {
        const int at = random.uniform(4, 44);
        cv::line(image, lying ? cv::Point(0, at) : cv::Point(at, 0),
                 lying ? cv::Point(63, at) : cv::Point(at, 47), cv::Scalar(220, 220, 220), 2);
      }
      const std::string name = "line" + std::to_string(i) + ".png";
      cv::imwrite((folder / name).string(), image);
      table += name + (lying ? ",lying\n" : ",standing\n");
    }
    writeFile(folder / "rooms.csv", table);
  }

  json train(const std::vector<std::string>& more = {}) {
    return jsonOf(run({"classify", "train", words_, "-o", model_, "--overwrite", "--json"}, more));
  }

  static void refuses(const std::vector<std::string>& arguments, ErrorCode code) {
    const auto result = run(arguments);
    EXPECT_THAT(result, FailsWith(code));
    EXPECT_EQ(result.out, "");
  }

  ScratchFolder scratch_;
  const std::string words_ = scratch_ / "home.labels", others_ = scratch_ / "other.labels",
                    unknown_ = scratch_ / "unknown.labels", model_ = scratch_ / "rooms.classifier",
                    map_ = scratch_ / "home.estancia", zones_ = scratch_ / "home.zones";
};

TEST_F(ClassifyCommand, LearnsRoomsAndFindsThemAgain) {
  const json trained = train();
  EXPECT_EQ(trained["images"], 54);
  EXPECT_EQ(trained["rooms"], (json{{"kitchen", 18}, {"bath", 18}, {"bedroom", 18}}));
  EXPECT_EQ(trained["type"], "svm-rbf");
  EXPECT_EQ(trained["descriptor"], "test");
  const json known = json::parse(run({"classify", "show", model_, "--json"}).out);
  EXPECT_EQ(known["rooms"], (json{"bath", "bedroom", "kitchen"}));
  EXPECT_EQ(known["parts"][0]["name"], "test");
  EXPECT_EQ(known["parts"][0]["columns"], 12);

  const auto said = jsonLinesOf(run({"classify", "predict", model_, unknown_, "--json"}));
  ASSERT_EQ(said.size(), 54U);
  std::size_t right = 0;
  for (std::size_t i = 0; i < said.size(); ++i) {
    const std::size_t place = std::vector<std::size_t>{0, 1, 2, 0, 1, 2, 2, 1, 0}[i / 6];
    if (said[i]["room"] == rooms[place]) ++right;
    double sum = 0;
    for (const auto& [room, probability] : said[i]["rooms"].items()) sum += probability.get<double>();
    EXPECT_NEAR(sum, 1, 1e-3);
  }
  EXPECT_GE(right, 50U);
  for (const json& line :
       jsonLinesOf(run({"classify", "predict", model_, unknown_, "--min-probability", "1", "--json"})))
    EXPECT_EQ(line["room"].is_null(), line["probability"] < 1);
  EXPECT_EQ(train({"--max-labels", "4", "--by", "chi2"})["columns"], 4);
  EXPECT_GE(json::parse(run({"classify", "test", model_, others_, "--json"}).out)["accuracy"], 0.8)
      << "they are found again among all";
}

TEST_F(ClassifyCommand, LeavesOutImagesWithoutLabels) {
  train();
  DescriptorSequence recording = readDescriptors(unknown_);
  const DescriptorMatrix known = recording.descriptors;
  const std::vector<float> none(12);
  const auto predict = [&](std::size_t labeled, const std::vector<std::string>& options) {
    recording.descriptors = DescriptorMatrix(12);
    for (std::size_t i = 0; i < recording.frames.size(); ++i)
      recording.descriptors.append(i < labeled ? known.row(i) : DescriptorView(none));
    writeDescriptors(recording, scratch_ / "few.labels");
    std::vector<std::string> command{"classify", "predict", model_, scratch_ / "few.labels", "--json"};
    command.insert(command.end(), options.begin(), options.end());
    return run(command);
  };
  const auto said = jsonLinesOf(predict(7, {}));
  ASSERT_EQ(said.size(), 7U);
  EXPECT_EQ(said[6]["image"], "frame 6");
  EXPECT_NE(predict(7, {"--strict"}).exitCode, 0);
  EXPECT_NE(predict(0, {}).exitCode, 0);
}

TEST_F(ClassifyCommand, IsTestedOnOtherImages) {
  train();
  const json scores = json::parse(run({"classify", "test", model_, others_, "--json"}).out);
  EXPECT_EQ(scores["images"], 54);
  EXPECT_GE(scores["accuracy"], 0.9);
  EXPECT_EQ(scores["balanced_accuracy"], scores["accuracy"]) << "as many images of each room";
  EXPECT_LT(scores["interval"][0], scores["accuracy"]);
  EXPECT_EQ(scores["rooms"], (json{"bath", "bedroom", "kitchen"}));
  std::size_t right = 0;
  for (std::size_t r = 0; r < 3; ++r) right += scores["confusion"][r][r].get<std::size_t>();
  EXPECT_EQ(scores["right"], right);
  refuses({"classify", "test", model_, unknown_}, ErrorCode::insufficientData);
}

TEST_F(ClassifyCommand, LearnsFromTheNumbersOfOthers) {
  std::string table = "image,room,g0,g1\n";
  for (int i = 0; i < 24; ++i) {
    const bool hall = i / 4 % 2 == 0;
    table += "f" + std::to_string(i) + (hall ? ",hall," : ",lab,") +
             std::to_string((hall ? 1 : 5) + i % 3 * 0.1) + ",-" + std::to_string(i % 4) + "\n";
  }
  const std::string file = scratch_ / "table.csv";
  writeFile(file, table);
  std::vector<std::string> training{"classify", "train", file, "-o", model_, "--classifier", "knn"};
  ASSERT_EQ(run(training).exitCode, 0);
  EXPECT_EQ(json::parse(run({"classify", "test", model_, file, "--json"}).out)["accuracy"], 1);
  training.insert(training.end(), {"--overwrite", "--set", "feature-table.ignored=g1"});
  ASSERT_EQ(run(training).exitCode, 0);
  EXPECT_EQ(json::parse(run({"classify", "show", model_, "--json"}).out)["parts"][0]["name"], "g0");
  refuses({"map", unknown_, "-o", map_, "--room-classifier", model_}, ErrorCode::mismatch);
  EXPECT_FALSE(fs::exists(map_)) << "known before the mapping begins";
}

TEST_F(ClassifyCommand, LearnsFromImages) {
  writeLines(scratch_ / "lines", 40);
  const std::string image = scratch_ / "lines/line0.png", model = scratch_ / "lines.classifier";
  const auto trained = run({"classify", "train", scratch_ / "lines", "-o", model, "--descriptor", "phog"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  const auto said =
      jsonLinesOf(run({"classify", "predict", model, image, scratch_ / "lines/line4.png", "--json"}));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[0]["image"], image);
  EXPECT_EQ(said[0]["room"], "lying");
  EXPECT_EQ(said[1]["room"], "standing");
  refuses({"classify", "predict", model, words_}, ErrorCode::mismatch);
  refuses({"classify", "predict", model, image, scratch_ / "missing.png"}, ErrorCode::fileNotFound);
  refuses({"classify", "predict", model, image, words_}, ErrorCode::unsupportedFile);
}

TEST_F(ClassifyCommand, NamesAnExistingMapAndIsJudgedByTheTruth) {
  train();
  ASSERT_EQ(run({"map", others_, "-o", map_}).exitCode, 0);
  {
    const WithoutWordNet plain;
    EXPECT_EQ(run({"ask", map_, "bath"}).exitCode, 1);
  }
  const auto named = jsonLinesOf(run({"classify", "name", model_, map_, "--json"}));
  ASSERT_FALSE(named.empty());
  EXPECT_EQ(named[0]["predicted_rooms"][0]["room"], "kitchen");
  EXPECT_EQ(run({"ask", map_, "bath"}).exitCode, 0);
  const json measures = json::parse(run({"evaluate", map_, "--json"}).out);
  EXPECT_GE(measures["predicted_room"], 0.9);
  EXPECT_GE(measures["predicted_node_room"], 0.8) << "the map mixes a few images";

  const auto goesOn = run({"map", others_, "-o", map_, "--continue", "--room-classifier", model_});
  EXPECT_EQ(goesOn.exitCode, 0) << goesOn.err;
}

TEST_F(ClassifyCommand, ReplacesOnlyWithOverwriteAndNeverItsInputs) {
  train();
  refuses({"classify", "train", words_, "-o", model_}, ErrorCode::fileExists);
  const std::string words = readFile(words_), others = readFile(others_);
  refuses({"classify", "train", words_, "-o", words_, "--overwrite"}, ErrorCode::fileExists);
  refuses({"classify", "train", words_, "-o", scratch_ / "none/rooms.classifier"}, ErrorCode::fileNotFound);

  const std::string csv = scratch_ / "predicted.csv", page = scratch_ / "test.html";
  const std::vector<std::string> predict{"classify", "predict", model_, others_, "-o", csv},
      test{"classify", "test", model_, others_, "-o", page};
  for (auto arguments : {predict, test}) {
    EXPECT_EQ(run(arguments).exitCode, 0);
    refuses(arguments, ErrorCode::fileExists);
    arguments.emplace_back("--overwrite");
    EXPECT_EQ(run(arguments).exitCode, 0);
  }
  EXPECT_EQ(readFile(csv).find("image,predicted_room,probability,second,second_probability\nframe 0,"), 0U);
  refuses({"classify", "test", model_, others_, "-o", csv, "--overwrite"}, ErrorCode::fileExists);
  refuses({"classify", "test", model_, words_, "-o", others_, "--overwrite"}, ErrorCode::fileExists);
  EXPECT_EQ(readFile(words_), words);
  EXPECT_EQ(readFile(others_), others);

  writeLines(scratch_ / "lines", 16);
  const std::string image = scratch_ / "lines/line0.png", lines = scratch_ / "lines.classifier";
  ASSERT_EQ(run({"classify", "train", scratch_ / "lines", "-o", lines, "--descriptor", "phog"}).exitCode, 0);
  const std::string pixels = readFile(image);
  refuses({"classify", "predict", lines, scratch_ / "lines", "-o", image, "--overwrite"},
          ErrorCode::fileExists);
  EXPECT_EQ(readFile(image), pixels);
}

TEST_F(ClassifyCommand, RefusesWhatItCannotUse) {
  train();
  writeLines(scratch_ / "lines", 8);
  writeFile(scratch_ / "words.csv", "image,stove,tub\none,0.1,0.9\n");
  const std::string cut = scratch_ / "cut.classifier", other = scratch_ / "other.classifier",
                    images = scratch_ / "lines";
  writeFile(cut, readFile(model_).substr(0, 400));
  const std::vector<std::pair<std::vector<std::string>, ErrorCode>> refused{
      {{"predict", model_, scratch_ / "words.csv"}, ErrorCode::mismatch},
      {{"predict", model_, images}, ErrorCode::unknownName},
      {{"predict", words_, words_}, ErrorCode::unsupportedFile},
      {{"show", cut}, ErrorCode::corruptFile},
      {{"name", model_, scratch_ / "missing.estancia"}, ErrorCode::fileNotFound},
      {{"train", unknown_, "-o", other}, ErrorCode::insufficientData},
      {{"train", words_, "-o", other, "--only", "bath"}, ErrorCode::insufficientData},
      {{"train", words_, "-o", other, "--classifier", "bogus"}, ErrorCode::unknownName},
      {{"train", images, "-o", other, "--descriptor", "bogus"}, ErrorCode::unknownName},
      {{"train", words_, "-o", other, "--max-labels", "13"}, ErrorCode::invalidInput},
      {{"train", words_, "-o", other, "--by", "chi2"}, ErrorCode::invalidOption},
      {{"train", scratch_ / "missing", "-o", other}, ErrorCode::fileNotFound}};
  for (const auto& [arguments, code] : refused)
    EXPECT_THAT(run({"classify"}, arguments), FailsWith(code)) << testing::PrintToString(arguments);
  EXPECT_FALSE(fs::exists(other));
  refuses({"map", unknown_, "-o", map_, "--room-classifier", cut}, ErrorCode::corruptFile);
  EXPECT_FALSE(fs::exists(map_)) << "known before the mapping begins";
  refuses({"zones", "find", unknown_, "-o", zones_, "--room-classifier", words_}, ErrorCode::unsupportedFile);
}

const std::vector<std::string> kitchen{"stove", "microwave", "refrigerator", "toaster"},
    bathroom{"toilet seat", "bathtub", "washbasin", "shower curtain"},
    desert{"zebra", "dune", "camel", "sky"};

class RoomsByName : public testing::Test {
 protected:
  /// A recording of twenty images of each, in which the things of a room turn up one after the other.
  std::string drive(const std::string& name, const std::vector<std::vector<std::string>>& rooms) const {
    std::vector<std::string> labels;
    for (const auto* room : {&kitchen, &bathroom, &desert})
      labels.insert(labels.end(), room->begin(), room->end());
    DescriptorSequence recording{Vocabulary(labels), "test 1", {}, DescriptorMatrix(labels.size())};
    for (const std::vector<std::string>& things : rooms)
      for (std::size_t i = 0; i < 20; ++i) {
        recording.frames.emplace_back().name = "frame " + std::to_string(recording.frames.size());
        std::vector<float> image(labels.size(), 0.005F);
        for (const auto& [step, p] : {std::pair{0, 0.5F}, {1, 0.3F}, {2, 0.1F}}) {
          const std::string& thing = things[(i / 2 + static_cast<std::size_t>(step)) % things.size()];
          image[static_cast<std::size_t>(std::ranges::find(labels, thing) - labels.begin())] = p;
        }
        recording.descriptors.append(image);
      }
    const std::string file = scratch_ / name;
    writeDescriptors(recording, file);
    return file;
  }

  CommandResult map(const std::string& drive, const std::vector<std::string>& more = {"--overwrite"}) const {
    CommandResult result = run({"map", drive, "-o", map_}, more);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return result;
  }

  ScratchFolder scratch_;
  const std::string map_ = scratch_ / "home.estancia";
};

TEST_F(RoomsByName, AreInEveryNewMap) {
  const std::string home = drive("home.labels", {kitchen, bathroom});
  const auto said = map(home);
  EXPECT_NE(said.out.find("bathroom"), std::string::npos);
  const RoomPredictions made = *readMap(map_).predictions;
  EXPECT_TRUE(made.areByName);
  EXPECT_FALSE(made.areListed);
  EXPECT_EQ(json::parse(run({"ask", map_, "kitchen", "--json"}).out)["places"][0]["predicted_room"],
            "kitchen");

  ASSERT_EQ(run({"classify", "name", map_}).exitCode, 0);
  const RoomPredictions named = *readMap(map_).predictions;
  EXPECT_EQ(made.probabilities.values(), named.probabilities.values());
  EXPECT_EQ(made.evidence.size(), named.evidence.size());

  const json summary = json::parse(map(home, {"--overwrite", "--json"}).out);
  EXPECT_GE(summary["predicted_rooms"]["kitchen"], 1);
}

TEST_F(RoomsByName, AreLeftOutForRawWordsAndWithoutWordNet) {
  const std::string home = drive("home.labels", {kitchen, bathroom});
  map(home, {"--words", "raw"});
  EXPECT_FALSE(readMap(map_).predictions);
  const WithoutWordNet none;
  map(home);
  EXPECT_FALSE(readMap(map_).predictions);
  EXPECT_THAT(run({"map", home, "-o", map_, "--overwrite", "--rooms-by-name", "kitchen,bathroom"}),
              FailsWith(ErrorCode::missingDependency));
}

TEST_F(RoomsByName, MayBeListedAndStaySo) {
  const std::string home = drive("home.labels", {kitchen, bathroom});
  map(drive("begun.labels", {kitchen}), {"--rooms-by-name", "kitchen, bathroom,Kitchens"});
  map(home, {"--continue"});
  const RoomPredictions listed = *readMap(map_).predictions;
  EXPECT_TRUE(listed.areListed);
  EXPECT_THAT(listed.rooms, ElementsAre("kitchen", "bathroom"));
  EXPECT_EQ(listed.probabilities.size(), 40U);
  ASSERT_EQ(run({"classify", "name", map_, "--rooms", "kitchen,bathroom"}).exitCode, 0);
  EXPECT_EQ(readMap(map_).predictions->probabilities.values(), listed.probabilities.values());

  const std::string other = scratch_ / "other.estancia";
  EXPECT_THAT(run({"map", home, "-o", other, "--rooms-by-name", "kitchen,xyzzy"}),
              FailsWith(ErrorCode::unknownName));
  EXPECT_FALSE(std::filesystem::exists(other)) << "before the long work begins";
}

TEST_F(RoomsByName, NeverReplaceThoseOfAClassifier) {
  const std::string home = drive("home.labels", {kitchen, bathroom});
  map(drive("begun.labels", {kitchen}));
  RoomPredictions trained{"knn on test", {"galley", "bath"}, DescriptorMatrix(2)};
  for (int i = 0; i < 20; ++i) trained.probabilities.append(std::vector<float>{0.9F, 0.1F});
  writeRoomPredictions(trained, map_);
  map(home, {"--continue"});
  EXPECT_EQ(readMap(map_).predictions->classifier, "knn on test");
}

}  // namespace
}  // namespace estancia::test
