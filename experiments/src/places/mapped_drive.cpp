// SPDX-License-Identifier: Apache-2.0
#include "experiments/src/places/mapped_drive.hpp"

#include <numeric>
#include <utility>
#include <vector>

#include "estancia/topology/localizer.hpp"
#include "estancia/topology/session.hpp"

namespace estancia::experiments {

ScratchMap::ScratchMap(const DescriptorSequence& recording, std::filesystem::path path)
    : ScratchFile(std::move(path)) {
  auto session =
      MappingSession::create(this->path(), recording.vocabulary, recording.model, {}, ExistingMap::replace);
  for (std::size_t i = 0; i < recording.frames.size(); ++i)
    session.add(recording.frames[i], recording.descriptors.row(i));
  session.finish();
}

LocalizationAccuracy findDrive(const DescriptorSequence& queries, std::shared_ptr<const LocalizerMap> map,
                               std::size_t lookahead, const AdmissibleImages& truth) {
  LocalizerOptions options;
  options.lookahead = lookahead;
  Localizer localizer(std::move(map), options);
  std::vector<Localization> answers;
  const auto give = [&](const std::vector<Localization>& some) {
    answers.insert(answers.end(), some.begin(), some.end());
  };
  for (std::size_t i = 0; i < queries.frames.size(); ++i)
    give(localizer.add(queries.descriptors.row(i), queries.frames[i].pose));
  give(localizer.finish());
  std::vector<std::size_t> numbers(queries.frames.size());
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return measureLocalization(localizer.map(), queries.frames, numbers, answers, truth, options.filter);
}

}  // namespace estancia::experiments
