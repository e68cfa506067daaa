// Commands with some more arguments, and what they print as JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "support/support.hpp"

namespace estancia::test {

inline CommandResult run(std::vector<std::string> arguments, const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run(arguments);
}

/// Expects that the command has succeeded.
inline nlohmann::json jsonOf(const CommandResult& result) {
  EXPECT_EQ(result.exitCode, 0) << result.err;
  return nlohmann::json::parse(result.out);
}

/// One a line.
inline std::vector<nlohmann::json> jsonLinesOf(const CommandResult& result) {
  EXPECT_EQ(result.exitCode, 0) << result.err;
  std::vector<nlohmann::json> all;
  std::istringstream in(result.out);
  for (std::string line; std::getline(in, line);) all.push_back(nlohmann::json::parse(line));
  return all;
}

}  // namespace estancia::test
