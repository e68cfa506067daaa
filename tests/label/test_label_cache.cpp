// What was labeled once is not labeled again; what is damaged is.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "estancia/label/label_stream.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

namespace fs = std::filesystem;

fs::path onlyFile(const fs::path& folder) {
  fs::path found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    EXPECT_TRUE(found.empty()) << "one model, one file";
    found = entry.path();
  }
  return found;
}

class Cache : public testing::Test {
 protected:
  test::ScratchFolder scratch_;
  fs::path folder_ = scratch_ / "labels";
};

TEST_F(Cache, RemembersBetweenRunsByModelAndImage) {
  {
    LabelCache cache(folder_, 1 << 20);
    EXPECT_FALSE(cache.find("net", "cat"));
    EXPECT_FALSE(fs::exists(folder_)) << "looking leaves nothing behind";
    cache.put("net", "cat", "meow");
    cache.put("net", "dog", "");
    cache.put("other net", "cat", "miaow");
    EXPECT_EQ(cache.find("net", "cat"), "meow") << "at once";
  }
  LabelCache cache(folder_, 1 << 20);
  EXPECT_EQ(cache.find("net", "cat"), "meow");
  EXPECT_EQ(cache.find("net", "dog"), "");
  EXPECT_EQ(cache.find("other net", "cat"), "miaow");
  EXPECT_FALSE(cache.find("other net", "dog"));
  EXPECT_EQ(cache.problem(), "");
}

TEST_F(Cache, LosesOnlyWhatIsCutOff) {
  LabelCache(folder_, 1 << 20).put("net", "cat", "meow");
  LabelCache(folder_, 1 << 20).put("net", "dog", "woof");
  const fs::path file = onlyFile(folder_);
  const auto whole = fs::file_size(file);
  for (std::uintmax_t size = 0; size < whole; ++size) {
    const fs::path other = scratch_ / "cut";
    fs::remove_all(other);
    fs::create_directories(other);
    fs::copy_file(file, other / file.filename());
    fs::resize_file(other / file.filename(), size);
    {
      LabelCache cache(other, 1 << 20);
      EXPECT_FALSE(cache.find("net", "dog")) << size;
      cache.put("net", "cow", "moo");
    }
    LabelCache cache(other, 1 << 20);
    EXPECT_EQ(cache.find("net", "cow"), "moo") << "appended after what was left of " << size << " bytes";
    EXPECT_EQ(cache.find("net", "cat").has_value(), size >= whole - 44) << size;
  }
}

TEST_F(Cache, StaysWithinItsLimitAndKeepsTheNewest) {
  constexpr std::uint64_t limit = 100'000;
  LabelCache cache(folder_, limit);
  const std::string value(1000, 'v');
  for (int i = 0; i < 1000; ++i) cache.put("net", std::to_string(i), value);
  std::uint64_t total = 0;
  for (const auto& use : cache.usage()) total += use.bytes;
  EXPECT_LE(total, limit * 1.06);
  EXPECT_GE(total, limit * 0.4);
  EXPECT_EQ(cache.find("net", "999"), value);
  EXPECT_FALSE(cache.find("net", "0"));
}

TEST_F(Cache, TheModelUsedLongestAgoGoesFirst) {
  {
    LabelCache cache(folder_, 1 << 20);
    for (int i = 0; i < 40; ++i) cache.put("old", std::to_string(i), std::string(1000, 'o'));
  }
  fs::last_write_time(onlyFile(folder_), fs::file_time_type::clock::now() - std::chrono::hours(1));
  LabelCache cache(folder_, 60'000);
  for (int i = 0; i < 50; ++i) cache.put("new", std::to_string(i), std::string(1000, 'n'));
  ASSERT_EQ(cache.usage().size(), 1U);
  EXPECT_EQ(cache.usage()[0].model, "new");
  EXPECT_EQ(cache.usage()[0].images, 50U);
}

TEST_F(Cache, SeveralWritersDoNotMixTheirRecords) {
  std::vector<std::thread> writers;
  for (int w = 0; w < 4; ++w)
    writers.emplace_back([this, w] {
      LabelCache cache(folder_, 1 << 24);
      for (int i = 0; i < 200; ++i) {
        const std::string name = std::to_string(w) + "/" + std::to_string(i);
        cache.put("net", name, std::string(static_cast<std::size_t>(i), 'x') + name);
      }
    });
  for (auto& writer : writers) writer.join();
  LabelCache cache(folder_, 1 << 24);
  for (int w = 0; w < 4; ++w)
    for (int i = 0; i < 200; ++i) {
      const std::string name = std::to_string(w) + "/" + std::to_string(i);
      EXPECT_EQ(cache.find("net", name), std::string(static_cast<std::size_t>(i), 'x') + name);
    }
}

TEST_F(Cache, GoesOnWhenAnotherProcessClearsIt) {
  LabelCache writer(folder_, 1 << 20), other(folder_, 1 << 20);
  writer.put("net", "cat", "meow");
  other.clear();
  writer.put("net", "dog", "woof");
  EXPECT_EQ(LabelCache(folder_, 1 << 20).find("net", "dog"), "woof");
  EXPECT_FALSE(LabelCache(folder_, 1 << 20).find("net", "cat"));
  EXPECT_EQ(writer.problem(), "");
}

TEST_F(Cache, ThatCannotBeWrittenSaysSoOnceAndGoesOn) {
  test::writeFile(scratch_ / "file", "in the way");
  LabelCache cache(scratch_ / "file/labels", 1 << 20);
  cache.put("net", "cat", "meow");
  EXPECT_NE(cache.problem().find("ESTANCIA_CACHE"), std::string::npos);
  EXPECT_FALSE(cache.find("net", "cat"));
  LabelCache(folder_, 1 << 20).put("net", "cat", "meow");
  const fs::path log = onlyFile(folder_);
  fs::remove(log);
  fs::create_directory(log);
  LabelCache blocked(folder_, 1 << 20);
  for (const char* image : {"cat", "dog"}) blocked.put("net", image, "meow");
  EXPECT_NE(blocked.problem(), "");
  EXPECT_FALSE(blocked.find("net", "cat"));
}

TEST_F(Cache, OnAFullDiskKeepsWhatItHas) {
  LabelCache(folder_, 1 << 20).put("net", "cat", "meow");
  const std::uintmax_t size = fs::file_size(onlyFile(folder_));
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  for (const auto& [model, most] :
       {std::pair{"net", size + 10}, {"net", size}, {"other", std::uintmax_t{9}}}) {
    const rlimit full{most, before.rlim_max};  // for this process the same as a full disk
    LabelCache cache(folder_, 1 << 20);
    setrlimit(RLIMIT_FSIZE, &full);
    cache.put(model, "dog", std::string(100, 'w'));
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_NE(cache.problem(), "") << model;
    EXPECT_FALSE(cache.find(model, "dog")) << model;
  }
  EXPECT_EQ(LabelCache(folder_, 1 << 20).find("net", "cat"), "meow");
}

TEST_F(Cache, IsClearedAndCounted) {
  LabelCache cache(folder_, 1 << 20);
  cache.put("net", "cat", "meow");
  const auto usage = cache.usage();
  ASSERT_EQ(usage.size(), 1U);
  EXPECT_EQ(usage[0].model, "net");
  EXPECT_EQ(usage[0].images, 1U);
  EXPECT_EQ(usage[0].bytes, fs::file_size(onlyFile(folder_)));
  EXPECT_EQ(cache.clear(), usage[0].bytes);
  EXPECT_TRUE(cache.usage().empty());
  EXPECT_FALSE(cache.find("net", "cat"));
}

TEST(CacheLimit, IsMegabytesFromTheEnvironment) {
  setenv("ESTANCIA_CACHE_MB", "12.5", 1);
  EXPECT_EQ(LabelCache::defaultLimit(), 12'500'000U);
  setenv("ESTANCIA_CACHE_MB", "much", 1);
  EXPECT_THAT([] { LabelCache::defaultLimit(); }, FailsWith(ErrorCode::invalidOption));
  unsetenv("ESTANCIA_CACHE_MB");
}

TEST_F(Cache, DoesNotBelieveDamagedRecordsAndStartsAnewWhereAFileIsNotItsOwn) {
  LabelCache(folder_, 1 << 20).put("net", "cat", std::string(100, 'm'));
  const fs::path file = onlyFile(folder_);
  const std::string sound = test::readFile(file);
  for (std::size_t at = 0; at < sound.size(); ++at) {
    std::string damaged = sound;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    test::writeFile(file, damaged);
    LabelCache cache(folder_, 1 << 20);
    const auto found = cache.find("net", "cat");
    EXPECT_TRUE(!found || *found == std::string(100, 'm')) << "byte " << at;
  }
  LabelCache(folder_, 1 << 20).put("net", "cat", "meow");
  test::writeFile(onlyFile(folder_), "something else altogether, long enough to be a head");
  LabelCache cache(folder_, 1 << 20);
  EXPECT_FALSE(cache.find("net", "cat"));
  cache.put("net", "cat", "meow");
  EXPECT_EQ(cache.find("net", "cat"), "meow");
}

}  // namespace
}  // namespace estancia
