// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/wordnet.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

FUZZ_TARGET(words, wordnet) {
  const auto files = parts(bytes, 12);
  std::size_t next = 0;
  for (const char* kind : {"index.", "data."})
    for (const char* pos : {"noun", "verb", "adj", "adv"}) inputFile(std::string(kind) + pos, files[next++]);
  for (const char* pos : {"noun", "verb", "adj", "adv"}) inputFile(pos + std::string(".exc"), files[next++]);
  readWordNet(folder());
}

}  // namespace estancia::fuzz
