// Numbers of tests: the numbers in a sentence, whatever its words; the bytes of one; none.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <regex>
#include <string>
#include <vector>

namespace estancia::test {

constexpr float quietNan = std::numeric_limits<float>::quiet_NaN();

/// Bytes in the machine's order, or swapped.
template <class T>
std::string bytesOf(T value, bool swapped = false) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (swapped) std::ranges::reverse(bytes);
  return bytes;
}

inline std::vector<double> numbersIn(const std::string& sentence) {
  static const std::regex number(R"(-?\d+(\.\d+)?(e[+-]?\d+)?)");
  std::vector<double> numbers;
  for (std::sregex_iterator i(sentence.begin(), sentence.end(), number), end; i != end; ++i)
    numbers.push_back(std::stod(i->str()));
  return numbers;
}

}  // namespace estancia::test
