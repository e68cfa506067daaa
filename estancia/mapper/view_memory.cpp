// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/view_memory.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "estancia/core/bytes.hpp"

namespace estancia {
namespace {

constexpr std::size_t maxViewsOfNode = 32;  // 8 lose returns to large rooms
constexpr std::size_t maxSequence = 16;     // images of a sequence that look different
constexpr double apartRatio = 2;            // × the near distance and angle

double angleBetween(const Pose& a, const Pose& b) {
  const auto f = a.forward(), g = b.forward();
  const double cosine = f[0] * g[0] + f[1] * g[1] + f[2] * g[2];
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace

ViewMemory::ViewMemory(Distance distance, std::size_t labels, const MapperOptions& options)
    : distance_(std::move(distance)),
      labels_(labels),
      max_(options.views),
      nearDistance_(options.nearDistance),
      nearAngle_(options.nearAngle),
      bounded_(distance_.comparison == Comparison::cosine && labels <= QuantizedUpperBounds::maxLength),
      bounds_(labels) {}

/// Exact below τ_join; above, it may be any distance not below τ_join.
std::vector<double> ViewMemory::distancesTo(std::span<const float> compared, double tauJoin) const {
  std::vector<float> upper(views_.size(), 2);
  if (bounded_) bounds_.upperBounds(compared, upper);
  std::vector<double> distances(views_.size());
  for (std::size_t i = 0; i < views_.size(); ++i)
    distances[i] = bounded_ && 1 - upper[i] >= tauJoin ? 1 - static_cast<double>(upper[i])
                                                       : distance(views_[i].compared, compared);
  return distances;
}

double ViewMemory::distance(std::span<const float> a, std::span<const float> b) const {
  if (distance_.comparison == Comparison::cosine)
    return std::clamp(1.0 - dot(a, b), 0.0, 2.0);  // unit vectors
  return compare(distance_.comparison, a, b);
}

ViewMemory::Relation ViewMemory::relation(const std::optional<Pose>& a, const std::optional<Pose>& b) const {
  if (!a || !b) return Relation::unknown;
  double far = distanceBetween(*a, *b) / nearDistance_;
  if (far > apartRatio) return Relation::apart;  // whatever the angle, which takes longer
  far = std::max(far, angleBetween(*a, *b) / nearAngle_);
  return far <= 1 ? Relation::near : far <= apartRatio ? Relation::between : Relation::apart;
}

bool ViewMemory::isElsewhere(const std::optional<Pose>& a, const std::optional<Pose>& b) const {
  return a && b && distanceBetween(*a, *b) > apartRatio * nearDistance_;
}

std::optional<Recognition> ViewMemory::recognize(const PlaceView& seen, int current,
                                                 const Thresholds& thresholds) {
  const std::vector<double> distances = distancesTo(seen.compared, thresholds.join);
  // Views last seen before these frames are earlier ones, by words and by poses.
  std::size_t before = driveBegan_, beforeByPose = driveBegan_;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (distances[i] >= thresholds.join) before = std::max(before, views_[i].lastSeen);
    if (relation(views_[i].pose, seen.pose) == Relation::apart)
      beforeByPose = std::max(beforeByPose, views_[i].lastSeen);
  }
  std::optional<Recognition> best;
  const auto consider = [&](const Recognition& found) {
    const bool here = found.node == current, bestHere = best && best->node == current;
    if (!best || (here != bestHere ? here : found.distance < best->distance)) best = found;
  };
  std::optional<std::size_t> nearest;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const PlaceView& view = views_[i];
    const double d = distances[i];
    if (d >= thresholds.join) continue;
    if (view.lastSeen < beforeByPose && relation(view.pose, seen.pose) == Relation::near)
      consider({view.node, d, thresholds.join, true});
    if (view.lastSeen >= before || isElsewhere(view.pose, seen.pose)) continue;
    if (d < thresholds.view) consider({view.node, d, thresholds.view, false});
    if (!nearest || d < distances[*nearest]) nearest = i;
  }
  if (!nearest || distances[*nearest] >= thresholds.sequence)
    sequence_.clear();
  else if (continues(seen, views_[*nearest], thresholds))
    consider({views_[*nearest].node, distances[*nearest], thresholds.sequence, false});
  return best;
}

/// Whether another view of the known view's node has been resembled before in this sequence.
bool ViewMemory::continues(const PlaceView& seen, const PlaceView& known, const Thresholds& thresholds) {
  bool confirmed = false, isNew = sequence_.size() < maxSequence;
  for (const Resemblance& earlier : sequence_) {
    const double change = distance(seen.compared, earlier.seen.compared);
    confirmed = confirmed || (earlier.known.node == known.node && change > thresholds.sequence &&
                              distance(known.compared, earlier.known.compared) > thresholds.sequence);
    isNew = isNew && change > thresholds.view;
  }
  if (isNew) sequence_.push_back({seen, known});
  return confirmed;
}

void ViewMemory::keep(PlaceView view, const Thresholds& thresholds) {
  const int node = view.node;
  if (bounded_) bounds_.set(views_.size(), view.compared);
  views_.push_back(std::move(view));
  setCount(node, counts_[node] + 1);
  if (counts_.at(node) > maxViewsOfNode)
    forgetOne(node, thresholds);
  else if (views_.size() > max_)
    forgetOne(largest_.begin()->second, thresholds);
}

/// The node has so many views now.
void ViewMemory::setCount(int node, std::size_t views) {
  const auto known = counts_.find(node);
  if (known != counts_.end()) largest_.erase({-static_cast<std::ptrdiff_t>(known->second), node});
  if (views > 0) {
    counts_[node] = views;
    largest_.emplace(-static_cast<std::ptrdiff_t>(views), node);
  } else if (known != counts_.end()) {
    counts_.erase(known);
  }
}

/// 0 for the same view; in units of what is near.
double ViewMemory::likeness(const PlaceView& a, const PlaceView& b, const Thresholds& thresholds) const {
  double worst = distance(a.compared, b.compared) / thresholds.join;
  if (a.pose && b.pose)
    worst = std::max({worst, distanceBetween(*a.pose, *b.pose) / nearDistance_,
                      angleBetween(*a.pose, *b.pose) / nearAngle_});
  return worst;
}

/// Removes, from the two most similar views, the one nearer to a third, and the other one stands for it;
/// where each node has one view, the one not seen for longest goes.
void ViewMemory::forgetOne(int node, const Thresholds& thresholds) {
  std::vector<std::size_t> among;
  for (std::size_t i = 0; i < views_.size(); ++i)
    if (views_[i].node == node) among.push_back(i);
  if (among.size() < 2) {
    const auto oldest = std::ranges::min_element(views_, {}, &PlaceView::lastSeen);
    return remove(static_cast<std::size_t>(oldest - views_.begin()));
  }
  const std::size_t n = among.size();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> apart(n * n, infinity);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j)
      apart[i * n + j] = apart[j * n + i] = likeness(views_[among[i]], views_[among[j]], thresholds);
  const auto nearest = static_cast<std::size_t>(std::ranges::min_element(apart) - apart.begin());
  std::size_t stays = nearest / n, gone = nearest % n;
  const auto toThird = [&](std::size_t i) {
    double least = infinity;
    for (std::size_t k = 0; k < n; ++k)
      if (k != stays && k != gone) least = std::min(least, apart[i * n + k]);
    return least;
  };
  if (toThird(stays) < toThird(gone)) std::swap(stays, gone);
  PlaceView& kept = views_[among[stays]];
  kept.lastSeen = std::max(kept.lastSeen, views_[among[gone]].lastSeen);
  remove(among[gone]);
}

void ViewMemory::remove(std::size_t slot) {
  setCount(views_[slot].node, counts_.at(views_[slot].node) - 1);
  if (slot + 1 != views_.size()) std::swap(views_[slot], views_.back());
  views_.pop_back();
  if (bounded_) bounds_.remove(slot);
}

double ViewMemory::nearestOf(int node, std::span<const float> compared) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const PlaceView& view : views_)
    if (view.node == node) nearest = std::min(nearest, distance(view.compared, compared));
  return nearest;
}

std::optional<std::span<const float>> ViewMemory::nearestOfEarlierDrives(
    std::span<const float> compared) const {
  std::vector<float> upper(views_.size(), 2);
  if (bounded_) bounds_.upperBounds(compared, upper);
  const PlaceView* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (views_[i].frame >= driveBegan_ || (bounded_ && 1 - upper[i] >= least)) continue;
    if (const double away = distance(views_[i].compared, compared); away < least)
      least = away, nearest = &views_[i];
  }
  return nearest != nullptr ? std::optional(std::span<const float>(nearest->embedded)) : std::nullopt;
}

bool ViewMemory::isElsewhere(int node, const std::optional<Pose>& pose) const {
  return counts_.contains(node) && std::ranges::all_of(views_, [&](const PlaceView& view) {
           return view.node != node || isElsewhere(view.pose, pose);
         });
}

bool ViewMemory::areApart(int a, int b) const {
  return counts_.contains(a) && std::ranges::all_of(views_, [&](const PlaceView& view) {
           return view.node != a || isElsewhere(b, view.pose);
         });
}

void ViewMemory::merge(int absorbed, int kept) {
  for (PlaceView& view : views_)
    if (view.node == absorbed) view.node = kept;
  if (const auto own = counts_.find(absorbed); own != counts_.end()) {
    setCount(kept, counts_[kept] + own->second);
    setCount(absorbed, 0);
  }
  for (Resemblance& earlier : sequence_)
    if (earlier.known.node == absorbed) earlier.known.node = kept;
}

void ViewMemory::forgetFrom(int node) {
  for (std::size_t i = views_.size(); i-- > 0;)
    if (views_[i].node >= node) remove(i);
  sequence_.clear();
}

void ViewMemory::beginDrive(std::size_t frame) {
  driveBegan_ = frame;
  sequence_.clear();
}

void ViewMemory::rescale(const std::function<std::vector<float>(std::span<const float>)>& compared) {
  for (std::size_t i = 0; i < views_.size(); ++i) {
    views_[i].compared = compared(views_[i].embedded);
    if (bounded_) bounds_.set(i, views_[i].compared);
  }
  for (Resemblance& earlier : sequence_)
    for (PlaceView* view : {&earlier.seen, &earlier.known}) view->compared = compared(view->embedded);
}

void ViewMemory::clear() {
  views_.clear();
  counts_.clear();
  largest_.clear();
  sequence_.clear();
  bounds_ = QuantizedUpperBounds(labels_);
}

void ViewMemory::movePoses(const std::function<std::optional<Pose>(std::size_t)>& pose) {
  for (PlaceView& view : views_) view.pose = pose(view.frame);
  for (Resemblance& earlier : sequence_)
    for (PlaceView* view : {&earlier.seen, &earlier.known}) view->pose = pose(view->frame);
}

void ViewMemory::bound(std::size_t most, const Thresholds& thresholds) {
  max_ = most;
  while (views_.size() > max_) forgetOne(largest_.begin()->second, thresholds);
}

void ViewMemory::addNeededFrames(std::vector<std::size_t>& frames) const {
  for (const PlaceView& view : views_) frames.push_back(view.frame);
  for (const Resemblance& earlier : sequence_)
    for (const PlaceView* view : {&earlier.seen, &earlier.known}) frames.push_back(view->frame);
}

std::string ViewMemory::state() const {
  ByteWriter out;
  const auto write = [&out](const PlaceView& view) {
    out.number<std::uint64_t>(view.frame);
    out.number<std::int32_t>(view.node);
    out.number<std::uint64_t>(view.lastSeen);
  };
  out.number<std::uint64_t>(views_.size());
  for (const PlaceView& view : views_) write(view);
  out.number<std::uint64_t>(sequence_.size());
  for (const Resemblance& earlier : sequence_) {
    write(earlier.seen);
    write(earlier.known);
  }
  if (driveBegan_ > 0) out.number<std::uint64_t>(driveBegan_);
  return out.bytes();
}

void ViewMemory::restore(const std::string& state, std::size_t frames,
                         const std::function<PlaceView(std::size_t, int)>& view) {
  ByteReader in(state, "the saved views of the mapper are damaged", "map the sequence again");
  constexpr std::size_t bytes = sizeof(std::uint64_t) + sizeof(std::int32_t) + sizeof(std::uint64_t);
  const auto read = [&] {
    const auto frame = in.number<std::uint64_t>();
    const auto node = in.number<std::int32_t>();
    const auto lastSeen = in.number<std::uint64_t>();
    if (frame >= frames || lastSeen >= frames) in.fail("a frame is missing", ErrorCode::corruptFile);
    PlaceView result = view(frame, node);
    std::tie(result.frame, result.node, result.lastSeen) = std::tuple(frame, node, lastSeen);
    return result;
  };
  clear();
  for (std::size_t count = in.count(bytes); count > 0; --count) {
    views_.push_back(read());
    setCount(views_.back().node, counts_[views_.back().node] + 1);
    if (bounded_) bounds_.set(views_.size() - 1, views_.back().compared);
  }
  for (std::size_t count = in.count(2 * bytes); count > 0; --count) {
    PlaceView seen = read(), known = read();
    sequence_.push_back({std::move(seen), std::move(known)});
  }
  driveBegan_ = in.remaining() > 0 ? in.number<std::uint64_t>() : 0;
  if (in.remaining() > 0) in.fail("it is too long", ErrorCode::corruptFile);
}

}  // namespace estancia
