// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/areas.hpp"

#include <fmt/format.h>

#include <unordered_map>
#include <utility>

#include "estancia/areas/frame_poses.hpp"
#include "estancia/areas/plan_areas.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/stats/moments.hpp"

namespace estancia {
namespace {

FloorSurvey survey(const Sequence& sequence, const DescriptorSequence& labeled, const AreaOptions& options,
                   Progress& progress) {
  if (!sequence.intrinsics())
    fail(ErrorCode::insufficientData, "{}: the camera of the depth images is unknown; give its intrinsics",
         sequence.name());
  std::vector<Pose> poses;
  for (const Frame& frame : labeled.frames)
    if (frame.pose && frame.pose->isPlausible()) poses.push_back(*frame.pose);
  const Floor floor(poses);
  FloorSurvey result(floor, options.cell, labeled.vocabulary.size());
  std::unordered_map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < sequence.size(); ++i) places.emplace(sequence.frame(i).name, i);
  std::string why = poses.empty() ? "none has a pose" : "none with a pose has depth";
  progress.begin("areas", labeled.frames.size());
  for (std::size_t i = 0; i < labeled.frames.size(); ++i) {
    if (interrupted()) throw Interrupted(fmt::format("stopped after {} frames", i));
    progress.advance();
    const Frame& frame = labeled.frames[i];
    const auto place = places.find(frame.name);
    if (!frame.pose || !frame.pose->isPlausible() || place == places.end()) continue;
    cv::Mat depth;
    try {
      depth = sequence.depth(place->second);
    } catch (...) {
      why = frameFailure(frame.name).what();  // it still has a pose: it is in an area
      continue;
    }
    result.add(labeled.descriptors.row(i), depth, *sequence.intrinsics(), *frame.pose);
  }
  progress.end();
  if (result.grid.cells().empty())
    fail(ErrorCode::insufficientData,
         "{}: no frame has a pose and depth to see the floor plan by ({}); `estancia check` tells more, "
         "`estancia odometry estimate` finds poses",
         sequence.name(), why);
  return result;
}

}  // namespace

OptionGroup declare(AreaOptions& options) {
  OptionGroup group("areas", "How a drive becomes areas.");
  group.add("cell", &options.cell, "Width of a cell of the floor plan.")
      .range(0.01, 1)
      .unit("m")
      .why("Narrower than the thinnest wall, wider than the noise of the poses.");
  group.add(declare(options.segmentation));
  group.add(declare(options.naming));
  return group;
}

Areas findAreas(const Sequence& sequence, const DescriptorSequence& labeled, const AreaOptions& options,
                Progress& progress) {
  validate(options);
  FloorSurvey seen = survey(sequence, labeled, options, progress);
  FramePoses frames;
  Moments mean(labeled.vocabulary.size(), false);
  for (std::size_t i = 0; i < labeled.frames.size(); ++i) {
    frames.add(labeled.frames[i].pose);
    mean.add(labeled.descriptors.row(i));
  }
  PlannedFrames planned =
      planAreas(seen, {frames}, labeled.vocabulary, {mean.mean().begin(), mean.mean().end()},
                options.segmentation, {}, options.naming);
  Zones zones = describeZones(labeled, planned.areaOfFrame, options.naming);
  zones.distance = "floor plan";
  zones.linkage = "doors";
  zones.cutReason = "rooms of the floor plan, split at doors and narrow passages";
  for (Zone& zone : zones.zones) zone.name = planned.plan.areas[static_cast<std::size_t>(zone.id)].name;
  return {std::move(planned.plan), std::move(zones), std::move(seen.words)};
}

}  // namespace estancia
