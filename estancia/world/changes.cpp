// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/rigid.hpp"
#include "estancia/topology/store.hpp"
#include "estancia/world/observation.hpp"
#include "estancia/world/world_store.hpp"

namespace estancia {
namespace {

constexpr std::size_t pointsOfView = 60, pointsOfThing = 240, fewestPoints = 12;
constexpr std::size_t enoughViews = 2;  // that see a point's place empty
constexpr double enoughEmpty = 0.6;     // share of the points that were looked at
constexpr double enoughLookedAt = 0.3;  // of the points
constexpr double leastMove = 0.1;       // [m]: of one object in both
constexpr double sameSize = 1.7;        // ratio of lengths of a thing that was moved
constexpr double enoughAlike = 0.35;    // cosine of the words of one thing in two places

/// Below, a difference in depth is noise: a Kinect's is 0.0012 z² (Khoshelham and Elberink 2012), and poses
/// are off by some centimeters.
double noiseAt(double depth) {
  return 0.03 + 3 * 0.0012 * depth * depth;
}

/// What an epoch shows of an object.
struct Thing {
  std::vector<cv::Point3d> points;
  std::size_t first = std::numeric_limits<std::size_t>::max(), last = 0, views = 0;

  bool isSeen() const { return points.size() >= fewestPoints; }
  cv::Point3d middle() const {
    cv::Point3d sum;
    for (const cv::Point3d& p : points) sum += p;
    return sum * (1.0 / static_cast<double>(std::max<std::size_t>(1, points.size())));
  }
};

/// How often the place of each point was seen empty, and how often not.
struct Looks {
  std::vector<std::size_t> empty, full;
  explicit Looks(std::size_t points) : empty(points), full(points) {}

  /// Share of empty ones; nothing where too little was looked at.
  std::optional<double> emptiness() const {
    std::size_t looked = 0, free = 0;
    for (std::size_t i = 0; i < empty.size(); ++i) {
      if (empty[i] + full[i] < enoughViews) continue;
      ++looked;
      if (empty[i] >= enoughViews && empty[i] > full[i]) ++free;
    }
    if (static_cast<double>(looked) < enoughLookedAt * static_cast<double>(empty.size()) ||
        looked < fewestPoints)
      return std::nullopt;
    return static_cast<double>(free) / static_cast<double>(looked);
  }
};

/// The two epochs of a map: which views are of now.
class Epochs {
 public:
  Epochs(const WorldMap& world, const WorldStore& store, std::size_t firstNow)
      : world_(world),
        store_(store),
        firstNow_(firstNow),
        things_{std::vector<Thing>(world.objects.size()), std::vector<Thing>(world.objects.size())} {
    findThings();
    findLooks();
  }

  /// 0: before, 1: now.
  const Thing& thing(std::size_t epoch, std::size_t object) const { return things_[epoch][object]; }
  /// How empty the other epoch saw the object's place of this one.
  std::optional<double> emptiness(std::size_t epoch, std::size_t object) const {
    return looks_[epoch][object].emptiness();
  }

 private:
  std::size_t epochOf(std::size_t frame) const { return frame >= firstNow_ ? 1 : 0; }

  void findThings() {
    const std::map<SegmentPlace, int> objectOf = store_.objectSegments();
    forEachView(
        [&](std::size_t frame, const Observation& seen, const cv::Mat& depth, const cv::Affine3d& pose) {
          for (std::size_t s = 1; s <= seen.info.size(); ++s) {
            const auto object = objectOf.find({frame, s});
            if (object == objectOf.end() || seen.segments.empty()) continue;
            if (object->second < 0 || static_cast<std::size_t>(object->second) >= world_.objects.size())
              continue;
            Thing& thing = things_[epochOf(frame)][static_cast<std::size_t>(object->second)];
            thing.first = std::min(thing.first, frame);
            thing.last = std::max(thing.last, frame);
            ++thing.views;
            addPoints(seen, depth, pose, s, thing);
          }
        });
    for (auto& epoch : things_)
      for (Thing& thing : epoch) thin(thing.points);
  }

  static void addPoints(const Observation& seen, const cv::Mat& depth, const cv::Affine3d& pose,
                        std::size_t segment, Thing& thing) {
    const cv::Rect& box = seen.info[segment - 1].box;
    std::vector<cv::Point3d> points;
    for (int y = box.y; y < box.y + box.height; ++y)
      for (int x = box.x; x < box.x + box.width; ++x) {
        const float z = depth.at<float>(y, x);
        if (seen.segments.at<unsigned char>(y, x) != segment || !(z > 0)) continue;
        points.push_back(pose * cv::Point3d(seen.camera.slopeX(x) * z, seen.camera.slopeY(y) * z, z));
      }
    const std::size_t count = std::min(points.size(), pointsOfView);
    for (std::size_t i = 0; i < count; ++i) thing.points.push_back(points[i * points.size() / count]);
  }

  static void thin(std::vector<cv::Point3d>& points) {
    if (points.size() <= pointsOfThing) return;
    std::vector<cv::Point3d> kept;
    for (std::size_t i = 0; i < pointsOfThing; ++i) kept.push_back(points[i * points.size() / pointsOfThing]);
    points = std::move(kept);
  }

  void findLooks() {
    for (std::size_t epoch = 0; epoch < 2; ++epoch)
      for (const Thing& thing : things_[epoch]) looks_[epoch].emplace_back(thing.points.size());
    forEachView(
        [&](std::size_t frame, const Observation& seen, const cv::Mat& depth, const cv::Affine3d& pose) {
          const cv::Affine3d inverse = pose.inv();
          const std::size_t other = 1 - epochOf(frame);
          for (std::size_t object = 0; object < things_[other].size(); ++object) {
            const std::vector<cv::Point3d>& points = things_[other][object].points;
            for (std::size_t i = 0; i < points.size(); ++i)
              look(inverse * points[i], seen.camera, depth, looks_[other][object], i);
          }
        });
  }

  static void look(const cv::Point3d& point, const CameraIntrinsics& camera, const cv::Mat& depth,
                   Looks& looks, std::size_t i) {
    constexpr double nearest = 0.2, farthest = 6;  // [m]
    if (point.z < nearest || point.z > farthest) return;
    const int x = static_cast<int>(std::lround(camera.cx + camera.fx * point.x / point.z));
    const int y = static_cast<int>(std::lround(camera.cy + camera.fy * point.y / point.z));
    if (x < 0 || y < 0 || x >= depth.cols || y >= depth.rows) return;
    const double seen = depth.at<float>(y, x), noise = noiseAt(point.z);
    if (!(seen > 0) || seen < point.z - noise) return;  // unknown, or something is in the way
    ++(seen > point.z + noise ? looks.empty : looks.full)[i];
  }

  template <class Use>
  void forEachView(const Use& use) const {
    store_.forEachObservation([&](std::size_t frame, const Observation& seen) {
      if (frame >= world_.places.frames.size() || !world_.places.frames[frame].pose) return true;
      use(frame, seen, depthOf(seen), rigidOf(*world_.places.frames[frame].pose));
      return true;
    });
  }

  const WorldMap& world_;
  const WorldStore& store_;
  std::size_t firstNow_;
  std::array<std::vector<Thing>, 2> things_;
  std::array<std::vector<Looks>, 2> looks_;
};

double alikeWords(const WorldObject& a, const WorldObject& b) {
  double both = 0, ofA = 0, ofB = 0;
  std::map<std::string, double> known;
  for (const LabelProbability& word : a.words) {
    known[word.label] = word.probability;
    ofA += static_cast<double>(word.probability) * word.probability;
  }
  for (const LabelProbability& word : b.words) {
    ofB += static_cast<double>(word.probability) * word.probability;
    if (const auto found = known.find(word.label); found != known.end())
      both += found->second * word.probability;
  }
  return both > 0 ? both / std::sqrt(ofA * ofB) : 0;
}

bool haveOneSize(const WorldObject& a, const WorldObject& b) {
  std::array<double, 3> u{a.size.x, a.size.y, a.size.z}, v{b.size.x, b.size.y, b.size.z};
  std::ranges::sort(u);
  std::ranges::sort(v);
  constexpr double thin = 0.05;  // [m]: lengths below say nothing
  for (std::size_t i = 0; i < 3; ++i)
    if (std::max(u[i], v[i]) > sameSize * std::max({std::min(u[i], v[i]), thin})) return false;
  return true;
}

/// Pairs of things that are gone and things that are new, most alike first.
void joinMoved(const WorldMap& world, std::vector<ObjectChange>& changes) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < changes.size(); ++i)
    for (std::size_t k = 0; k < changes.size(); ++k) {
      if (changes[i].kind != ObjectChange::Kind::gone || changes[k].kind != ObjectChange::Kind::appeared)
        continue;
      const WorldObject &gone = *world.findObject(*changes[i].before),
                        &now = *world.findObject(*changes[k].now);
      const double alike = alikeWords(gone, now);
      if (alike >= enoughAlike && haveOneSize(gone, now)) pairs.emplace_back(-alike, i, k);
    }
  std::ranges::sort(pairs);
  std::set<std::size_t> joined;
  for (const auto& [alike, gone, now] : pairs) {
    if (joined.contains(gone) || joined.contains(now)) continue;
    ObjectChange& change = changes[gone];
    change.kind = ObjectChange::Kind::moved;
    change.now = changes[now].now;
    change.to = changes[now].to;
    change.firstNow = changes[now].firstNow;
    change.emptiness = std::min(change.emptiness, changes[now].emptiness);
    joined.insert(gone);
    joined.insert(now);
    changes[now].now.reset();  // to be dropped
  }
  std::erase_if(changes, [](const ObjectChange& change) { return !change.before && !change.now; });
}

std::vector<ObjectChange> changedObjects(const WorldMap& world, const WorldStore& store,
                                         std::size_t firstNow) {
  const Epochs epochs(world, store, firstNow);
  std::vector<ObjectChange> changes;
  for (std::size_t object = 0; object < world.objects.size(); ++object) {
    const Thing &before = epochs.thing(0, object), &now = epochs.thing(1, object);
    const std::optional<double> left = epochs.emptiness(0, object), come = epochs.emptiness(1, object);
    ObjectChange change;
    change.from = before.middle();
    change.to = now.middle();
    change.lastBefore = before.last;
    change.firstNow = now.first;
    const int id = world.objects[object].id;
    if (before.isSeen() && now.isSeen()) {
      if (!left || !come || std::min(*left, *come) < enoughEmpty / 2 ||
          cv::norm(change.to - change.from) < leastMove)
        continue;
      change.kind = ObjectChange::Kind::moved;
      change.before = change.now = id;
      change.emptiness = std::min(*left, *come);
    } else if (before.isSeen() && left && *left >= enoughEmpty) {
      change.kind = ObjectChange::Kind::gone;
      change.before = id;
      change.emptiness = *left;
    } else if (now.isSeen() && come && *come >= enoughEmpty) {
      change.kind = ObjectChange::Kind::appeared;
      change.now = id;
      change.emptiness = *come;
    } else {
      continue;
    }
    changes.push_back(change);
  }
  joinMoved(world, changes);
  return changes;
}

}  // namespace

std::string toString(ObjectChange::Kind kind) {
  switch (kind) {
    case ObjectChange::Kind::moved:
      return "moved";
    case ObjectChange::Kind::gone:
      return "gone";
    case ObjectChange::Kind::appeared:
      return "new";
  }
  throw Error(ErrorCode::invalidInput, "a change of unknown kind");
}

Changes findChanges(const std::filesystem::path& path, std::optional<std::size_t> since) {
  MapStore map = MapStore::open(path, MapStore::Access::read);
  map.beginReading();
  const WorldStore store(map, MapStore::Access::read);
  WorldMap world{map.load()};
  store.read(world);
  const std::vector<Drive>& drives = world.places.drives;
  if (drives.size() < 2)
    fail(ErrorCode::insufficientData,
         "{} has only one drive; changes are told between drives: go on with "
         "another one by `estancia map --continue`",
         path.string());
  Changes changes{since.value_or(drives.size() - 1)};
  if (changes.since == 0 || changes.since >= drives.size())
    fail(ErrorCode::unknownName, "--since: the drives that others came before are 1 to {}, and {} is given",
         drives.size() - 1, changes.since);
  changes.objects = changedObjects(world, store, drives[changes.since].firstFrame);
  return changes;
}

}  // namespace estancia
