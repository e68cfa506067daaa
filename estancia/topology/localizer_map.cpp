#include "estancia/topology/localizer_map.hpp"

#include <algorithm>
#include <utility>

#include "estancia/topology/mapper_impl.hpp"
#include "estancia/topology/session_impl.hpp"

namespace estancia {

LocalizerMap localizerMap(const MapStore& store, const NodeBank& bank, std::size_t maxImages) {
  TopologicalMap map = store.load();
  const std::size_t frames = map.frames.size();
  const std::size_t stride = std::max<std::size_t>(1, (frames + maxImages - 1) / maxImages);
  DescriptorMatrix images(map.vocabulary.size());
  images.reserve((frames + stride - 1) / stride);
  for (std::size_t frame = 0; frame < frames; frame += stride) images.append(store.descriptor(frame));
  return {std::move(map), bank, std::move(images), stride};
}

LocalizerMap readLocalizerMap(const std::filesystem::path& path, std::size_t maxImages) {
  MapStore store = MapStore::open(path, MapStore::Access::read);
  store.beginReading();  // map and mapper must be of one moment: a run that goes on may write in between
  return localizerMap(store, restoreMapper(store).impl().bank, maxImages);
}

}  // namespace estancia
