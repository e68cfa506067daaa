#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

std::size_t filesIn(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(WriteWhole, ReplacesAFileAndLeavesNothingBeside) {
  const test::ScratchFolder folder;
  writeWhole(folder / "a.json", "first");
  writeWhole(folder / "a.json", std::string("se\0cond", 7));
  EXPECT_EQ(test::readFile(folder / "a.json"), std::string("se\0cond", 7));
  EXPECT_EQ(filesIn(folder.path()), 1U);
}

TEST(WriteWhole, RefusesAFolderAndAMissingFolder) {
  const test::ScratchFolder folder;
  EXPECT_THROW(writeWhole(folder.path(), "x"), Error);
  EXPECT_THROW(writeWhole(folder / "none/a.json", "x"), Error);
  EXPECT_EQ(filesIn(folder.path()), 0U);
}

TEST(WriteWhole, KeepsTheOldFileWhenTheDiskIsFull) {
  const test::ScratchFolder folder;
  writeWhole(folder / "a.json", "old");
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};  // for this process the same as a full disk
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      writeWhole(folder / "a.json", std::string(100000, 'x'));
    } catch (const Error&) {
      _exit(0);
    }
    _exit(1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "a full disk must be told";
  EXPECT_EQ(test::readFile(folder / "a.json"), "old");
  EXPECT_EQ(filesIn(folder.path()), 1U);
}

}  // namespace
}  // namespace estancia
