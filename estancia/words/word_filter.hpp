// Word filter: which words are known, in few bits each, for scripts that cannot hold them all.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace estancia {

/// A Bloom filter (Bloom 1970) of ASCII words in base64: 10 bits a word, 7 of them set, so that of words that
/// are not in it one in a hundred is taken for one that is. Bits count from the lowest one of the first byte;
/// those of a word are (a + i b) mod the number of bits, i from 0 to 6, where a and b are its FNV-1a hashes
/// of 32 bits from the bases 2166136261 and 40389 (double hashing: Kirsch & Mitzenmacher 2006).
std::string packWordFilter(const std::vector<std::string_view>& words);

}  // namespace estancia
