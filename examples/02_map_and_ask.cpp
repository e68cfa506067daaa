// A folder of images becomes a map, and the map answers a question.
//   02_map_and_ask FOLDER MAP.estancia WORD
#include <estancia/io/sequence.hpp>
#include <estancia/label/label_stream.hpp>
#include <estancia/label/model.hpp>
#include <estancia/topology/ask.hpp>
#include <estancia/topology/session.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc != 4) return std::fputs("usage: 02_map_and_ask FOLDER MAP.estancia WORD\n", stderr), 2;
  const auto sequence = estancia::openSequence(argv[1]);
  const auto labeler = estancia::loadModel();

  auto session = estancia::MappingSession::create(argv[2], labeler->vocabulary(), labeler->identity(), {});
  estancia::LabelStream stream(*sequence, *labeler);
  while (const auto frame = stream.next())
    if (frame->labeled()) session.add(sequence->frame(frame->index), frame->descriptor);
  session.finish();

  const auto map = estancia::readMap(argv[2]);
  for (const auto& place : estancia::ask(map, argv[3]).places)
    std::printf("place %d: %.1f %%\n", place.node, 100 * place.probability);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
