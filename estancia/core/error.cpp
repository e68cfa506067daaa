// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/error.hpp"

#include <array>
#include <utility>

namespace estancia {
namespace {

// In the order of ErrorCode.
constexpr std::array<std::string_view, 23> kNames{
    "invalid-option", "unknown-name",   "invalid-input",  "mismatch",         "insufficient-data",
    "too-large",      "file-not-found", "file-exists",    "file-unreadable",  "file-unwritable",
    "malformed-file", "truncated-file", "corrupt-file",   "unsupported-file", "unsafe-path",
    "busy",           "network",        "server-failure", "labeler-failure",  "missing-dependency",
    "no-answer",      "interrupted",    "invalid-state"};

}  // namespace

std::string_view nameOf(ErrorCode code) {
  return kNames.at(static_cast<std::size_t>(code));
}

std::optional<ErrorCode> findErrorCode(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (kNames[i] == name) return static_cast<ErrorCode>(i);
  return {};
}

}  // namespace estancia
