// Names the room of an image by a room classifier, which `estancia classify train` or 10_train_rooms has
// made.
//   06_name_a_room CLASSIFIER IMAGE
// SPDX-License-Identifier: Apache-2.0
#include <estancia/estancia.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc != 3) return std::fputs("usage: 06_name_a_room CLASSIFIER IMAGE\n", stderr), 2;
  const auto rooms = estancia::readRoomClassifier(argv[1]);
  for (const auto& [room, probability] : rooms.predict(estancia::readImage(argv[2])))
    std::printf("%s %.1f %%\n", room.c_str(), 100 * probability);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
