// libFuzzer's entry points: one target of this program, the one that ESTANCIA_FUZZ_TARGET names.
// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "fuzz/fuzz_target.hpp"

namespace {

std::optional<estancia::fuzz::Target> chosen;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* name = std::getenv("ESTANCIA_FUZZ_TARGET");
  for (const estancia::fuzz::Target& target : estancia::fuzz::targets())
    if (name != nullptr && target.name == name) chosen = target;
  if (chosen) return 0;
  std::fprintf(stderr, "ESTANCIA_FUZZ_TARGET must name one of:\n");
  for (const estancia::fuzz::Target& target : estancia::fuzz::targets())
    std::fprintf(stderr, "%s\n", target.name.c_str());
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  estancia::fuzz::run(*chosen, {reinterpret_cast<const char*>(bytes), count});
  return 0;
}
