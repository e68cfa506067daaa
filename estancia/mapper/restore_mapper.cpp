// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/restore_mapper.hpp"

#include <string>

#include "estancia/mapper/mapper_impl.hpp"

namespace estancia {

Mapper restoreMapper(const MapStore& store) {
  return restoreMapper(store, store.path());
}

Mapper restoreMapper(const MapStore& store, const std::filesystem::path& file) try {
  const auto state = store.findState(mapperStateKey);
  if (!state)
    throw Error(ErrorCode::corruptFile, "the map has no saved mapper state; map the sequence again");
  const Vocabulary& vocabulary = store.identity().vocabulary;
  const auto prior = store.findState(mapperPriorKey);  // none: of an older program's map
  return Mapper::Impl::restore(
      vocabulary.layout(), settingsFromJson(store.identity().settings),
      {prior ? LabelPrior::fromBytes(*prior, vocabulary.size()) : unknownLabelsPrior(vocabulary.size()),
       *state, store.nodeStates(), store.findState(mapperViewsKey).value_or(""), store.transitions(),
       [&store](std::size_t frame) { return store.descriptor(frame); },
       [&store](std::size_t frame) { return store.pose(frame); }});
} catch (const Error& e) {
  const std::string path = store.path().string(), message = e.what();
  const bool isNamed = message.starts_with(path);  // by the store; what is read from memory knows no file
  throw Error(e.code(), file.string() + (isNamed ? message.substr(path.size()) : ": " + message));
}

}  // namespace estancia
