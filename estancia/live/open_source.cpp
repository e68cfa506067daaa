// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/open_source.hpp"

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/live/camera_source.hpp"
#include "estancia/live/ros_source.hpp"

namespace estancia {

std::unique_ptr<FrameSource> makeFrameSource(const std::string& source, const FrameSourceOptions& options) {
  if (isCamera(source)) return std::make_unique<CameraSource>(source);
  if (isRosTopic(source)) {
    const SequenceOptions& topics = options.sequence;
    return std::make_unique<RosSource>(
        source, RosSourceOptions{topics.depthTopic, topics.odomTopic, topics.depthScale, topics.maxPoseGap},
        ros::makeDdsNode({rosDomain()}));
  }
  if (isDescriptorFile(source))
    fail(ErrorCode::unsupportedFile, "{} holds words, and no images to play; map it by `estancia map`",
         printable(source));
  return std::make_unique<ReplaySource>(openSequence(source, options.sequence), options.replay);
}

}  // namespace estancia
