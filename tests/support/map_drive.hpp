// A drive that is mapped without the command: its places and its layers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/world/world_mapper.hpp"

namespace estancia::test {

/// Maps the drive's frames up to `end`, beginning or going on. `labeled`: their words.
inline void mapUpTo(const Sequence& drive, const DescriptorSequence& labeled, std::size_t end,
                    const std::filesystem::path& file, Labeler* labeler = nullptr) {
  MappingSession session =
      std::filesystem::exists(file)
          ? MappingSession::resume(file, labeled.vocabulary, labeled.model)
          : MappingSession::create(file, labeled.vocabulary, labeled.model, MapperOptions{});
  WorldMapper world(session, labeler);
  for (std::size_t i = session.frames(); i < end; ++i) {
    world.observe(drive.frame(i), labeled.descriptors.row(i), drive.image(i), drive.depth(i),
                  *drive.intrinsics());
    session.add(drive.frame(i), labeled.descriptors.row(i));
  }
  session.finish();
  world.finish();
}

}  // namespace estancia::test
