// A camera, or a recording that is played: prints for each frame where the robot is, while the map grows.
//   11_live SOURCE MAP.estancia
// SPDX-License-Identifier: Apache-2.0
#include <estancia/estancia.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc != 3) return std::fputs("usage: 11_live SOURCE MAP.estancia\n", stderr), 2;
  const auto labeler = estancia::loadModel();
  estancia::LiveLoop live(estancia::makeFrameSource(argv[1]), *labeler, argv[2]);
  estancia::catchInterrupts();  // Ctrl-C ends it, and the map is whole
  live.run([](const estancia::LiveStatus& now) {
    std::printf("%s: place %d, %s, %.0f ms\n", now.frame.c_str(), now.places.front().node,
                now.words.front().label.c_str(), now.latency);
  });
  std::printf("map of %zu places\n", live.world()->places.nodes.size());
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
