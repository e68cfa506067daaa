// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_filter.hpp"

#include <cstdint>

#include "estancia/core/base64.hpp"

namespace estancia {
namespace {

constexpr std::uint64_t bitsSet = 7;

/// FNV-1a (Fowler, Noll, Vo) from a basis of one's choice.
std::uint32_t hashOf(std::string_view word, std::uint32_t basis) {
  for (const char c : word) basis = (basis ^ static_cast<unsigned char>(c)) * 16777619U;
  return basis;
}

}  // namespace

std::string packWordFilter(const std::vector<std::string_view>& words) {
  std::string bytes((10 * words.size() + 7) / 8, '\0');
  for (const std::string_view word : words) {
    const std::uint64_t a = hashOf(word, 2166136261U), b = hashOf(word, 40389U);
    for (std::uint64_t i = 0; i < bitsSet; ++i) {
      const std::uint64_t at = (a + i * b) % (8 * bytes.size());
      bytes[at / 8] = static_cast<char>(static_cast<unsigned char>(bytes[at / 8]) | (1U << (at % 8)));
    }
  }
  return toBase64(bytes);
}

}  // namespace estancia
