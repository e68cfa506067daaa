// Two networks in conjunction, and nothing labeled twice: images → a label file that every command takes.
//   04_several_models IMAGES OUTPUT.labels [MODEL+MODEL…]
// SPDX-License-Identifier: Apache-2.0
#include <estancia/label/label_stream.hpp>
#include <estancia/labelers/model.hpp>
#include <estancia/readers/open_sequence.hpp>
#include <estancia/sequences/descriptor_sequence.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc < 3) return std::fputs("usage: 04_several_models IMAGES OUTPUT.labels [MODEL+MODEL]\n", stderr), 2;
  const auto images = estancia::openSequence(argv[1]);
  const auto labeler = estancia::loadModel(argc > 3 ? argv[3] : "inception-v3+coco-ssd");

  estancia::LabelCache cache;  // what an earlier run has labeled is read here
  estancia::LabelStreamOptions options;
  options.cache = &cache;
  const estancia::DescriptorSequence words = estancia::record(*images, *labeler, options);

  for (const estancia::LabelPart& part : words.vocabulary.layout().parts)
    std::printf("%zu words that weigh %.1f\n", part.size, static_cast<double>(part.weight));
  estancia::writeDescriptors(words, argv[2]);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
