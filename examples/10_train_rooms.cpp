// Which room is this? Learned from images whose rooms are known (rooms.csv beside them, or a folder a
// room), then predicted for every place of a map, which can be asked for a room from then on.
//   10_train_rooms IMAGES MAP [ROOM]
// SPDX-License-Identifier: Apache-2.0
#include <estancia/classify/predict_rooms.hpp>
#include <estancia/describe/features.hpp>
#include <estancia/map_file/map.hpp>
#include <estancia/query/ask.hpp>
#include <estancia/readers/open_sequence.hpp>
#include <estancia/sequences/descriptor_sequence.hpp>
#include <estancia/session/session.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc < 3) return std::fputs("usage: 10_train_rooms IMAGES MAP [ROOM]\n", stderr), 2;
  estancia::LabelCache cache;
  estancia::DescribeOptions describing;
  describing.cache = &cache;
  const auto images = estancia::openSequence(argv[1]);
  const auto known = estancia::describeSequence(*images, "inception-v3", describing);
  const auto classifier = estancia::trainRoomClassifier(known);
  std::printf("%s\n", classifier.choice().c_str());

  // A robot predicts the room of its current image; here that is the first of the images.
  for (const auto& [room, p] : classifier.predict(images->image(0)))
    std::printf("%s %.1f %%\n", room.c_str(), 100 * p);

  // The labels of the map are enough; nothing is labeled again.
  const auto words = estancia::readMapDescriptors(argv[2]);
  const auto features = estancia::featuresFor(classifier, words, nullptr, describing);
  estancia::writeRoomPredictions(estancia::predictRooms(classifier, features, words.frames), argv[2]);
  const auto map = estancia::readMap(argv[2]);
  for (const auto& place : estancia::ask(map, argc > 3 ? argv[3] : classifier.rooms().front()).places)
    std::printf("place %d: %.1f %%\n", place.node, 100 * place.probability);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
