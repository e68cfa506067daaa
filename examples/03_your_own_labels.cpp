// The mapper takes descriptors from anywhere. Here a robot drives twice through three made-up rooms.
// SPDX-License-Identifier: Apache-2.0
#include <estancia/mapper/mapper.hpp>

#include <cstdio>
#include <exception>
#include <variant>
#include <vector>

int main() try {
  // Your labeler's answer in each room, over the words: sofa, oven, bath, lamp.
  const std::vector<estancia::LexicalDescriptor> rooms{
      {0.80F, 0.05F, 0.01F, 0.14F}, {0.04F, 0.85F, 0.01F, 0.10F}, {0.02F, 0.03F, 0.90F, 0.05F}};

  estancia::MapperOptions options;
  options.distance = "hellinger";  // four words are too few for the run to learn their scales
  options.tauJoin = options.tauRevisit = 0.3;
  estancia::Mapper mapper(4, options);
  for (int step = 0; step < 60; ++step) mapper.add(rooms[static_cast<std::size_t>(step / 10 % 3)]);
  mapper.finish();

  for (const auto& event : mapper.takeChanges().events)
    if (const auto* decision = std::get_if<estancia::Decision>(&event))
      if (decision->kind != estancia::DecisionKind::join)
        std::printf("frame %2zu: %s, place %d\n", decision->frame, estancia::toString(decision->kind).c_str(),
                    decision->node);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
