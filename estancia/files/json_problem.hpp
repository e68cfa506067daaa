// JSON problem: what is wrong with JSON, in words of our own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <string>

namespace estancia::io {

/// Message for an exception of nlohmann::json, without its numbers and C++ names, such as "no JSON at line 1,
/// column 41", "\"id\" is missing" or "a value is of another type".
std::string jsonProblem(const std::exception& problem);

}  // namespace estancia::io
