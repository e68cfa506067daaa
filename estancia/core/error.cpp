// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/error.hpp"

#include <array>
#include "estancia/core/printable.hpp"

namespace estancia {
namespace {

// In the order of ErrorCode.
constexpr std::array<std::string_view, 23> codeNames{
    "invalid-option", "unknown-name",   "invalid-input",  "mismatch",         "insufficient-data",
    "too-large",      "file-not-found", "file-exists",    "file-unreadable",  "file-unwritable",
    "malformed-file", "truncated-file", "corrupt-file",   "unsupported-file", "unsafe-path",
    "busy",           "network",        "server-failure", "labeler-failure",  "missing-dependency",
    "no-answer",      "interrupted",    "invalid-state"};

/// Shortens a long sentence: keeps its beginning (what is wrong) and its end (what to do).
std::string withoutMiddle(const std::string& sentence) {
  constexpr std::size_t longest = 2000, begin = 1400, end = 500;
  if (sentence.size() <= longest) return sentence;
  const auto continues = [&](std::size_t at) { return (sentence[at] & 0xC0) == 0x80; };
  std::size_t head = begin, tail = sentence.size() - end;
  while (continues(head)) --head;
  while (tail < sentence.size() && continues(tail)) ++tail;
  return sentence.substr(0, head) + " … " + sentence.substr(tail);
}

}  // namespace

Error::Error(ErrorCode code, std::string_view sentence)
    : std::runtime_error(withoutMiddle(printable(sentence))), code_(code) {}

std::string_view nameOf(ErrorCode code) {
  return codeNames.at(static_cast<std::size_t>(code));
}

std::optional<ErrorCode> findErrorCode(std::string_view name) {
  for (std::size_t i = 0; i < codeNames.size(); ++i)
    if (codeNames[i] == name) return static_cast<ErrorCode>(i);
  return {};
}

}  // namespace estancia
