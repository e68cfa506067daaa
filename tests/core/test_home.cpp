// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/home.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

namespace estancia {
namespace {

/// The environment as it was, afterwards.
class CacheFolder : public testing::Test {
 protected:
  CacheFolder() {
    for (const char* variable : {"ESTANCIA_CACHE", "XDG_CACHE_HOME", "HOME"}) {
      before_[variable] = environment(variable);
      unsetenv(variable);
    }
  }
  ~CacheFolder() override {
    for (const auto& [variable, value] : before_)
      value.empty() ? unsetenv(variable.c_str()) : setenv(variable.c_str(), value.c_str(), 1);
  }

 private:
  std::map<std::string, std::string> before_;
};

TEST_F(CacheFolder, IsTheUsersUnlessNamed) {
  setenv("HOME", "ana", 1);
  EXPECT_EQ(cacheFolder(), "ana/.cache/estancia");
  EXPECT_EQ(cacheFolder("labels"), "ana/.cache/estancia/labels");
  setenv("XDG_CACHE_HOME", "caches", 1);
  EXPECT_EQ(cacheFolder("labels"), "caches/estancia/labels");
  setenv("ESTANCIA_CACHE", "own", 1);
  EXPECT_EQ(cacheFolder("labels"), "own") << "the folder itself";
}

}  // namespace
}  // namespace estancia
