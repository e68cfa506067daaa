// TensorFlow.js model.json: parses it and turns every JSON failure into an Error.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "estancia/core/error.hpp"

namespace estancia::tfjs {

/// No tensor has more elements: 1 GiB in float32.
constexpr std::size_t maxElements = std::size_t{1} << 28;

/// A name of the file in a message: cut when it is absurdly long.
inline std::string inQuotes(const std::string& name) {
  return '"' + name.substr(0, 200) + '"';
}

/// Returns the result of `use` on the parsed file. Its exceptions, "has …" or "needs …", get the file's name
/// in front; a key that is missing or of another type than it asks for becomes an Error, too.
template <class Use>
auto readJson(const std::filesystem::path& path, Use use) {
  constexpr std::uintmax_t largest = 64 << 20;  // the graph alone; weights are in files of their own
  try {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error(ErrorCode::fileUnreadable, "cannot be read");
    if (std::filesystem::file_size(path) > largest)
      throw Error(ErrorCode::tooLarge, "is too large for the graph of a network");
    return use(nlohmann::json::parse(file));
  } catch (const nlohmann::json::exception& e) {
    throw Error(ErrorCode::malformedFile, fmt::format("{} is no TensorFlow.js graph model, or damaged: {}",
                                                      path.string(), std::string(e.what()).substr(0, 200)));
  } catch (const std::filesystem::filesystem_error& e) {
    throw Error(ErrorCode::fileUnreadable,
                fmt::format("{} cannot be read: {}", path.string(), e.code().message()));
  } catch (const Error& e) {
    throw Error(e.code(), fmt::format("{} {}", path.string(), e.what()));
  }
}

}  // namespace estancia::tfjs
