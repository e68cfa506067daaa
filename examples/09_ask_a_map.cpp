// Reads a map file and asks it: which places show something, and how to get there from place 0?
//   09_ask_a_map MAP.estancia WORD
// SPDX-License-Identifier: Apache-2.0
#include <estancia/estancia.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc != 3) return std::fputs("usage: 09_ask_a_map MAP.estancia WORD\n", stderr), 2;
  const auto map = estancia::readMap(argv[1]);
  for (const auto& place : estancia::ask(map, argv[2]).places)
    std::printf("place %d: %.1f %%\n", place.node, 100 * place.probability);
  for (const int node : estancia::routeToWords(map, 0, argv[2]).route.nodes) std::printf("-> %d\n", node);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
