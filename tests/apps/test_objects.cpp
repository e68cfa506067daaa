// `estancia objects` as a user runs it, from a sequence to what its things are.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>

#include "support/color_model.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "support/table_scene.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

const cv::Vec3b red{0, 0, 255}, blue{255, 0, 0};

const char* const study = R"(
[classes.ball]
labels = ["word 0"]
[classes.box]
labels = ["word 1"]
)";

std::vector<Solid> things() {
  return {ballAt(0.2, 0.2, 0.05, red),
          ballAt(0.0, 0.2, 0.06, red),
          ballAt(-0.2, 0.2, 0.07, red),
          boxAt(0.2, -0.15, {0.05, 0.04, 0.06}, blue),
          boxAt(0.0, -0.15, {0.04, 0.06, 0.05}, blue),
          boxAt(-0.2, -0.15, {0.05, 0.05, 0.07}, blue)};
}

class Objects : public testing::Test {
 protected:
  void SetUp() override {
    setenv("ESTANCIA_CACHE", (scratch_ / "cache").c_str(), 1);
    TableSequence(things(), {0, 15, 30, 45}).writeTo(scratch_ / "table");
    writeColorModel(scratch_ / "colors");
    writeFile(scratch_ / "study.toml", study);
  }
  void TearDown() override { unsetenv("ESTANCIA_CACHE"); }
  CommandResult objects(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "objects");
    return run(arguments);
  }
  CommandResult collect(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"collect", scratch_ / "table", "-o", scratch_ / "things"};
    all.insert(all.end(), more.begin(), more.end());
    return objects(all);
  }
  CommandResult label(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"label", scratch_ / "things", "--model", scratch_ / "colors"};
    all.insert(all.end(), more.begin(), more.end());
    return objects(all);
  }
  CommandResult train(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{
        "train",        scratch_ / "things", "--study", scratch_ / "study.toml", "-o", model(),
        "--classifier", "svm-linear",        "--all"};
    all.insert(all.end(), more.begin(), more.end());
    return objects(all);
  }
  std::string model() const { return scratch_ / "table.objects"; }

  ScratchFolder scratch_;
};

std::vector<json> lines(const std::string& text) {
  std::vector<json> all;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) all.push_back(json::parse(line));
  return all;
}

TEST_F(Objects, ThingsNameThemselves) {
  const CommandResult collected = collect({"--json"});
  ASSERT_EQ(collected.exitCode, 0) << collected.err;
  const json counts = json::parse(collected.out);
  EXPECT_EQ(counts["frames"], 4);
  EXPECT_EQ(counts["instances"], 6);
  EXPECT_EQ(counts["views"], 24);
  EXPECT_EQ(counts["unread"], 0);

  const CommandResult labeled = label({"--json"});
  ASSERT_EQ(labeled.exitCode, 0) << labeled.err;
  EXPECT_EQ(json::parse(labeled.out)["views"], 24);
  EXPECT_EQ(json::parse(labeled.out)["words"], 4) << "all that it says is kept";
  EXPECT_TRUE(fs::exists(scratch_ / "things/words.labels"));
  const CommandResult again = label({"--json", "--overwrite"});
  ASSERT_EQ(again.exitCode, 0) << again.err;
  EXPECT_EQ(json::parse(again.out)["remembered"], 24) << "images that were labeled before";

  const CommandResult wider = label({"--json", "--overwrite", "--margin", "0.3", "--background", "gray"});
  ASSERT_EQ(wider.exitCode, 0) << wider.err;
  EXPECT_EQ(json::parse(wider.out)["remembered"], 0) << "other images";
  ASSERT_EQ(label({"--overwrite"}).exitCode, 0);

  const CommandResult trained = train({"--json"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  const json learned = json::parse(trained.out);
  ASSERT_THAT(learned["words"], SizeIs(2));
  for (const json& word : learned["words"]) {
    EXPECT_EQ(word["instances"], 3) << word;
    EXPECT_EQ(word["views"], 12);
    EXPECT_GT(word["held_out_accuracy"], 0.8);
    EXPECT_NEAR(word["prior"], 0.5, 0.2);
  }
  EXPECT_EQ(learned["names"], "voted");
  EXPECT_EQ(learned["pseudo_label_accuracy"], nullptr) << "nobody knows";

  // Another ball and another box, the ball seen in the dark: shapes go on.
  TableSequence other({ballAt(0.1, 0.15, 0.055, red), boxAt(0, -0.1, {0.05, 0.05, 0.06}, blue)}, {70, 80});
  other.writeTo(scratch_ / "other");
  other.dim(0.03);
  other.writeTo(scratch_ / "dark");
  for (const bool dark : {false, true}) {
    const CommandResult told =
        objects({"predict", scratch_ / (dark ? "dark" : "other"), "--model", model(), "--labeler",
                 scratch_ / "colors", "--json", "--render", scratch_ / (dark ? "dark.png" : "other.png")});
    ASSERT_EQ(told.exitCode, 0) << told.err;
    const auto frames = lines(told.out);
    ASSERT_THAT(frames, SizeIs(2));
    std::set<std::string> words;
    for (const json& thing : frames[1]["things"]) {
      EXPECT_EQ(thing["views"], 2);
      EXPECT_EQ(thing["believed"]["source"], dark ? "shape" : "both") << thing;
      EXPECT_THAT(thing["box"], SizeIs(4));
      words.insert(thing["believed"]["word"]);
    }
    EXPECT_EQ(words, (std::set<std::string>{"ball", "box"}));
  }
  EXPECT_EQ(cv::imread(scratch_ / "other.png").size(), cv::Size(320, 240));
}

TEST_F(Objects, TellsPeopleWhatItDid) {
  const CommandResult collected = collect();
  EXPECT_THAT(collected.out, HasSubstr("24 views of 6 things in 4 frames"));
  ASSERT_EQ(label().exitCode, 0);
  const CommandResult trained = train();
  EXPECT_THAT(trained.out, AllOf(HasSubstr("2 words of 24 views"), HasSubstr("ball"), HasSubstr("held out"),
                                 HasSubstr("of what the labeler says is about these words")));
  const CommandResult told = objects({"predict", scratch_ / "table", "--model", model(), "--shape-only",
                                      "--first", "1", "--every", "2", "--frames", "1"});
  ASSERT_EQ(told.exitCode, 0) << told.err;
  EXPECT_THAT(told.out, AllOf(HasSubstr("0001.png: 6 things"), Not(HasSubstr("0003.png")),
                              HasSubstr("image -"), HasSubstr("no labeler was asked")));
}

TEST_F(Objects, TrueCategoriesAreLearnedWithoutAStudy) {
  ASSERT_EQ(collect().exitCode, 0);
  const std::string list = scratch_ / "things/samples.csv";
  const CommandResult unknown = objects({"train", scratch_ / "things", "--truth", "-o", model()});
  EXPECT_EQ(unknown.exitCode, 2);
  EXPECT_THAT(unknown.err, HasSubstr("nobody says what these things are"));
  std::istringstream in(readFile(list));
  std::ostringstream named;
  for (std::string line; std::getline(in, line); named << '\n') {
    const auto instance = line.find(',') + 1, category = line.find(',', instance) + 1;
    named << line.substr(0, category);
    if (line.starts_with("object-"))
      named << (line.substr(instance, category - instance) < "object-0003" ? "first" : "second");
    named << line.substr(category);
  }
  writeFile(list, named.str());
  const CommandResult trained = objects({"train", scratch_ / "things", "--truth", "-o", model(), "--all",
                                         "--classifier", "svm-linear", "--json"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  const json learned = json::parse(trained.out);
  EXPECT_EQ(learned["names"], "true");
  EXPECT_EQ(learned["words"][0]["word"], "first");
  EXPECT_EQ(learned["words"][0]["prior"], nullptr);
  EXPECT_EQ(learned["words"][1]["instances"], 3);
}

TEST_F(Objects, NothingThatIsThereIsReplacedUnasked) {
  writeFile(scratch_ / "things/notes.txt", "mine");
  CommandResult result = collect();
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result, FailsWith(ErrorCode::fileExists, "things", "--overwrite"));
  result = collect({"--overwrite"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result, FailsWith(ErrorCode::fileExists, "things"));
  EXPECT_EQ(readFile(scratch_ / "things/notes.txt"), "mine");
  fs::remove_all(scratch_ / "things");
  ASSERT_EQ(collect().exitCode, 0);
  EXPECT_EQ(collect().exitCode, 2);
  EXPECT_EQ(collect({"--overwrite", "--frames", "1"}).exitCode, 0);
  ASSERT_EQ(label().exitCode, 0);
  result = label();
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("--overwrite"));

  writeFile(model(), "mine");
  EXPECT_EQ(train().exitCode, 2);
  result = train({"--overwrite"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("model of objects"));
  EXPECT_EQ(readFile(model()), "mine");
}

TEST_F(Objects, SaysWhatIsMissing) {
  TableSequence(things(), {0}).writeTo(scratch_ / "flat");
  fs::remove_all(scratch_ / "flat/depth");
  CommandResult result = objects({"collect", scratch_ / "flat/rgb", "-o", scratch_ / "none"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("no depth images"));
  fs::remove(scratch_ / "table/intrinsics.txt");
  result = collect();
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("--intrinsics"));
  EXPECT_FALSE(fs::exists(scratch_ / "things"));
  writeFile(scratch_ / "camera.txt", "262.5 262.5 159.5 119.5\n");
  ASSERT_EQ(collect({"--intrinsics", scratch_ / "camera.txt"}).exitCode, 0);

  result = train();
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("objects label"));
  ASSERT_EQ(label().exitCode, 0);
  result = objects({"train", scratch_ / "things", "-o", model()});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("--study"));
  writeFile(scratch_ / "study.toml", "[classes.kettle]\n[classes.teapot]\n");
  result = train();
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result, FailsWith(ErrorCode::unknownName, "kettle", "teapot"));
  writeFile(scratch_ / "study.toml", "[classes.ball]\nlabels = [\"word 0\"]\n");
  result = train();
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result, FailsWith(ErrorCode::insufficientData, "ball")) << "one class is not enough";

  result = label({"--overwrite", "--margin", "0.7"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("was collected with 0.5")) << "beyond is nothing to see";
  result = objects({"predict", scratch_ / "table", "--model", model(), "--shape-only", "--margin", "0.2"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("--margin excludes --shape-only"));
  result = collect({"--overwrite", "--first", "17"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_TRUE(fs::exists(scratch_ / "things/words.labels")) << "nothing is lost by a slip";
  fs::resize_file(scratch_ / "things/samples.csv", 10);
  result = label({"--overwrite"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("samples.csv")) << "it is not taken for a folder of clouds";

  writeFile(model(), "no model");
  result = objects({"predict", scratch_ / "table", "--model", model()});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("table.objects"));
  result = objects({"label", scratch_ / "table", "--model", scratch_ / "colors"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("[unsupported-file]"));
  fs::remove(model());
  result = train({"--names", "guessed"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("voted"));
  result = train({"--labels", "a.labels", "--labels", "b.labels"});
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.err, HasSubstr("as many --labels"));
}

TEST_F(Objects, AnEmptyTableHasNoAnswer) {
  TableSequence({}, {0, 10}).writeTo(scratch_ / "empty");
  const CommandResult result = objects({"collect", scratch_ / "empty", "-o", scratch_ / "none"});
  EXPECT_EQ(result.exitCode, 1) << result.err;
  EXPECT_THAT(result.out, HasSubstr("Nothing stands about in the 2 frames"));
}

TEST_F(Objects, HelpHasExamples) {
  for (const char* command : {"collect", "label", "train", "predict"})
    EXPECT_THAT(objects({command, "--help"}).out, HasSubstr(std::string("  estancia objects ") + command));
}

}  // namespace
}  // namespace estancia::test
