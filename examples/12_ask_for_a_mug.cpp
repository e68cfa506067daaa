// Maps a drive with depth, then asks the map for a thing, and for the way to it from the first place.
//   12_ask_for_a_mug DRIVE MAP.estancia WORD
// SPDX-License-Identifier: Apache-2.0
#include <estancia/estancia.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc != 4) return std::fputs("usage: 12_ask_for_a_mug DRIVE MAP.estancia WORD\n", stderr), 2;
  const auto labeler = estancia::loadModel();
  estancia::mapSequence(*estancia::openSequence(argv[1]), *labeler, argv[2]);

  const auto world = estancia::readWorld(argv[2]);  // places, areas and objects
  for (const auto& mug : estancia::askWorld(world, argv[3]).objects)
    std::printf("object %d: %.1f %%\n", mug.object, 100 * mug.probability);
  const auto way = estancia::routeInWorld(world, 0, argv[3]);
  if (way.driven)
    for (const auto& at : way.driven->points) std::printf("-> (%.2f, %.2f) m\n", at.x, at.y);
  else
    for (const int place : way.route.nodes) std::printf("-> place %d\n", place);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
