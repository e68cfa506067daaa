// SPDX-License-Identifier: Apache-2.0
#include "estancia/fetch/archive.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

FUZZ_TARGET(fetch, archive) {
  extractMember(inputFile("input.archive", bytes), "labels.txt", folder() / "labels.txt", 1 << 20);
}

}  // namespace estancia::fuzz
