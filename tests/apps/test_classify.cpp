// `estancia classify`, and the commands that take its rooms, as a user runs them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/topology/store.hpp"
#include "estancia/zones/zone_file.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

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
    std::vector<std::string> arguments{"classify", "train", words_, "-o", model_, "--overwrite", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }

  static std::vector<json> lines(const CommandResult& result) {
    EXPECT_EQ(result.exitCode, 0) << result.err;
    std::vector<json> all;
    std::istringstream in(result.out);
    for (std::string line; std::getline(in, line);) all.push_back(json::parse(line, nullptr, false));
    return all;
  }

  static void expectError(const std::vector<std::string>& arguments, const std::string& text) {
    const auto result = run(arguments);
    EXPECT_EQ(result.exitCode, 2) << result.out;
    EXPECT_THAT(result.err, HasSubstr(text));
    EXPECT_EQ(result.out, "");
  }

  ScratchFolder scratch_;
  const std::string words_ = scratch_ / "home.labels", others_ = scratch_ / "other.labels",
                    unknown_ = scratch_ / "unknown.labels", model_ = scratch_ / "rooms.classifier",
                    map_ = scratch_ / "home.estancia", zones_ = scratch_ / "home.zones";
};

TEST_F(ClassifyCommand, HelpHasExamples) {
  for (const char* name : {"train", "test", "predict", "show", "name"}) {
    const auto result = run({"classify", name, "--help"});
    EXPECT_EQ(result.exitCode, 0) << name;
    EXPECT_THAT(result.out, HasSubstr(std::string("  estancia classify ") + name)) << name;
  }
  EXPECT_THAT(run({"classify", "train", "--help"}).out, AllOf(HasSubstr("svm-rbf"), HasSubstr("phog")));
}

TEST_F(ClassifyCommand, LearnsRoomsAndFindsThemAgain) {
  const json trained = train();
  EXPECT_EQ(trained["images"], 54);
  EXPECT_EQ(trained["rooms"], (json{{"kitchen", 18}, {"bath", 18}, {"bedroom", 18}}));
  EXPECT_EQ(trained["type"], "svm-rbf");
  EXPECT_EQ(trained["descriptor"], "test");
  EXPECT_THAT(trained["choice"].get<std::string>(), HasSubstr("%"));

  const auto said = lines(run({"classify", "predict", model_, unknown_, "--json"}));
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

  const auto shown = run({"classify", "predict", model_, unknown_});
  EXPECT_THAT(shown.out, AllOf(HasSubstr("frame 0 "), HasSubstr(" kitchen "), HasSubstr(" %")));
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
  EXPECT_THAT(run({"classify", "test", model_, others_}).out,
              AllOf(HasSubstr("54 images right by svm-rbf on test"), HasSubstr("balanced accuracy"),
                    HasSubstr("1 bath")));
  const json part = json::parse(run({"classify", "test", model_, others_, "--only", "bath", "--json"}).out);
  EXPECT_EQ(part["images"], 18);
  expectError({"classify", "test", model_, unknown_}, "room");
  ASSERT_EQ(run({"classify", "test", model_, others_, "-o", scratch_ / "test.html"}).exitCode, 0);
  EXPECT_THAT(readFile(scratch_ / "test.html"),
              AllOf(HasSubstr("What is taken for what"), HasSubstr("svm-rbf on test")));
}

TEST_F(ClassifyCommand, LearnsFromTheBestLabelsOnly) {
  EXPECT_EQ(train({"--labels", "4", "--by", "chi2"})["columns"], 4);
  EXPECT_GE(json::parse(run({"classify", "test", model_, others_, "--json"}).out)["accuracy"], 0.8)
      << "they are found again among all";
  expectError({"classify", "train", words_, "-o", model_, "--overwrite", "--labels", "13"}, "12");
  expectError({"classify", "train", words_, "-o", model_, "--overwrite", "--labels", "4", "--by", "luck"},
              "mean");
}

TEST_F(ClassifyCommand, LearnsFromTheNumbersOfOthers) {
  std::string table = "image,room,g0,g1\n";
  for (int i = 0; i < 24; ++i) {
    const bool hall = i / 4 % 2 == 0;
    table += "f" + std::to_string(i) + (hall ? ",hall," : ",lab,") +
             std::to_string((hall ? 1 : 5) + i % 3 * 0.1) + ",-" + std::to_string(i % 4) + "\n";
  }
  writeFile(scratch_ / "table.csv", table);
  const auto trained =
      run({"classify", "train", scratch_ / "table.csv", "-o", model_, "--classifier", "knn"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  EXPECT_THAT(trained.out, HasSubstr("2 rooms of 24 images by knn on g"));
  EXPECT_EQ(json::parse(run({"classify", "test", model_, scratch_ / "table.csv", "--json"}).out)["accuracy"],
            1);
  expectError({"classify", "test", model_, scratch_ / "table.csv", "--split", "test"}, "no splits");
}

TEST_F(ClassifyCommand, SaysWhichNumbersOfOthersItNeeds) {
  const auto table = [&](const char* name, const char* head, const char* more) {
    std::string text = head;
    for (int i = 0; i < 24; ++i)
      text += (i / 4 % 2 == 0 ? "hall,1," : "lab,5,") + std::to_string(i % 3) + more + "\n";
    writeFile(scratch_ / name, text);
    return std::string(scratch_ / name);
  };
  const std::string three = table("three.csv", "room,g0,g1,g2\n", ",1"),
                    two = table("two.csv", "room,g0,g1\n", "");
  ASSERT_EQ(run({"classify", "train", three, "-o", model_, "--classifier", "knn"}).exitCode, 0);
  expectError({"classify", "test", model_, two}, "[mismatch]");
  writeLines(scratch_ / "lines", 8);
  expectError({"classify", "predict", model_, scratch_ / "lines"}, "of a table");
  expectError({"map", unknown_, "-o", map_, "--room-classifier", model_}, "needs g ");
  EXPECT_FALSE(fs::exists(map_)) << "known before the mapping begins";
}

TEST_F(ClassifyCommand, LearnsTheSameFromTheSame) {
  train();
  const std::string first = readFile(model_);
  train({"--threads", "1"});
  EXPECT_EQ(readFile(model_), first);
}

TEST_F(ClassifyCommand, SaysNothingWhereItIsNotSure) {
  train();
  for (const json& line : lines(run({"classify", "predict", model_, unknown_, "--least", "1", "--json"})))
    EXPECT_EQ(line["room"].is_null(), line["probability"] < 1);
  ASSERT_EQ(
      run({"classify", "predict", model_, unknown_, "--least", "1", "-o", scratch_ / "said.csv"}).exitCode,
      0);
  EXPECT_THAT(readFile(scratch_ / "said.csv"),
              HasSubstr("image,predicted_room,probability,second,second_probability\nframe 0,,0."));
}

TEST_F(ClassifyCommand, LearnsFromImages) {
  writeLines(scratch_ / "lines", 40);
  const std::string image = scratch_ / "lines/line0.png", model = scratch_ / "lines.classifier";
  const auto trained = run({"classify", "train", scratch_ / "lines", "-o", model, "--descriptor", "phog"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  EXPECT_THAT(trained.out, AllOf(HasSubstr("2 rooms of 40 images by svm-rbf on phog"), HasSubstr("lying")));
  const auto said = lines(run({"classify", "predict", model, image, scratch_ / "lines/line4.png", "--json"}));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[0]["image"], image);
  EXPECT_EQ(said[0]["room"], "lying");
  EXPECT_EQ(said[1]["room"], "standing");
  expectError({"classify", "predict", model, words_}, "phog");
  expectError({"classify", "predict", model, image, scratch_ / "missing.png"}, "no such file");
  expectError({"classify", "predict", model, image, words_}, "[unsupported-file]");
}

TEST_F(ClassifyCommand, NamesThePlacesOfAMap) {
  train();
  const auto mapped = run({"map", unknown_, "-o", map_, "--room-classifier", model_, "--json"});
  ASSERT_EQ(mapped.exitCode, 0) << mapped.err;
  EXPECT_EQ(json::parse(mapped.out)["predicted_rooms"].size(), 3U);

  const auto asked = run({"ask", map_, "bath", "--json"});
  ASSERT_EQ(asked.exitCode, 0) << asked.err << "no word of the map is a bath";
  const json answer = json::parse(asked.out);
  EXPECT_EQ(answer["rooms"], json{"bath"});
  EXPECT_EQ(answer["places"][0]["predicted_room"], "bath");
  EXPECT_EQ(answer["places"][0]["room"], "") << "the truth is not known";
  EXPECT_EQ(answer["places"][0]["label"], nullptr);
  EXPECT_THAT(run({"ask", map_, "bath"}).out, AllOf(HasSubstr("bath → room bath"), HasSubstr("(bath ")));
  const auto way = run({"route", map_, "--from", "0", "--to", "bath"});
  ASSERT_EQ(way.exitCode, 0) << way.err;
  EXPECT_THAT(way.out, HasSubstr("\"bath\" is at place"));
  EXPECT_THAT(run({"export", map_, "--format", "graphml"}).out,
              HasSubstr("<data key=\"predicted_room\">bath<"));
  EXPECT_THAT(run({"explain", map_, "0"}).out, HasSubstr("predicts kitchen"));
  ASSERT_EQ(run({"report", map_, "-o", scratch_ / "home.html"}).exitCode, 0);
  EXPECT_THAT(readFile(scratch_ / "home.html"), HasSubstr("Taken for kitchen"));
}

TEST_F(ClassifyCommand, NamesAnExistingMapAndIsJudgedByTheTruth) {
  train();
  ASSERT_EQ(run({"map", others_, "-o", map_}).exitCode, 0);
  EXPECT_EQ(run({"ask", map_, "bath"}).exitCode, 1);
  const auto named = lines(run({"classify", "name", model_, map_, "--json"}));
  ASSERT_FALSE(named.empty());
  EXPECT_EQ(named[0]["predicted_rooms"][0]["room"], "kitchen");
  EXPECT_EQ(run({"ask", map_, "bath"}).exitCode, 0);
  const json measures = json::parse(run({"evaluate", map_, "--json"}).out);
  EXPECT_GE(measures["predicted_room"], 0.9);
  EXPECT_GE(measures["predicted_node_room"], 0.8) << "the map mixes a few images";
  EXPECT_THAT(run({"evaluate", map_}).out, HasSubstr("Predicted room, place"));

  const auto said = lines(run({"classify", "predict", model_, map_, "--json"}));
  EXPECT_EQ(said.size(), 54U);
  const auto goesOn = run({"map", others_, "-o", map_, "--continue", "--room-classifier", model_});
  EXPECT_EQ(goesOn.exitCode, 0) << goesOn.err;
}

TEST_F(ClassifyCommand, NamesZones) {
  train();
  const auto found =
      run({"zones", "find", unknown_, "-o", zones_, "--count", "3", "--room-classifier", model_, "--json"});
  ASSERT_EQ(found.exitCode, 0) << found.err;
  const json zone = json::parse(found.out)["zones"][0];
  EXPECT_EQ(zone["room"], nullptr);
  EXPECT_GT(zone["predicted_rooms"][0]["p"], 0.5);
  EXPECT_EQ(readZones(zones_).zones[0].predicted[0].room, zone["predicted_rooms"][0]["room"]);
  const json exported = json::parse(run({"export", zones_, "--format", "rooms"}).out);
  EXPECT_EQ(exported.size(), 3U);
  EXPECT_TRUE(exported["bath"].contains("predicted"));
  ASSERT_EQ(run({"report", zones_, "-o", scratch_ / "zones.html"}).exitCode, 0);
  EXPECT_THAT(readFile(scratch_ / "zones.html"), HasSubstr("Taken for "));
  EXPECT_THAT(run({"zones", "find", unknown_, "-o", zones_, "--overwrite", "--room-classifier", model_}).out,
              HasSubstr("taken for "));
}

TEST_F(ClassifyCommand, ZonesAreJudgedByTheTruthToo) {
  train();
  ASSERT_EQ(
      run({"zones", "find", others_, "-o", zones_, "--count", "3", "--room-classifier", model_}).exitCode, 0);
  EXPECT_GE(json::parse(run({"evaluate", zones_, "--json"}).out)["predicted_zone_room"], 0.8);
  EXPECT_THAT(run({"evaluate", zones_}).out, HasSubstr("Predicted room, zone"));
}

TEST_F(ClassifyCommand, WarnsOfAnswersInATable) {
  std::string table = "room,Chair,g0,g1\n";
  for (int i = 0; i < 24; ++i)
    table += (i / 4 % 2 == 0 ? "hall,1,1," : "lab,0,5,") + std::to_string(i % 3) + "\n";
  writeFile(scratch_ / "table.csv", table);
  const auto all = run({"classify", "train", scratch_ / "table.csv", "-o", model_, "--classifier", "knn"});
  EXPECT_EQ(all.exitCode, 0) << all.err;
  EXPECT_THAT(all.err, AllOf(HasSubstr("from Chair, too"), HasSubstr("--descriptor g")));
  EXPECT_THAT(all.out, HasSubstr("knn on Chair+g"));
  const auto some = run({"classify", "train", scratch_ / "table.csv", "-o", model_, "--classifier", "knn",
                         "--overwrite", "--descriptor", "g"});
  EXPECT_THAT(some.out, HasSubstr("knn on g\n"));
  EXPECT_THAT(some.err, Not(HasSubstr("Chair")));
}

TEST_F(ClassifyCommand, SaysWhatItNeverLearned) {
  const std::string two = scratch_ / "two.classifier";
  ASSERT_EQ(run({"classify", "train", words_, "-o", two, "--only", "kitchen,bath"}).exitCode, 0);
  EXPECT_THAT(run({"classify", "test", two, others_}).out,
              HasSubstr("18 images of room \"bedroom\", which it has never learned"));
  EXPECT_EQ(json::parse(run({"classify", "test", two, others_, "--json"}).out)["never_learned"],
            (json{{"bedroom", 18}}));
}

TEST_F(ClassifyCommand, ShowsWhatAModelKnows) {
  train();
  const json known = json::parse(run({"classify", "show", model_, "--json"}).out);
  EXPECT_EQ(known["rooms"], (json{"bath", "bedroom", "kitchen"}));
  EXPECT_EQ(known["parts"][0]["name"], "test");
  EXPECT_EQ(known["parts"][0]["columns"], 12);
  EXPECT_THAT(run({"classify", "show", model_}).out, HasSubstr("rooms: bath, bedroom, kitchen"));
}

TEST_F(ClassifyCommand, ReplacesRoomClassifiersOnlyAndOnlyWhenTold) {
  train();
  expectError({"classify", "train", words_, "-o", model_}, "--overwrite");
  const std::string words = readFile(words_);
  expectError({"classify", "train", words_, "-o", words_, "--overwrite"}, "[file-exists]");
  EXPECT_EQ(readFile(words_), words);
  expectError({"classify", "train", words_, "-o", scratch_ / "none/rooms.classifier"}, "no such folder");
}

TEST_F(ClassifyCommand, NeverReplacesWhatItReads) {
  writeLines(scratch_ / "lines", 16);
  const std::string image = scratch_ / "lines/line0.png", classifier = scratch_ / "lines.classifier";
  ASSERT_EQ(run({"classify", "train", scratch_ / "lines", "-o", classifier, "--descriptor", "phog"}).exitCode,
            0);
  train();
  const std::string pixels = readFile(image), words = readFile(others_);
  expectError({"classify", "predict", classifier, image, "-o", image}, "[file-exists]");
  expectError({"classify", "predict", classifier, scratch_ / "lines", "-o", image}, "exists");
  writeFile(scratch_ / "broken.png", "no image");
  expectError({"classify", "predict", classifier, scratch_ / "broken.png"}, "not an image");
  EXPECT_EQ(readFile(image), pixels);
  expectError({"classify", "test", model_, others_, "-o", others_}, "[file-exists]");
  expectError({"classify", "test", model_, words_, "-o", others_}, "exists");
  EXPECT_EQ(readFile(others_), words);

  const std::string csv = scratch_ / "said.csv", page = scratch_ / "test.html";
  for (int twice = 0; twice < 2; ++twice) {
    EXPECT_EQ(run({"classify", "predict", model_, others_, "-o", csv}).exitCode, 0);
    EXPECT_EQ(run({"classify", "test", model_, others_, "-o", page}).exitCode, 0);
  }
  expectError({"classify", "test", model_, others_, "-o", csv}, "exists");
}

TEST_F(ClassifyCommand, WrongInputIsOneLine) {
  train();
  const std::string other = scratch_ / "other.classifier";
  expectError({"classify", "train", unknown_, "-o", other}, "[insufficient-data]");
  expectError({"classify", "train", words_, "-o", other, "--only", "bath"}, "one room");
  expectError({"classify", "train", words_, "-o", other, "--only", "garage"}, "kitchen");
  expectError({"classify", "train", words_, "-o", other, "--classifier", "bogus"}, "knn");
  expectError({"classify", "train", words_, "-o", other, "--descriptor", "bogus"}, "[unknown-name]");
  writeLines(scratch_ / "lines", 8);
  expectError({"classify", "train", scratch_ / "lines", "-o", other, "--descriptor", "bogus"}, "phog");
  expectError({"classify", "train", scratch_ / "missing", "-o", other}, "missing");
  EXPECT_FALSE(fs::exists(other));

  writeFile(scratch_ / "words.csv", "image,stove,tub\none,0.1,0.9\n");
  expectError({"classify", "predict", model_, scratch_ / "words.csv"}, "[mismatch]");
  expectError({"classify", "predict", model_, scratch_ / "lines"}, "[unknown-name]");
  expectError({"classify", "predict", words_, words_}, "[unsupported-file]");
  writeFile(scratch_ / "cut.classifier", readFile(model_).substr(0, 400));
  expectError({"classify", "show", scratch_ / "cut.classifier"}, "[corrupt-file]");
  expectError({"map", unknown_, "-o", map_, "--room-classifier", scratch_ / "cut.classifier"},
              "[corrupt-file]");
  EXPECT_FALSE(fs::exists(map_)) << "known before the mapping begins";
  expectError({"zones", "find", unknown_, "-o", zones_, "--room-classifier", words_}, "[unsupported-file]");
  expectError({"classify", "name", model_, scratch_ / "missing.estancia"}, "no such map");
  writeFile(scratch_ / "none.csv", "image,room\n");
  expectError({"classify", "train", unknown_, "-o", other, "--rooms", scratch_ / "none.csv"},
              "[insufficient-data]");
  expectError({"classify", "learn"}, "see estancia classify --help");
}

}  // namespace
}  // namespace estancia::test
