// FailsWith: a matcher for errors by their code and by the facts that they name, not by their wording.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "estancia/core/error.hpp"
#include "support/support.hpp"

namespace estancia::test {

/// What a piece of work threw: no code when it threw nothing.
struct Caught {
  std::optional<ErrorCode> code;
  std::string message;
};
std::ostream& operator<<(std::ostream& out, const Caught& caught);

/// Runs `work`. Expects that a message has one line.
Caught caught(const std::function<void()>& work);
/// The failure that a command printed on stderr: the code stands in brackets at the end of its one line
/// `error: … [code]`.
Caught caught(const CommandResult& result);

/// Matches a callable that throws Error, a Caught, or the result of a command that failed with exit code 2 (1
/// for noAnswer, 130 for interrupted): with this code, and a message that holds each of `facts`. Facts are
/// files, lines, values and options of the input, never prose, which may be reworded at any time.
class FailsWithMatcher {
 public:
  using is_gtest_matcher = void;
  FailsWithMatcher(ErrorCode code, std::vector<std::string> facts) : code_(code), facts_(std::move(facts)) {}

  template <class Subject>
  bool MatchAndExplain(const Subject& subject, std::ostream* out) const {
    if constexpr (std::is_same_v<Subject, Caught>)
      return matches(subject, out);
    else
      return matches(caught(subject), out);
  }
  void DescribeTo(std::ostream* out) const;
  void DescribeNegationTo(std::ostream* out) const;

 private:
  bool matches(const Caught& caught, std::ostream* out) const;

  ErrorCode code_;
  std::vector<std::string> facts_;
};

template <class... Facts>
FailsWithMatcher FailsWith(ErrorCode code, Facts&&... facts) {
  return {code, {std::string(std::forward<Facts>(facts))...}};
}

}  // namespace estancia::test
