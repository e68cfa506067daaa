// SPDX-License-Identifier: Apache-2.0
#include "estancia/sources/frame_source.hpp"

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sources/camera_source.hpp"
#include "estancia/sources/replay_source.hpp"
#include "estancia/sources/ros_source.hpp"

namespace estancia {
namespace {

/// Rejects options that apply to recordings only.
void requireNoRecording(const std::string& source, const FrameSourceOptions& options, bool hasTopics) {
  const SequenceOptions& sequence = options.sequence;
  const ReplayOptions usual;
  const bool hasTopic =
      !sequence.imageTopic.empty() || !sequence.depthTopic.empty() || !sequence.odomTopic.empty();
  const char* given = options.replay.rate != usual.rate                         ? "--rate"
                      : options.replay.framesPerSecond != usual.framesPerSecond ? "--frames-per-second"
                      : sequence.type != SequenceOptions().type                 ? "--type"
                      : !sequence.poses.empty()                                 ? "--poses"
                      : !sequence.intrinsics.empty()                            ? "--intrinsics"
                      : hasTopic && !hasTopics                                  ? "a topic"
                      : !sequence.imageTopic.empty()                            ? "--image"
                                                                                : nullptr;
  if (given != nullptr)
    fail(ErrorCode::invalidOption, "{} is for recordings, and {} is {}; leave it out", given,
         printable(source), hasTopics ? "a topic" : "a camera");
}

}  // namespace

std::unique_ptr<FrameSource> makeFrameSource(const std::string& source, const FrameSourceOptions& options) {
  if (isCamera(source)) {
    requireNoRecording(source, options, false);
    return std::make_unique<CameraSource>(source);
  }
  if (isRosTopic(source)) {
    requireNoRecording(source, options, true);
    const SequenceOptions& topics = options.sequence;
    return std::make_unique<RosSource>(
        source, RosSourceOptions{topics.depthTopic, topics.odomTopic, topics.depthScale, topics.maxPoseGap},
        ros::makeDdsNode(rosDomain()));
  }
  if (isDescriptorFile(source))
    fail(ErrorCode::unsupportedFile, "{} holds words, and no images to play; map it by `estancia map`",
         printable(source));
  return std::make_unique<ReplaySource>(openSequence(source, options.sequence), options.replay);
}

}  // namespace estancia
