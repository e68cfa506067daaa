// Maps a camera's frames while they come, then asks the map: a device, a video, or images (images/%04d.jpg).
//   02_map_live MAP.estancia CAMERA WORD
// SPDX-License-Identifier: Apache-2.0
#include <estancia/estancia.hpp>

#include <cstdio>
#include <exception>
#include <opencv2/videoio.hpp>

int main(int argc, char** argv) try {
  if (argc != 4) return std::fputs("usage: 02_map_live MAP.estancia CAMERA WORD\n", stderr), 2;
  const auto labeler = estancia::loadModel();
  estancia::MappingSession session(argv[1], *labeler);  // creates the map, or continues it
  cv::VideoCapture camera(argv[2]);
  for (cv::Mat image; camera.read(image);) session.add(image);

  for (const auto& place : estancia::ask(session.map(), argv[3]).places)
    std::printf("place %d: %.1f %%\n", place.node, 100 * place.probability);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
