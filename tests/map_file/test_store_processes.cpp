// The map file among other processes: two writers, a killed one, read-only and full places.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <functional>

#include "estancia/core/error.hpp"
#include "estancia/map_file/store.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using Access = MapStore::Access;
using test::FailsWith;

constexpr std::size_t networkLabels = 1001;

MapStore::Identity wideIdentity() {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < networkLabels; ++i) words.push_back("label " + std::to_string(i));
  return {Vocabulary(words), "model", "{}"};
}

void addFrame(MapStore& store, std::size_t index) {
  MappedFrame frame;
  frame.name = std::to_string(index);
  frame.number = index;
  store.addFrame(frame, LexicalDescriptor(networkLabels, static_cast<float>(index % 100) / 100));
  store.putDecision({index, DecisionKind::join, 0, 0, 0.1, -1, 0, 0.3, 0.2});
  store.putNode({0, index + 1, std::vector<float>(networkLabels), std::vector<float>(networkLabels)}, "");
}

fs::path wideMap(const test::ScratchFolder& folder, std::size_t frames) {
  const fs::path path = folder / "map.estancia";
  MapStore store = MapStore::create(path, wideIdentity());
  for (std::size_t i = 0; i < frames; ++i) addFrame(store, i);
  store.commit();
  return path;
}

void makeNew(const fs::path& path, ExistingMap existing) {
  MapStore store = MapStore::create(path, wideIdentity(), existing);
  addFrame(store, 0);
  store.commit();
}

std::string readAll(int pipe) {
  std::string text;
  std::array<char, 4096> part{};
  for (ssize_t count = 0; (count = read(pipe, part.data(), part.size())) > 0;)
    text.append(part.data(), static_cast<std::size_t>(count));
  return text;
}

/// Runs `action` in a process of its own; gives what it threw, or the signal that killed it as the message.
test::Caught caughtInAnotherProcess(const std::function<void()>& action) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return {std::nullopt, "(no pipe)"};
  const pid_t child = fork();
  if (child == 0) {
    std::string report;
    try {
      action();
    } catch (const Error& error) {
      report = std::string(nameOf(error.code())) + "\n" + error.what();
    } catch (const std::exception& error) {
      report = std::string("\n") + error.what();
    }
    const ssize_t written = write(ends[1], report.data(), report.size());
    _exit(written < 0 ? 1 : 0);
  }
  close(ends[1]);
  const std::string report = readAll(ends[0]);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status)) return {std::nullopt, "signal " + std::to_string(WTERMSIG(status))};
  if (report.empty()) return {};
  const std::size_t line = report.find('\n');
  return {findErrorCode(report.substr(0, line)), report.substr(line + 1)};
}

/// A number that another process counts, or what it threw.
std::string framesInAnotherProcess(const std::function<std::size_t()>& count) {
  return caughtInAnotherProcess([&] { throw std::runtime_error(std::to_string(count())); }).message;
}

/// Permission bits do not bind root: become an unprivileged user.
void dropPrivileges() {
  if (geteuid() != 0) return;
  if (setgroups(0, nullptr) != 0 || setegid(65534) != 0 || seteuid(65534) != 0)
    throw std::runtime_error("cannot drop privileges");
}

TEST(MapStoreProcesses, RefusesASecondWriterButServesReaders) {
  const test::ScratchFolder folder;
  const fs::path path = wideMap(folder, 3);
  {
    MapStore writer = MapStore::open(path, Access::write);
    addFrame(writer, 3);
    EXPECT_THAT(caughtInAnotherProcess([&] { MapStore::open(path, Access::write); }),
                FailsWith(ErrorCode::busy));
    EXPECT_THAT(caughtInAnotherProcess([&] { makeNew(path, ExistingMap::replace); }),
                FailsWith(ErrorCode::busy));
    EXPECT_EQ(framesInAnotherProcess([&] { return readMap(path).frames.size(); }), "3");
    addFrame(writer, 4);
    writer.commit();
  }
  EXPECT_FALSE(caughtInAnotherProcess([&] { MapStore::open(path, Access::write); }).code);
  EXPECT_EQ(MapStore::open(path, Access::read).load().frames.size(), 5U);
  MapStore writer = MapStore::open(path, Access::write);
  addFrame(writer, 5);
  fs::remove(path);
  EXPECT_THAT([&] { writer.commit(); }, FailsWith(ErrorCode::fileNotFound)) << "the file has gone";
}

TEST(MapStoreProcesses, KeepsAllCommittedFramesWhenTheWriterIsKilled) {
  const test::ScratchFolder folder;
  const fs::path path = folder / "map.estancia";
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    MapStore store = MapStore::create(path, wideIdentity());
    for (std::size_t i = 0;; ++i) {
      addFrame(store, i);
      if (i % 10 != 9) continue;
      store.commit();
      const std::size_t kept = i + 1;
      if (write(ends[1], &kept, sizeof kept) != static_cast<ssize_t>(sizeof kept)) _exit(1);
    }
  }
  close(ends[1]);
  std::size_t committed = 0;
  while (committed < 130)
    ASSERT_EQ(read(ends[0], &committed, sizeof committed), static_cast<ssize_t>(sizeof committed));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  for (std::size_t later = 0; read(ends[0], &later, sizeof later) > 0;) committed = later;
  close(ends[0]);

  const auto check = [&](std::size_t frames) {
    EXPECT_GE(frames, committed);
    EXPECT_EQ(frames % 10, 0U) << "part of a commit";
  };
  const TopologicalMap map = MapStore::open(path, Access::read).load();
  check(map.frames.size());
  EXPECT_EQ(map.decisions.size(), map.frames.size());
  ASSERT_EQ(map.nodes.size(), 1U);
  EXPECT_EQ(map.nodes[0].frames, map.frames.size());
  MapStore store = MapStore::open(path, Access::write);
  std::size_t descriptors = 0;
  store.forEachDescriptor(0, [&](std::size_t frame, DescriptorView descriptor) {
    ++descriptors;
    return descriptor[0] == static_cast<float>(frame % 100) / 100;
  });
  EXPECT_EQ(descriptors, map.frames.size());
  addFrame(store, map.frames.size());  // and it goes on
  store.commit();
}

TEST(MapStoreProcesses, ReadsAMapInAReadOnlyFolderButDoesNotWriteIt) {
  const test::ScratchFolder folder;
  const fs::path path = wideMap(folder, 7);
  fs::permissions(path, fs::perms(0444));
  fs::permissions(folder.path(), fs::perms(0555));
  const auto asNobody = [](const std::function<void()>& action) {
    return caughtInAnotherProcess([&] {
      dropPrivileges();
      action();
    });
  };
  EXPECT_FALSE(asNobody([&] { readMap(path); }).code);
  EXPECT_THAT(asNobody([&] { MapStore::open(path, Access::write); }), FailsWith(ErrorCode::fileUnwritable));
  EXPECT_THAT(asNobody([&] { MapStore::create(folder / "new.estancia", wideIdentity()); }),
              FailsWith(ErrorCode::fileUnwritable));
  EXPECT_THAT(asNobody([&] { MapStore::create(folder / "no/map.estancia", wideIdentity()); }),
              FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT(caughtInAnotherProcess([] { MapStore::create("/proc/map.estancia", wideIdentity()); }),
              FailsWith(ErrorCode::fileUnwritable));
  fs::permissions(path, fs::perms(0000));
  EXPECT_THAT(asNobody([&] { MapStore::open(path, Access::read); }), FailsWith(ErrorCode::fileUnreadable));
  fs::permissions(folder.path(), fs::perms(0755));
}

/// A map whose writer was killed: the last commits are still in its -wal.
fs::path killedMap(const test::ScratchFolder& folder) {
  const fs::path path = wideMap(folder, 3);
  const test::Caught end = caughtInAnotherProcess([&] {
    MapStore store = MapStore::open(path, Access::write);
    for (std::size_t i = 3; i < 200; ++i) addFrame(store, i);
    store.commit();
    kill(getpid(), SIGKILL);
  });
  EXPECT_EQ(end.message, "signal 9");
  EXPECT_TRUE(fs::exists(path.string() + "-wal"));
  return path;
}

TEST(MapStoreProcesses, ANewMapInheritsNothingOfAKilledOne) {
  const test::ScratchFolder folder;
  const fs::path path = killedMap(folder);
  makeNew(path, ExistingMap::replace);
  EXPECT_EQ(MapStore::open(path, Access::read).load().frames.size(), 1U);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);

  const test::ScratchFolder second;
  const fs::path other = killedMap(second);
  fs::remove(other);  // by hand: its -wal stays behind
  makeNew(other, ExistingMap::refuse);
  EXPECT_EQ(MapStore::open(other, Access::read).load().frames.size(), 1U);

  const test::ScratchFolder third;
  const fs::path damaged = killedMap(third);
  fs::resize_file(damaged, 2000);
  fs::create_symlink(damaged, third / "link");
  makeNew(third / "link", ExistingMap::replace);
  EXPECT_TRUE(fs::is_symlink(third / "link"));
  EXPECT_EQ(MapStore::open(damaged, Access::read).load().frames.size(), 1U);
}

/// No file of this process may grow beyond this.
void limitFiles(rlim_t bytes) {
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{bytes, bytes};
  setrlimit(RLIMIT_FSIZE, &limit);
}

TEST(MapStoreProcesses, KeepsTheLastCommitWhenTheDiskIsFull) {
  const test::ScratchFolder folder;
  const fs::path path = wideMap(folder, 10);
  const test::Caught caught = caughtInAnotherProcess([&] {
    limitFiles(2000000);
    MapStore store = MapStore::open(path, Access::write);
    for (std::size_t i = 10; i < 20; ++i) addFrame(store, i);
    store.commit();
    try {
      for (std::size_t i = 20; i < 5000; ++i) addFrame(store, i);
      store.commit();
    } catch (const Error&) {
      try {
        store.commit();
      } catch (const Error& second) {
        if (second.code() != ErrorCode::invalidState) throw;
      }
      throw;
    }
  });
  EXPECT_THAT(caught, FailsWith(ErrorCode::fileUnwritable));
  EXPECT_EQ(MapStore::open(path, Access::write).load().frames.size(), 20U);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(MapStoreProcesses, LeavesNothingWhenTheDiskIsFullAtTheFirstCommit) {
  const test::ScratchFolder folder;
  const test::Caught caught = caughtInAnotherProcess([&] {
    limitFiles(100000);
    MapStore store = MapStore::create(folder / "map.estancia", wideIdentity());
    for (std::size_t i = 0; i < 100; ++i) addFrame(store, i);
    store.commit();
  });
  EXPECT_THAT(caught, FailsWith(ErrorCode::fileUnwritable));
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace estancia
