// The command among programs: readme, examples, its own modules, mpirun, the laboratory.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "apps/json_of.hpp"
#include "estancia/session/session.hpp"
#include "support/color_model.hpp"
#include "support/errors.hpp"
#include "support/mpirun.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"
#include "support/table_scene.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::StartsWith;

TEST(Readme, ShowsAnExampleThatCompiles) {
  const std::filesystem::path root = ESTANCIA_SOURCE_DIR;
  const std::string readme = readFile(root / "README.md");
  const std::string open = "```cpp\n";
  const auto begin = readme.find(open);
  ASSERT_NE(begin, std::string::npos);
  const std::string shown =
      readme.substr(begin + open.size(), readme.find("```", begin + open.size()) - begin - open.size());
  EXPECT_GT(shown.size(), 200U);
  EXPECT_NE(readFile(root / "examples/12_ask_for_a_mug.cpp").find(shown), std::string::npos) << shown;
}

std::string example(const std::string& name) {
  return fs::path(ESTANCIA_EXAMPLES) / name;
}

/// The first word of each line, with how many lines begin with it.
std::map<std::string, int> linesBy(const std::string& text) {
  std::map<std::string, int> counts;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) ++counts[line.substr(0, line.find(' '))];
  return counts;
}

class Examples : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(scratch_ / "home/models");
    writeColorModel(scratch_ / "home/models/inception-v3");  // stands for the default network
    writeColorModel(scratch_ / "home/models/small");         // equals the first by its own name
    setenv("ESTANCIA_HOME", (scratch_ / "home").c_str(), 1);
    for (int i = 0; i < 24; ++i) {
      const bool isRed = i / 6 % 2 == 0;
      const fs::path folder = scratch_ / "images" / (isRed ? "red" : "blue");
      fs::create_directories(folder);
      const cv::Mat image(48, 64, CV_8UC3, isRed ? cv::Scalar(0, 0, 200 + i) : cv::Scalar(200 + i, 0, 0));
      cv::imwrite((folder / (std::to_string(i) + ".png")).string(), image);
      const std::string number = (i < 10 ? "0" : "") + std::to_string(i);
      cv::imwrite((scratch_ / ("camera" + number + ".png")).string(), image);
    }
  }
  void TearDown() override { unsetenv("ESTANCIA_HOME"); }

  ScratchFolder scratch_;
};

TEST_F(Examples, MapACameraAndAskTheMap) {
  const std::string map = scratch_ / "home.estancia";
  const CommandResult live = runProgram(example("02_map_live"), {map, scratch_ / "camera%02d.png", "word 0"});
  ASSERT_EQ(live.exitCode, 0) << live.err;
  EXPECT_GE(linesBy(live.out)["place"], 1) << live.out;

  const CommandResult later = runProgram(example("09_ask_a_map"), {map, "word 0"});
  ASSERT_EQ(later.exitCode, 0) << later.err;
  auto lines = linesBy(later.out);
  EXPECT_EQ(lines["place"], linesBy(live.out)["place"]);
  EXPECT_GE(lines["->"], 1) << later.out;
  EXPECT_EQ(later.out.substr(0, live.out.size()), live.out);  // the file holds what the session knew
}

TEST_F(Examples, MapLive) {
  const std::string map = scratch_ / "live.estancia";
  const CommandResult live = runProgram(example("11_live"), {scratch_ / "images/red", map});
  ASSERT_EQ(live.exitCode, 0) << live.err;
  auto lines = linesBy(live.out);
  EXPECT_EQ(lines["map"], 1) << live.out;
  EXPECT_EQ(lines["12.png:"], 1) << live.out;
}

TEST_F(Examples, AskForAThingAndTheWayToIt) {
  std::vector<double> around;
  for (int degrees = 0; degrees < 360; degrees += 5) around.push_back(degrees);
  TableSequence({ballAt(-0.15, 0.1, 0.08, red), boxAt(0.2, -0.1, {0.08, 0.06, 0.1}, blue)}, around)
      .writeTo(scratch_ / "drive");
  const CommandResult asked =
      runProgram(example("12_ask_for_a_mug"), {scratch_ / "drive", scratch_ / "table.estancia", "word 0"});
  ASSERT_EQ(asked.exitCode, 0) << asked.err;
  auto lines = linesBy(asked.out);
  EXPECT_EQ(lines["object"], 1) << asked.out << "the ball is red, the box is not";
  EXPECT_GE(lines["->"], 1) << asked.out;
}

TEST_F(Examples, NameTheRoomOfAnImage) {
  const std::string classifier = scratch_ / "rooms.classifier";
  const CommandResult trained =
      run({"classify", "train", scratch_ / "images", "-o", classifier, "--descriptor", "inception-v3",
           "--classifier", "knn", "--type", "classes"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  const CommandResult named =
      runProgram(example("06_name_a_room"), {classifier, scratch_ / "images/red/0.png"});
  ASSERT_EQ(named.exitCode, 0) << named.err;
  EXPECT_EQ(named.out.substr(0, 4), "red ") << named.out;
}

TEST_F(Examples, FindAnObjectInACloud) {
  const auto data = findData("shot_kinect");
  ESTANCIA_NEEDS(data, "shot_kinect is not unpacked");
  const CommandResult found = runProgram(example("07_find_objects"),
                                         {*data / "meshes/mario000_0.ply", *data / "scenes/scene001.pcd"});
  ASSERT_EQ(found.exitCode, 0) << found.err;
  EXPECT_EQ(linesBy(found.out)["object"], 1) << found.out;
}

TEST(Startup, LoadsNeitherImageCodecsNorVideoInput) {
  const auto loaded = runProgram("/usr/bin/env", {"LD_TRACE_LOADED_OBJECTS=1", ESTANCIA_COMMAND});
  EXPECT_NE(loaded.out.find("libopencv_core"), std::string::npos);
  for (const char* large :
       {"libopencv_imgcodecs", "libopencv_videoio", "libgdal", "libavcodec", "libmpi", "libcholmod"})
    EXPECT_EQ(loaded.out.find(large), std::string::npos) << large;
}

/// The command alone, far from its modules.
class LoneCommand : public testing::Test {
 protected:
  void SetUp() override { fs::copy_file(ESTANCIA_COMMAND, command_); }
  const ScratchFolder scratch_;
  const std::string command_ = scratch_ / "estancia";
};

TEST_F(LoneCommand, AsksAMapWithAFloorPlan) {
  writeWorld(sampleWorld(), scratch_ / "home.estancia");
  const auto asked = runProgram(command_, {"ask", scratch_ / "home.estancia", "mug"});
  EXPECT_EQ(asked.exitCode, 0) << asked.err;
}

TEST_F(LoneCommand, SaysWhichModuleItNeedsForImagesAndForVideos) {
  fs::create_directory(scratch_ / "drive");
  for (const char* name : {"drive/1.png", "drive/2.png"})
    cv::imwrite(scratch_ / name, cv::Mat(48, 64, CV_8UC3, cv::Scalar(9, 99, 200)));
  EXPECT_THAT(runProgram(command_, {"check", scratch_ / "drive"}), FailsWith(ErrorCode::missingDependency));
  writeFile(scratch_ / "drive.mp4", std::string("\0\1\2\3", 4));
  EXPECT_THAT(runProgram(command_, {"check", scratch_ / "drive.mp4"}),
              FailsWith(ErrorCode::missingDependency));
}

TEST_F(LoneCommand, SaysBeforeTheFirstFrameWhatItNeedsForMotion) {
  fs::copy_file(ESTANCIA_IMAGES_FILE, scratch_ / "libestancia_images.so");
  for (const char* folder : {"drive/rgb", "drive/depth"}) fs::create_directories(scratch_ / folder);
  cv::imwrite(scratch_ / "drive/rgb/1.png", cv::Mat(48, 64, CV_8UC3, cv::Scalar(9, 99, 200)));
  cv::imwrite(scratch_ / "drive/depth/1.png", cv::Mat(48, 64, CV_16U, cv::Scalar(1000)));
  writeFile(scratch_ / "drive/intrinsics.txt", "60 60 32 24\n");
  const auto tracked = runProgram(
      command_, {"odometry", "estimate", scratch_ / "drive", "-o", scratch_ / "traj.txt", "--no-loops"});
  EXPECT_THAT(tracked, FailsWith(ErrorCode::missingDependency));
  EXPECT_FALSE(fs::exists(scratch_ / "traj.txt"));
}

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

class Laboratory : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* folder : {"bin", "libexec/estancia", "path"}) fs::create_directories(scratch_ / folder);
    fs::copy_file(ESTANCIA_COMMAND, scratch_ / "bin/estancia");
  }

  /// Runs a command that finds no other laboratory than those of the test.
  CommandResult experiment(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"PATH=" + (scratch_ / "path").string(),
                                         (scratch_ / "bin/estancia").string(), "experiment"});
    return runProgram("/usr/bin/env", arguments);
  }

  /// A laboratory that prints its name and its arguments.
  void writeLaboratory(const std::string& folder) const {
    const fs::path file = scratch_ / (folder + "/estancia-lab");
    writeFile(file, "#!/bin/sh\nprintf '%s\\n' " + folder + " \"$@\"\necho warning >&2\nexit 7\n");
    fs::permissions(file, fs::perms::owner_all);
  }

  ScratchFolder scratch_;
};

TEST_F(Laboratory, ThatIsMissingIsOneLineWithThePackage) {
  const auto refused = experiment({"run", "choice.toml", "-o", "out"});
  EXPECT_THAT(refused, FailsWith(ErrorCode::missingDependency, "estancia-lab"));
  EXPECT_EQ(refused.out, "");
  const auto json = nlohmann::json::parse(experiment({"run", "choice.toml", "--json"}).out);
  EXPECT_EQ(json["error"]["code"], "missing-dependency");
  EXPECT_THAT(experiment({}), FailsWith(ErrorCode::missingDependency, "estancia-lab"));
  const auto help = experiment({"--help"});
  EXPECT_EQ(help.exitCode, 0) << help.err;
  EXPECT_THAT(help.out, testing::HasSubstr("estancia-lab"));
}

TEST_F(Laboratory, GetsTheArgumentsAndGivesTheExitCode) {
  for (const std::string folder : {"path", "libexec/estancia", "bin"}) {  // whose turn is later, comes first
    writeLaboratory(folder);
    const auto result = experiment({"run", "a b.toml", "--json", "--help"});
    EXPECT_EQ(result.exitCode, 7);
    EXPECT_EQ(result.out, folder + "\nrun\na b.toml\n--json\n--help\n");
    EXPECT_EQ(result.err, "warning\n");
  }
}

class CompareCommand : public testing::Test {
 protected:
  void SetUp() override {
    // In each of 12 tests ESF/RFs beats GIST/SVM by a little, and PHOG/kNN is far behind.
    std::string wide = "test,GIST/SVM,PHOG/kNN,ESF/RFs\n";
    std::string rows = "descriptor,classifier,train,test,accuracy,balanced_accuracy\n";
    for (int t = 0; t < 12; ++t) {
      const std::string test = std::to_string(t), tenth = "0." + std::to_string(20 + t);
      const std::string good = t % 3 == 0 ? "0.91" : "0.89";
      wide += "A→" + test;
      wide += ",0.90," + tenth;
      wide += "," + good;
      wide += "\n";
      for (const auto& [method, score] : {std::pair{std::string("GIST,SVM"), std::string("0.90")},
                                          {"PHOG,kNN", tenth},
                                          {"ESF,RFs", good}}) {
        rows += method + ",A,";
        rows += test + "," + score;
        rows += ",0.5\n";
      }
    }
    writeFile(wide_, wide);
    writeFile(long_, rows);
  }

  static json compared(const std::vector<std::string>& arguments) {
    return jsonOf(run({"compare", "--json"}, arguments));
  }
  static void refuses(const std::vector<std::string>& arguments, ErrorCode code) {
    const auto result = run({"compare"}, arguments);
    EXPECT_THAT(result, FailsWith(code));
    EXPECT_EQ(result.out, "");
  }

  ScratchFolder scratch_;
  const std::string wide_ = scratch_ / "wide.csv", long_ = scratch_ / "results.csv";
};

TEST_F(CompareCommand, TakesTheResultsOfAnExperiment) {
  json wide = compared({wide_}), rows = compared({long_});
  EXPECT_EQ(rows["tests"][0], "A→0");
  EXPECT_EQ(wide, rows);
  EXPECT_EQ(wide["control"], "GIST/SVM");
  EXPECT_EQ(wide["methods"].size(), 3U);
  EXPECT_TRUE(wide["methods"][0]["p"].is_null());
  EXPECT_EQ(wide["methods"][2]["rejected"], true);
  EXPECT_EQ(wide["pairs"].size(), 2U);
  EXPECT_NEAR(wide["friedman"]["chi_squared"].get<double>(), 56.0 / 3, 1e-9);
  const json equal = compared({long_, "--score", "balanced_accuracy"});
  EXPECT_EQ(equal["differ"], false);
  EXPECT_EQ(equal["friedman"]["p"], 1);
  EXPECT_FALSE(equal["friedman"]["undefined"].get<std::string>().empty());
}

TEST_F(CompareCommand, TakesSomeOfTheTests) {
  EXPECT_EQ(compared({wide_, "--only", "→1", "--without", "→11"})["tests"], json({"A→1", "A→10"}));
  refuses({wide_, "--only", "B→"}, ErrorCode::insufficientData);
}

TEST_F(CompareCommand, WritesTablesPageAndDiagram) {
  const fs::path out = scratch_ / "some" / "where";
  const auto result = run({"compare", wide_, "--post-hoc", "shaffer", "-o", out.string()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  refuses({wide_, "-o", out.string()}, ErrorCode::fileExists);
  EXPECT_THAT(readFile(out / "comparison.md"),
              StartsWith("# 3 methods compared over 12 tests\n\n3 methods differ"));
  EXPECT_THAT(readFile(out / "comparison.csv"),
              StartsWith("method,p-value,rejected,rank,win,tie,loss\nGIST/SVM,,no,1.3333333333333333,,,\n"));
  EXPECT_NE(readFile(out / "comparison.tex").find("\\begin{tabular}{lrrrrrr}\n"), std::string::npos);
  EXPECT_THAT(readFile(out / "comparison.svg"), StartsWith("<?xml"));
  const std::string page = readFile(out / "comparison.html");
  EXPECT_NE(page.find("class=\"group\""), std::string::npos);
  EXPECT_EQ(std::distance(fs::directory_iterator(out), fs::directory_iterator()), 5);
}

TEST_F(CompareCommand, SaysWhatIsWrong) {
  refuses({(scratch_ / "missing.csv").string()}, ErrorCode::fileNotFound);
  refuses({wide_, "--control", "ESF"}, ErrorCode::unknownName);
  refuses({wide_, "--post-hoc", "tukey"}, ErrorCode::unknownName);
  refuses({wide_, "--alpha", "5"}, ErrorCode::invalidOption);
  refuses({long_, "--score", "f1"}, ErrorCode::unknownName);
  refuses({wide_, "-o", wide_}, ErrorCode::fileUnwritable);
  writeFile(wide_, "test,a,b\nx,1,2\n");
  refuses({wide_}, ErrorCode::insufficientData);
}

TEST_F(CompareCommand, ItsExampleWorks) {
  const std::string help = run({"compare", "--help"}).out;
  const auto head = help.find("test,GIST/SVM");
  ASSERT_NE(head, std::string::npos);
  writeFile(wide_, help.substr(head));
  EXPECT_EQ(compared({wide_})["control"], "ESF/forest");
}

}  // namespace
}  // namespace estancia::test
