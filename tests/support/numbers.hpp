// The numbers in a sentence, so that tests check what it says and not how.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <regex>
#include <string>
#include <vector>

namespace estancia::test {

inline std::vector<double> numbersIn(const std::string& sentence) {
  static const std::regex number(R"(-?\d+(\.\d+)?(e[+-]?\d+)?)");
  std::vector<double> numbers;
  for (std::sregex_iterator i(sentence.begin(), sentence.end(), number), end; i != end; ++i)
    numbers.push_back(std::stod(i->str()));
  return numbers;
}

}  // namespace estancia::test
