// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/tracks.hpp"

#include <algorithm>
#include <opencv2/core/affine.hpp>

#include "estancia/core/error.hpp"

namespace estancia {
namespace {

using Sighting = Tracks::Sighting;

Sighting sightingOf(const Cluster& cluster, const CameraIntrinsics& camera) {
  const cv::Vec3d c(cluster.center.x, cluster.center.y, cluster.center.z);
  const cv::Rect& box = cluster.box;
  if (box.empty() || c[2] <= 0) return {c, {}};
  const cv::Point2d low(camera.slopeX(box.x - 0.5), camera.slopeY(box.y - 0.5));
  const cv::Point2d high(camera.slopeX(box.br().x - 0.5), camera.slopeY(box.br().y - 0.5));
  return {c, {low.x * c[2] - c[0], low.y * c[2] - c[1], (high.x - low.x) * c[2], (high.y - low.y) * c[2]}};
}

/// The projected rectangle, in slopes X/Z and Y/Z.
cv::Rect2d seenAs(const Sighting& s) {
  const double z = s.center[2];
  return {(s.center[0] + s.around.x) / z, (s.center[1] + s.around.y) / z, s.around.width / z,
          s.around.height / z};
}

double intersectionOverUnion(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double both = (a & b).area();
  return both / (a.area() + b.area() - both);
}

/// The last sighting in a camera at `pose`, if the object has not moved.
Sighting movedTo(const std::optional<Pose>& pose, const Tracks::Track& track) {
  Sighting moved = track.last;
  if (pose && track.pose) moved.center = rigidOf(*pose).inv() * (rigidOf(*track.pose) * moved.center);
  return moved;
}

struct Match {
  double similarity;
  std::size_t cluster, track;
};

/// Similarity above 0; 0 for different objects: those farther apart than 5 cm, or half their size if that
/// is more, and those whose boxes overlap less than by 0.3.
double similarityOf(const Sighting& expected, const Sighting& seen) {
  const double smaller = std::min(expected.size(), seen.size());
  const double distance = cv::norm(expected.center - seen.center);
  if (!(distance <= std::max(0.05, smaller / 2))) return 0;
  if (expected.around.empty() || seen.around.empty()) return 1 / (1 + distance);
  if (expected.center[2] <= 0) return 0;  // behind the camera
  const double overlap = intersectionOverUnion(seenAs(expected), seenAs(seen));
  return overlap >= 0.3 ? overlap : 0;
}

}  // namespace

std::vector<std::size_t> Tracks::follow(const Clusters& clusters, const CameraIntrinsics& camera,
                                        const std::optional<Pose>& pose) {
  if (!(camera.fx > 0) || !(camera.fy > 0))
    throw Error(ErrorCode::invalidInput,
                "the camera of the tracks has no focal length; give its intrinsics (fx fy cx cy)");
  const auto known = pose && pose->isPlausible() ? pose : std::nullopt;
  std::vector<Sighting> seen, expected;
  for (const Cluster& cluster : clusters.clusters) seen.push_back(sightingOf(cluster, camera));
  for (const Track& track : tracks_) expected.push_back(movedTo(known, track));

  std::vector<Match> matches;
  for (std::size_t c = 0; c < seen.size(); ++c)
    for (std::size_t t = 0; t < tracks_.size(); ++t)
      if (const double similarity = similarityOf(expected[t], seen[c]); similarity > 0)
        matches.push_back({similarity, c, t});
  std::ranges::stable_sort(matches, std::ranges::greater{}, &Match::similarity);

  constexpr auto none = static_cast<std::size_t>(-1);
  std::vector<std::size_t> trackOf(seen.size(), none);
  std::vector<char> found(tracks_.size(), 0);
  for (const Match& m : matches) {
    if (trackOf[m.cluster] != none || found[m.track] != 0) continue;
    trackOf[m.cluster] = m.track;
    found[m.track] = 1;
  }
  for (Track& track : tracks_) ++track.unseen;
  std::vector<std::size_t> numbers;
  for (std::size_t c = 0; c < seen.size(); ++c) {
    if (trackOf[c] == none) {
      trackOf[c] = tracks_.size();
      tracks_.push_back({next_++, {}, {}, 0});
    }
    Track& track = tracks_[trackOf[c]];
    track = {track.number, seen[c], known, 0};
    numbers.push_back(track.number);
  }
  std::erase_if(tracks_, [&](const Track& track) { return track.unseen > 5; });
  return numbers;
}

std::vector<std::size_t> Tracks::tracked() const {
  std::vector<std::size_t> numbers;
  for (const Track& track : tracks_) numbers.push_back(track.number);
  return numbers;  // new ones came last
}

}  // namespace estancia
