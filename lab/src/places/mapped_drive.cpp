// SPDX-License-Identifier: Apache-2.0
#include "places/mapped_drive.hpp"

#include <numeric>
#include <utility>
#include <vector>

#include "estancia/localization/localizer.hpp"
#include "estancia/session/session.hpp"

namespace estancia::experiments {

ScratchMap::ScratchMap(const DescriptorSequence& recording, std::filesystem::path path,
                       const MapperOptions& mapper)
    : ScratchFile(std::move(path)) {
  auto session = MappingSession::create(this->path(), recording.vocabulary, recording.model, mapper,
                                        ExistingMap::replace);
  for (std::size_t i = 0; i < recording.frames.size(); ++i)
    session.add(recording.frames[i], recording.descriptors.row(i));
  session.finish();
}

DescriptorSequence withoutPoses(DescriptorSequence recording) {
  for (Frame& frame : recording.frames) frame.pose.reset();
  return recording;
}

std::vector<Localization> locate(const DescriptorSequence& queries, std::shared_ptr<const LocalizerMap> map,
                                 std::size_t lookahead) {
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
  return answers;
}

LocalizationAccuracy measureAnswers(const TopologicalMap& map, const std::vector<Frame>& frames,
                                    const std::vector<Localization>& answers, const AdmissibleImages& truth) {
  std::vector<std::size_t> numbers(frames.size());
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return measureLocalization(map, frames, numbers, answers, truth, LocalizerOptions{}.filter);
}

LocalizationAccuracy findDrive(const DescriptorSequence& queries, std::shared_ptr<const LocalizerMap> map,
                               std::size_t lookahead, const AdmissibleImages& truth) {
  return measureAnswers(map->map, queries.frames, locate(queries, map, lookahead), truth);
}

}  // namespace estancia::experiments
