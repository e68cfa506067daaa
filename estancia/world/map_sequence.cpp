// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/map_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world/sequence_layers.hpp"
#include "estancia/world_file/world_options.hpp"

namespace estancia {
namespace {

/// Adds the frames from `first` on. Returns how many were used.
std::size_t addFrames(const Sequence& sequence, Labeler& labeler, SequenceLayers& layers,
                      const LabelStreamOptions& options, std::vector<std::string>& problems,
                      Progress& progress) {
  LabelStream stream(sequence, labeler, options);
  std::size_t used = 0;
  progress.begin("mapping", sequence.size(), options.first);
  while (const auto frame = stream.next()) {
    if (frame->labeled()) {
      layers.add(*frame, labeler.needsImage());
      ++used;
    } else {
      problems.push_back(frame->problem);
    }
    progress.advance();
    if (interrupted())
      throw Interrupted(fmt::format("stopped after {} of {} frames", frame->index + 1, sequence.size()));
  }
  progress.end();
  return used;
}

}  // namespace

MappedSequence mapSequence(const Sequence& sequence, Labeler& labeler, const std::filesystem::path& map,
                           const MapSequenceOptions& options, Progress& progress) {
  if (labeler.discovers())
    fail(ErrorCode::invalidInput,
         "{} discovers its words on the way; label the sequence first, then map the labels",
         labeler.identity());
  static_assert(static_cast<int>(MapRun::Existing::resume) ==
                static_cast<int>(MapSequenceOptions::Existing::resume));
  std::optional<MapRun> run(std::in_place, map, static_cast<MapRun::Existing>(options.existing));
  run->changeBudget(options.changeBudget);
  LabelStreamOptions stream = options.stream;
  const auto changeMapper = [&](MapperOptions& mapper) {
    if (options.changeMapper) options.changeMapper(mapper);
  };
  const std::size_t first =
      run->begin(sequence, labeler.vocabulary(), labeler.identity(), changeMapper, options.posesAreInMap);
  stream.first = std::max(stream.first, first);
  std::vector<std::string> problems;
  SequenceLayers layers(sequence, labeler, *run,
                        {.change = options.changeWorld, .withoutDepth = [&problems](const std::string& why) {
                           problems.push_back("no depth: " + why);
                         }});
  std::size_t used = 0;
  try {
    used = addFrames(sequence, labeler, layers, stream, problems, progress);
  } catch (const Interrupted&) {
    if (run->session()) layers.finish();  // what was mapped is kept whole
    throw;
  }
  if (used == 0 && stream.first < sequence.size())
    fail(ErrorCode::fileUnreadable, "{}: none of its {} frames can be used; the first: {}", sequence.name(),
         sequence.size() - stream.first, problems.empty() ? "" : problems.front());
  layers.finish();
  for (std::string& gone : WorldMapper::goneOptionsOf(run->start())) problems.push_back(std::move(gone));
  MappedSequence done{run->session()->frames(), run->session()->frames() - run->framesBefore(),
                      std::move(problems)};
  run.reset();  // the rooms are written into its file
  WorldOptions naming;
  if (options.changeWorld) options.changeWorld(naming);
  if (naming.areas.naming.words == NamingOptions::Words::wordNet) renewRoomsByNames(map);
  return done;
}

}  // namespace estancia
