// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/map_sequence.hpp"

#include <optional>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/io/image_writer.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/label/labeler.hpp"
#include "estancia/topology/map_run.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world/world_mapper.hpp"

namespace estancia {
namespace {

MapRun::Existing existingOf(MapSequenceOptions::Existing existing) {
  switch (existing) {
    case MapSequenceOptions::Existing::replace:
      return MapRun::Existing::replace;
    case MapSequenceOptions::Existing::resume:
      return MapRun::Existing::resume;
    default:
      return MapRun::Existing::refuse;
  }
}

/// Places, and the layers above them, from frame to frame.
class Mapping {
 public:
  Mapping(const Sequence& sequence, Labeler& labeler, MapRun& run, const MapSequenceOptions& options)
      : sequence_(sequence), labeler_(labeler), run_(run), change_(options.changeWorld) {
    if (run_.session()) start();  // says at once what does not fit
  }

  void add(const LabeledFrame& labeled) {
    if (!layers_) start();
    Frame frame = sequence_.frame(labeled.index);
    const cv::Mat depth = depthOf(labeled.index);
    cv::Mat image = labeled.image;
    if (!depth.empty() && image.empty() && layers_->wantsImage(frame)) image = imageOf(labeled.index);
    frame.pose = layers_->observe(frame, labeled.descriptor, image, depth,
                                  sequence_.intrinsics().value_or(CameraIntrinsics{}));
    const auto thumbnail = [&] {
      return encodeImage(image.empty() ? sequence_.image(labeled.index) : image);
    };
    run_.add(frame, labeled.descriptor, labeler_.needsImage() ? MappingSession::Image(thumbnail) : nullptr);
  }
  void finish() {
    run_.finish();
    if (layers_) layers_->finish();
  }
  std::vector<std::string> problems;

 private:
  void start() {
    WorldOptions options = WorldMapper::optionsOf(run_.start()).value_or(WorldOptions{});
    if (change_) change_(options);
    const auto camera = cameraToTrack(sequence_, options);
    layers_.emplace(run_.start(), options, &labeler_, camera);
    if (sequence_.hasDepth() && sequence_.intrinsics() &&
        (layers_->layers().areas || layers_->layers().objects))
      layers_->keepCamera(*sequence_.intrinsics(), sequence_.depthScale());
  }

  /// Empty where it cannot be read: its words are known, from a recording or the cache.
  cv::Mat imageOf(std::size_t i) const {
    try {
      return sequence_.image(i);
    } catch (...) {
      frameFailure(sequence_.frame(i).name);
      return {};
    }
  }

  cv::Mat depthOf(std::size_t i) {
    if (!sequence_.hasDepth() || !sequence_.intrinsics()) return {};
    try {
      return sequence_.depth(i);
    } catch (...) {
      problems.emplace_back(std::string("no depth: ") + frameFailure(sequence_.frame(i).name).what());
      return {};
    }
  }

  const Sequence& sequence_;
  Labeler& labeler_;
  MapRun& run_;
  std::function<void(WorldOptions&)> change_;
  std::optional<WorldMapper> layers_;
};

/// Adds the frames from `first` on. Returns how many were used.
std::size_t addFrames(const Sequence& sequence, Labeler& labeler, Mapping& mapping,
                      const LabelStreamOptions& options, Progress& progress) {
  LabelStream stream(sequence, labeler, options);
  std::size_t used = 0;
  progress.begin("mapping", sequence.size(), options.first);
  while (const auto frame = stream.next()) {
    if (frame->labeled()) {
      mapping.add(*frame);
      ++used;
    } else {
      mapping.problems.push_back(frame->problem);
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
  std::optional<MapRun> run(std::in_place, map, existingOf(options.existing));
  LabelStreamOptions stream = options.stream;
  stream.first = std::max(stream.first, run->begin(sequence, labeler.vocabulary(), labeler.identity(),
                                                   [&](MapperOptions& mapper) {
                                                     if (options.changeMapper) options.changeMapper(mapper);
                                                   }));
  Mapping mapping(sequence, labeler, *run, options);
  std::size_t used = 0;
  try {
    used = addFrames(sequence, labeler, mapping, stream, progress);
  } catch (const Interrupted&) {
    if (run->session()) mapping.finish();  // what was mapped is kept whole
    throw;
  }
  if (used == 0 && stream.first < sequence.size())
    fail(ErrorCode::fileUnreadable, "{}: none of its {} frames can be used; the first: {}", sequence.name(),
         sequence.size() - stream.first, mapping.problems.empty() ? "" : mapping.problems.front());
  mapping.finish();
  MappedSequence done{run->session()->frames(), run->session()->frames() - run->framesBefore(),
                      std::move(mapping.problems)};
  run.reset();  // the rooms are written into its file
  WorldOptions naming;
  if (options.changeWorld) options.changeWorld(naming);
  if (naming.areas.naming.words == NamingOptions::Words::wordNet) renewRoomsByNames(map);
  return done;
}

}  // namespace estancia
