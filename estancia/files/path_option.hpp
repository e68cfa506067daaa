// Path options: files and lists of names as the text of an Option.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"

namespace estancia::io {

inline Option::Text asText(std::filesystem::path& path) {
  return {[&path] { return path.string(); }, [&path](const std::string& text) { path = text; }};
}

/// Separated by commas.
inline Option::Text asText(std::vector<std::string>& names) {
  return {[&names] { return fmt::format("{}", fmt::join(names, ",")); },
          [&names](const std::string& text) {
            names.clear();
            for (std::size_t begin = 0; begin < text.size();) {
              const std::size_t end = std::min(text.find(',', begin), text.size());
              names.push_back(text.substr(begin, end - begin));
              begin = end + 1;
            }
          }};
}

}  // namespace estancia::io
