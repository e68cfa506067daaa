// The areas of a run, named by their words: images → zones → where "microwave" is likelier than elsewhere.
//   05_zones IMAGES OUTPUT.zones [WORD]
// SPDX-License-Identifier: Apache-2.0
#include <estancia/label/label_stream.hpp>
#include <estancia/labelers/model.hpp>
#include <estancia/readers/open_sequence.hpp>
#include <estancia/words/installed_words.hpp>
#include <estancia/words/label_choice.hpp>
#include <estancia/zones/zones.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc < 3) return std::fputs("usage: 05_zones IMAGES OUTPUT.zones [WORD]\n", stderr), 2;
  const auto images = estancia::openSequence(argv[1]);
  const auto labeler = estancia::loadModel("inception-v3+coco-ssd");
  estancia::LabelCache cache;
  estancia::LabelStreamOptions remembering;
  remembering.cache = &cache;
  const estancia::DescriptorSequence words = estancia::record(*images, *labeler, remembering);

  const estancia::Zones zones = estancia::findZones(words);
  std::printf("%zu zones: %s\n", zones.zones.size(), zones.cutReason.c_str());
  for (const estancia::Zone& zone : zones.zones)
    std::printf("zone %d: %zu images, %s\n", zone.id, zone.images.size(), zone.name.c_str());

  const auto everywhere = estancia::runMean(zones);
  const char* asked = argc > 3 ? argv[3] : "";
  for (const auto& [label, probability, why] :
       estancia::chooseLabels(zones.vocabulary, asked, estancia::installedWordGraph).labels)
    for (const estancia::Zone& zone : zones.zones)
      if (zone.mean[label] > everywhere[label])
        std::printf("%s: %.1f %% in zone %d %s\n", zones.vocabulary[label].c_str(),
                    100 * static_cast<double>(zone.mean[label]), zone.id, why.c_str());
  estancia::writeZones(zones, argv[2]);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
