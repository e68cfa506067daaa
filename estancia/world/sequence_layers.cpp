// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/sequence_layers.hpp"

#include <utility>

#include "estancia/core/frame_failure.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

SequenceLayers::SequenceLayers(const Sequence& sequence, Labeler& labeler, MapRun& run, Hooks hooks)
    : sequence_(sequence), labeler_(labeler), run_(run), hooks_(std::move(hooks)) {
  if (run_.session()) start();
}

void SequenceLayers::start() {
  WorldOptions options = WorldMapper::optionsOf(run_.start()).value_or(WorldOptions{});
  if (hooks_.change) hooks_.change(options);
  const auto camera = cameraToTrack(sequence_, options);
  layers_.emplace(run_.start(), options, &labeler_, camera);
  if (!run_.beginsDrive()) keepCamera();
  if (hooks_.started) hooks_.started(*layers_, camera.has_value());
}

void SequenceLayers::keepCamera() {
  if (sequence_.hasDepth() && sequence_.intrinsics() &&
      (layers_->layers().areas || layers_->layers().objects))
    layers_->keepCamera(*sequence_.intrinsics(), sequence_.depthScale());
}

void SequenceLayers::add(const LabeledFrame& labeled, bool thumbnail) {
  if (!layers_) start();
  if (run_.beginDrive()) {
    layers_->beginDrive();
    keepCamera();
  }
  Frame frame = sequence_.frame(labeled.index);
  const cv::Mat depth = depthOf(labeled.index);
  cv::Mat image = labeled.image;
  if (!depth.empty() && image.empty() && layers_->wantsImage(frame)) image = imageOf(labeled.index);
  frame.pose = layers_->observe(frame, labeled.descriptor, image, depth,
                                sequence_.intrinsics().value_or(CameraIntrinsics{}));
  const auto encoded = [&] { return encodeImage(image.empty() ? sequence_.image(labeled.index) : image); };
  run_.add(frame, labeled.descriptor, thumbnail ? MappingSession::Image(encoded) : MappingSession::Image());
}

void SequenceLayers::finish() {
  run_.finish();
  if (layers_) layers_->finish();
}

/// Empty where it cannot be read: its words are known, from a recording or the cache.
cv::Mat SequenceLayers::imageOf(std::size_t i) const {
  try {
    return sequence_.image(i);
  } catch (...) {
    frameFailure(sequence_.frame(i).name);
    return {};
  }
}

cv::Mat SequenceLayers::depthOf(std::size_t i) const {
  if (!sequence_.hasDepth() || !sequence_.intrinsics()) return {};
  try {
    return sequence_.depth(i);
  } catch (...) {
    const Error why = frameFailure(sequence_.frame(i).name);
    if (hooks_.withoutDepth) hooks_.withoutDepth(why.what());
    return {};
  }
}

}  // namespace estancia
