// Programs as labelers, the well and the badly behaved. Scripts run in the model's folder.
// SPDX-License-Identifier: Apache-2.0
#include <dirent.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "estancia/labelers/model.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {
namespace fs = std::filesystem;

using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;

/// A loop that answers every image with `labels`.
std::string answering(const std::string& labels) {
  return "while read -r image; do printf '{\"image\": \"%s\", \"labels\": " + labels +
         "}\\n' \"$image\"; done\n";
}

const cv::Mat& grayImage() {
  static const cv::Mat image(4, 6, CV_8UC3, cv::Scalar::all(128));
  return image;
}

std::size_t openFiles() {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

class ProcessLabeler : public testing::Test {
 protected:
  std::unique_ptr<Labeler> open(const std::string& script, const std::string& more = "") {
    writeFile(scratch_ / "labeler.sh", script);
    return openCommand(R"(["sh", "labeler.sh"])", more);
  }
  std::unique_ptr<Labeler> openCommand(const std::string& command, const std::string& more = "") {
    writeFile(scratch_ / "model.toml",
              "name = \"mine\"\ntype = \"process\"\ncommand = " + command + "\n" + more + "\n");
    return loadModel(scratch_.path().string());
  }
  /// What labeling one image with this script complains about.
  test::Caught refusal(const std::string& script, const std::string& more = "") {
    const auto labeler = open(script, more);
    return test::caught([&] { labeler->label(grayImage()); });
  }
  void TearDown() override {
    EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
    EXPECT_EQ(errno, ECHILD);
  }
  test::ScratchFolder scratch_;
};

TEST_F(ProcessLabeler, LabelsImages) {
  writeFile(scratch_ / "labels.txt", "mug\ncup\nspoon\n");
  const auto labeler =
      open(answering(R"({"cup": 0.75, "mug": 0.25, "unheard of": 1})"), "labels = \"labels.txt\"");
  EXPECT_FALSE(labeler->discovers());
  EXPECT_TRUE(labeler->needsImage());
  for (int i = 0; i < 3; ++i) EXPECT_THAT(labeler->label(grayImage()), ElementsAre(0.25F, 0.75F, 0));
  EXPECT_EQ(labeler->identity().substr(0, 5), "mine ");
}

TEST_F(ProcessLabeler, FindsItsProgramInItsFolderAndMayNameTheImageWithoutItsFolder) {
  const fs::path program = scratch_ / "answer";
  std::set<std::string> identities;
  for (const std::string& said : {std::string("1"), std::string("0.5")}) {
    writeFile(program,
              "#!/bin/sh\nwhile read -r i; do echo \"{\\\"image\\\": \\\"${i##*/}\\\", \\\"labels\\\": "
              "{\\\"cup\\\": " +
                  said + "}}\"; done\n");
    fs::permissions(program, fs::perms::owner_all);
    for (const std::string& command : {std::string("answer"), std::string("./answer"), program.string()}) {
      const auto labeler = openCommand("[\"" + command + "\"]");
      EXPECT_THAT(labeler->label(grayImage()), ElementsAre(std::stof(said))) << command;
      identities.insert(labeler->identity());
    }
  }
  EXPECT_EQ(identities.size(), 6U) << "another command or another program is another model";
}

TEST_F(ProcessLabeler, TakesNoMoreThanTheMachineHasAndIsEndedFirst) {
  refusal(
      "read -r image; sleep 0.2\n"
      "echo $(cat /proc/self/oom_score_adj) $(ulimit -c) $(ulimit -d) >limits; exit 3\n");
  const long kibibytes = sysconf(_SC_PHYS_PAGES) * (sysconf(_SC_PAGESIZE) / 1024);
  EXPECT_EQ(test::readFile(scratch_ / "limits"), "1000 0 " + std::to_string(kibibytes) + "\n");
}

TEST_F(ProcessLabeler, HandsOverTheWholeImageAndTakesItAway) {
  cv::Mat image(30, 40, CV_8UC3);
  cv::RNG(1).fill(image, cv::RNG::UNIFORM, 0, 256);
  std::string path;
  {
    const auto labeler = open(
        "read -r image; echo \"$image\" >path; cp \"$image\" copy.png\n"
        "printf '{\"image\": \"%s\", \"labels\": {\"noise\": 1}}\\n' \"$image\"; read -r none\n");
    labeler->label(image);
    path = test::readFile(scratch_ / "path");
    path.pop_back();
    EXPECT_EQ(cv::norm(cv::imread(scratch_ / "copy.png"), image, cv::NORM_INF), 0);
    EXPECT_FALSE(fs::exists(path));
    struct stat folder {};
    ASSERT_EQ(stat(fs::path(path).parent_path().c_str(), &folder), 0);
    EXPECT_EQ(folder.st_mode & 0777U, 0700U) << "nobody else may look";
  }
  EXPECT_FALSE(fs::exists(fs::path(path).parent_path()));
}

TEST_F(ProcessLabeler, DiscoversWordsTheSurestFirst) {
  const auto labeler = open(
      "n=0; while read -r image; do n=$((n + 1))\n"
      "if [ $n = 1 ]; then l='[{\"label\": \"b\", \"confidence\": 0.1}, {\"label\": "
      "\"c\", \"confidence\": 0.9}, {\"label\": \"a\", \"confidence\": 0.1}]'\n"
      "else l='{\"d\": 0.5, \"c\": 0.25, \"e\": 0}'; fi\n"
      "echo \"{\\\"image\\\": \\\"$image\\\", \\\"labels\\\": $l}\"; done\n");
  EXPECT_TRUE(labeler->discovers());
  EXPECT_THAT([&] { labeler->vocabulary(); }, FailsWith(ErrorCode::invalidState));
  EXPECT_THAT(labeler->label(grayImage()), ElementsAre(0.9F, 0.1F, 0.1F));
  EXPECT_THAT(labeler->vocabulary().labels(), ElementsAre("c", "a", "b"));
  EXPECT_THAT(labeler->label(grayImage()), ElementsAre(0.25F, 0, 0, 0.5F));
  EXPECT_THAT(labeler->vocabulary().labels(), ElementsAre("c", "a", "b", "d"));
  const std::vector<LabelProbability> remembered{{"z", 0.5F}, {"a", 0.25F}};
  EXPECT_THAT(labeler->adopt(remembered), ElementsAre(0, 0.25F, 0, 0, 0.5F));
}

TEST_F(ProcessLabeler, ScalesAndClampsAndKeepsTheBestWords) {
  EXPECT_THAT(open(answering(R"({"cup": 87, "mug": 5})"), "scale = 0.01")->label(grayImage()),
              ElementsAre(testing::FloatEq(0.87F), testing::FloatEq(0.05F)));
  EXPECT_THAT(open(answering(R"({"cup": 1.00005, "mug": -0.00001})"))->label(grayImage()), ElementsAre(1));
  const auto labeler = open(answering(R"({"a": 0.1, "b": 0.5, "c": 0.3})"), "best = 2");
  EXPECT_THAT(labeler->label(grayImage()), ElementsAre(0.5F, 0.3F));
  EXPECT_THAT(labeler->vocabulary().labels(), ElementsAre("b", "c"));
}

TEST_F(ProcessLabeler, GoesOnAfterAnImageThatCannotBeLabeled) {
  const auto labeler =
      open("read -r image; echo \"{\\\"image\\\": \\\"$image\\\", \\\"error\\\": \\\"too dark\\\"}\"\n" +
           answering(R"({"cup": 1})"));
  const std::vector<Prepared> batch{labeler->prepare(grayImage()), labeler->prepare(grayImage())};
  const auto results = labeler->inferBatch(batch);
  EXPECT_EQ(results[0].problem, "model mine: too dark");
  EXPECT_EQ(results[1].problem, "");
  EXPECT_THAT(results[1].descriptor, ElementsAre(1));
}

TEST_F(ProcessLabeler, RefusesNonsense) {
  const auto refusalOf = [&](const std::string& line) {
    return refusal("read -r image\ncat <<END\n" + line + "\nEND\nread -r none\n");
  };
  const std::string image = R"({"image": "$image", "labels": )";
  for (const std::string& line :
       {std::string("Loading weights ..."), image + R"({"cup": NaN}})", image + R"({"cup": 1e999}})",
        image + R"({"cup": 87}})", image + R"({"cup": -0.2}})", image + R"({"cup": 1.001}})",
        image + R"({"cup": "high"}})", image + R"({" ": 1}})", image + "\"cup\"}",
        image + R"([{"label": "cup"}]})", image + R"([{"label": 3, "confidence": 1}]})", image + R"([7]})",
        std::string(R"({"image": "$image"})"), image + std::string(2000, '['), std::string()})
    EXPECT_THAT(refusalOf(line), FailsWith(ErrorCode::malformedFile)) << line;
  for (const std::string line : {R"({"image": "other.png", "labels": {}})", R"({"labels": {"cup": 1}})"})
    EXPECT_THAT(refusalOf(line), FailsWith(ErrorCode::labelerFailure)) << line;
}

TEST_F(ProcessLabeler, FailsWhenItsProgramDiesCannotBeStartedOrNeverAnswers) {
  for (const std::string script :
       {"echo one >&2; exit 3\n", "kill -SEGV $$\n", "exit 0\n", "exec >&-; exec sleep 1000\n"})
    EXPECT_THAT(refusal(script), FailsWith(ErrorCode::labelerFailure)) << script;
  writeFile(scratch_ / "not-executable", "");
  for (const std::string command : {R"(["no-such-program"])", R"(["./not-executable"])"})
    EXPECT_THAT([&] { openCommand(command)->label(grayImage()); }, FailsWith(ErrorCode::missingDependency))
        << command;
  EXPECT_THAT(refusal("exec sleep 1000\n", "start_timeout = 0.05"), FailsWith(ErrorCode::labelerFailure));
  EXPECT_THAT(refusal("exec <&-; exec sleep 1000\n", "start_timeout = 0.05"),
              FailsWith(ErrorCode::labelerFailure))
      << "a closed stdin must not raise SIGPIPE";
  EXPECT_THAT(refusal("read -r image; while :; do printf x; sleep 0.01; done\n", "start_timeout = 0.2"),
              FailsWith(ErrorCode::labelerFailure))
      << "dribbling is no answer";
}

TEST_F(ProcessLabeler, AHangingOneIsKilledWithItsChildrenAndStartedAgain) {
  const auto labeler =
      open("if [ -e first ]; then\n" + answering(R"({"cup": 0.5})") +
               "fi; touch first; echo $$ >parent; sleep 1000 & echo $! >child\n"
               "read -r image; printf '{\"image\": \"%s\", \"labels\": {\"cup\": 1}}\\n' \"$image\"; wait\n",
           "timeout = 0.1");
  EXPECT_THAT(labeler->label(grayImage()), ElementsAre(1));
  EXPECT_THAT(labeler->label(grayImage()), ElementsAre(0.5F));
  EXPECT_FALSE(test::livesOn(scratch_ / "parent"));
  EXPECT_FALSE(test::livesOn(scratch_ / "child"));
}

TEST_F(ProcessLabeler, IsEndedWithItsChildrenWhenWeEnd) {
  open("sleep 1000 & echo $! >child; echo $$ >parent; trap '' TERM HUP INT\n" + answering(R"({"cup": 1})") +
       "exec sleep 1000\n")
      ->label(grayImage());
  EXPECT_FALSE(test::livesOn(scratch_ / "parent"));
  EXPECT_FALSE(test::livesOn(scratch_ / "child"));
}

/// What becomes of it when our process is killed with an image in its hands.
class KilledOwner : public ProcessLabeler {
 protected:
  void SetUp() override {
    fs::create_directory(temporary_);
    setenv("TMPDIR", temporary_.c_str(), 1);
  }
  void TearDown() override {
    unsetenv("TMPDIR");
    ProcessLabeler::TearDown();
  }
  void labelAndBeKilled(const std::string& script, const std::string& command) {
    const pid_t owner = fork();
    if (owner == 0) {
      writeFile(scratch_ / "owner", std::to_string(getpid()));
      writeFile(scratch_ / "labeler.sh",
                script + "read -r image; kill -KILL $(cat owner); exec sleep 1000\n");
      openCommand(command)->label(grayImage());
      _exit(1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(owner, &status, 0), owner);
    ASSERT_TRUE(WIFSIGNALED(status));
  }
  std::vector<std::string> temporaryFolders() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(temporary_)) names.push_back(entry.path().filename());
    return names;
  }
  const fs::path temporary_ = scratch_ / "tmp";
};

TEST_F(KilledOwner, LeavesAFolderThatGoesWithTheNextStart) {
  labelAndBeKilled("", R"(["sh", "labeler.sh"])");
  const auto left = temporaryFolders();
  ASSERT_EQ(left.size(), 1U);
  ASSERT_TRUE(fs::exists(temporary_ / left[0] / "000000.png"));
  writeFile(scratch_ / "precious", "text");
  fs::create_symlink(scratch_ / "precious", temporary_ / left[0] / "link");
  {
    const auto first = openCommand(R"(["sh", "labeler.sh"])");
    const auto kept = temporaryFolders();
    ASSERT_EQ(kept.size(), 1U);
    EXPECT_NE(kept[0], left[0]);
    const auto second = openCommand(R"(["sh", "labeler.sh"])");
    EXPECT_EQ(temporaryFolders().size(), 2U) << "the first one is in use";
  }
  EXPECT_THAT(temporaryFolders(), testing::IsEmpty());
  EXPECT_EQ(test::readFile(scratch_ / "precious"), "text");
}

TEST_F(KilledOwner, LeavesTheFoldersOfOthersAlone) {
  const auto abandoned = [&](const fs::path& folder) {
    writeFile(folder / "estancia.lock", "");
    writeFile(folder / "000000.png", "");
    return folder;
  };
  abandoned(scratch_ / "elsewhere");
  fs::create_directory_symlink(scratch_ / "elsewhere", temporary_ / "estancia-linked");
  const fs::path strange = temporary_ / "estancia-odLock";  // its lock is a link
  writeFile(strange / "000000.png", "");
  fs::create_symlink(scratch_ / "elsewhere/estancia.lock", strange / "estancia.lock");
  writeFile(temporary_ / "estancia-noLock" / "000000.png", "");
  abandoned(temporary_ / "estancia-longer-name");
  abandoned(temporary_ / "another");
  const bool root = geteuid() == 0;
  const fs::path theirs = root ? abandoned(temporary_ / "estancia-theirs") : temporary_ / "another";
  ASSERT_EQ(chown(theirs.c_str(), root ? 65534 : geteuid(), root ? 65534 : getegid()), 0);
  open("");
  EXPECT_EQ(temporaryFolders().size(), root ? 6U : 5U);
  for (const auto& name : temporaryFolders())
    EXPECT_TRUE(fs::exists(temporary_ / name / "000000.png")) << name;
}

TEST_F(ProcessLabeler, SurvivesFloods) {
  // On a busy machine the flood may be there before the first question.
  EXPECT_THAT(refusal("tr '\\0' x </dev/zero\n"), FailsWith(ErrorCode::labelerFailure));
  const std::string complaints = "head -c 3000000 /dev/zero | tr '\\0' e >&2\n";
  EXPECT_THAT(open(complaints + answering(R"({"cup": 1})"))->label(grayImage()), ElementsAre(1));
  EXPECT_LT(refusal(complaints + "exit 1\n").message.size(), 600U);
}

TEST_F(ProcessLabeler, InheritsAndLeavesNothing) {
  const int secret = ::open("/dev/null", O_RDONLY);  // a careless library opens files like this: inheritable
  ASSERT_EQ(dup2(secret, 77), 77);
  const std::size_t before = openFiles();
  open("ls /proc/$$/fd >fds\n" + answering(R"({"cup": 1})"))->label(grayImage());
  refusal("exit 1\n");
  refusal("exec sleep 1000\n", "start_timeout = 0.05");
  EXPECT_EQ(openFiles(), before);
  const std::string descriptors = test::readFile(scratch_ / "fds");
  EXPECT_NE(descriptors.find("0\n1\n"), std::string::npos);
  EXPECT_EQ(descriptors.find("77"), std::string::npos);
  ::close(secret);
  ::close(77);
}

TEST_F(ProcessLabeler, ChecksItsSettings) {
  for (const std::string line : {"comand = 1", "timeout = 0", "best = 0"})
    EXPECT_THAT([&] { open("", line); }, FailsWith(ErrorCode::malformedFile)) << line;
  EXPECT_THAT([&] { open("", "labels_at = \"labels\""); }, FailsWith(ErrorCode::invalidOption));
  for (const std::string command : {"[]", "\"sh labeler.sh\""})
    EXPECT_THAT([&] { openCommand(command); }, FailsWith(ErrorCode::malformedFile)) << command;
}

TEST_F(ProcessLabeler, IsStartedAgainOnce) {
  const auto labeler = open(
      "read -r image; [ -e died ] || { touch died; exit 3; }\n"
      "printf '{\"image\": \"%s\", \"labels\": {\"cup\": 1}}\\n' \"$image\"\n");
  // It ends after every answer: that is a new start an image, but no failure.
  for (int i = 0; i < 3; ++i) EXPECT_THAT(labeler->label(grayImage()), ElementsAre(1));
  EXPECT_TRUE(fs::exists(scratch_ / "died"));
}

TEST_F(ProcessLabeler, RefusesAnswersThatNobodyAskedFor) {
  const auto labeler = open(
      "while read -r image; do l=\"{\\\"image\\\": \\\"$image\\\", \\\"labels\\\": {\\\"cup\\\": 1}}\"\n"
      "printf '%s\\n%s\\n' \"$l\" \"$l\"; done\n");
  labeler->label(grayImage());
  EXPECT_THAT([&] { labeler->label(grayImage()); }, FailsWith(ErrorCode::labelerFailure));
}

}  // namespace
}  // namespace estancia
