// SPDX-License-Identifier: Apache-2.0
#include "support/errors.hpp"

#include <gtest/gtest.h>

#include <ostream>

namespace estancia::test {

std::ostream& operator<<(std::ostream& out, const Caught& caught) {
  if (!caught.code) return out << "no error";
  return out << "[" << nameOf(*caught.code) << "] " << caught.message;
}

Caught caught(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << "more than one line: " << e.what();
    return {e.code(), e.what()};
  }
  return {};
}

Caught caught(const CommandResult& result) {
  const std::size_t start = result.err.rfind("error: ");
  if (result.exitCode == 0 || start == std::string::npos) return {};
  std::string line = result.err.substr(start, result.err.find('\n', start) - start);
  const std::size_t bracket = line.rfind(" [");
  if (bracket == std::string::npos || line.back() != ']') return {};
  const auto code = findErrorCode(std::string_view(line).substr(bracket + 2, line.size() - bracket - 3));
  const int expected = code == ErrorCode::noAnswer ? 1 : code == ErrorCode::interrupted ? 130 : 2;
  EXPECT_EQ(result.exitCode, expected) << line;
  return {code, line.substr(0, bracket)};
}

bool FailsWithMatcher::matches(const Caught& caught, std::ostream* out) const {
  if (out != nullptr) *out << "which gives " << caught;
  if (caught.code != code_) return false;
  for (const std::string& fact : facts_)
    if (caught.message.find(fact) == std::string::npos) {
      if (out != nullptr) *out << ", without \"" << fact << "\"";
      return false;
    }
  return true;
}

void FailsWithMatcher::DescribeTo(std::ostream* out) const {
  *out << "fails with [" << nameOf(code_) << "]";
  for (const std::string& fact : facts_) *out << " naming \"" << fact << "\"";
}

void FailsWithMatcher::DescribeNegationTo(std::ostream* out) const {
  *out << "does not do this: ";
  DescribeTo(out);
}

}  // namespace estancia::test
