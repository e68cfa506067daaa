#include "estancia/topology/map_recording.hpp"

#include <fmt/format.h>

#include "estancia/core/error.hpp"
#include "estancia/topology/store.hpp"

namespace estancia {

DescriptorSequence readMapDescriptors(const std::filesystem::path& file) {
  MapStore store = MapStore::open(file, MapStore::Access::read);
  store.beginReading();
  const TopologicalMap map = store.load();
  DescriptorSequence recording{map.vocabulary, map.model, {}, DescriptorMatrix(map.vocabulary.size())};
  recording.frames.assign(map.frames.begin(), map.frames.end());
  recording.descriptors.reserve(map.frames.size());
  store.forEachDescriptor(0, [&](std::size_t, DescriptorView descriptor) {
    recording.descriptors.append(descriptor);
    return true;
  });
  store.endReading();
  if (recording.descriptors.size() != recording.frames.size())
    throw Error(fmt::format("{}: it has {} frames but the words of {}; map the sequence again", file.string(),
                            recording.frames.size(), recording.descriptors.size()));
  return recording;
}

}  // namespace estancia
