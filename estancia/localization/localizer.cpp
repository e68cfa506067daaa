// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/localizer.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/pose_bytes.hpp"
#include "estancia/localization/localization_filter.hpp"
#include "estancia/localization/localizer_map.hpp"
#include "estancia/localization/view_metric.hpp"
#include "estancia/mapper/mapper_impl.hpp"

namespace estancia {
namespace {

/// Sums of belief by group: the largest, and its share of all.
template <class GroupOf>
std::pair<int, double> mostProbable(const std::vector<double>& belief, GroupOf groupOf) {
  std::map<int, double> sums;
  double total = 0;
  for (std::size_t i = 0; i < belief.size(); ++i) {
    sums[groupOf(i)] += belief[i];
    total += belief[i];
  }
  const auto best = std::max_element(sums.begin(), sums.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return {best->first, best->second / total};
}

std::size_t largest(const std::vector<double>& values) {
  return static_cast<std::size_t>(std::max_element(values.begin(), values.end()) - values.begin());
}

const LocalizerOptions& validated(const LocalizerOptions& options) {
  validate(options);
  return options;
}

}  // namespace

OptionGroup declare(PlaceFilterOptions& options) {
  OptionGroup group("filter", "Motion model and evidence of the Bayes filter.");
  group.add("near-distance", &options.nearDistance, "Frames this far apart can show the same view.")
      .unit("m")
      .above(0)
      .why("Views change over a shorter way in narrow rooms than in halls and streets.");
  group
      .add("near-angle", &options.nearAngle, "Frames whose directions differ by this can show the same view.")
      .unit("degrees")
      .above(0)
      .why("A wide field of view allows more.");
  return group;
}

OptionGroup declare(LocalizerOptions& options) {
  OptionGroup group("localizer", "How frames are found in a map.");
  group.add("lookahead", &options.lookahead, "Answer this many frames late (fixed-lag smoothing).")
      .unit("frames")
      .why("Later frames tell more; 0 answers at once.");
  group.add("max-images", &options.maxImages, "Compare with at most this many stored frames, evenly thinned.")
      .range(1)
      .why("Fewer take less memory and time.");
  group.add(declare(options.filter));
  return group;
}

LocalizerMap readLocalizerMap(const MapStore& store, const NodeBank& bank, std::size_t maxImages) {
  TopologicalMap map = store.load();
  const std::size_t frames = map.frames.size();
  const std::size_t stride = std::max<std::size_t>(1, (frames + maxImages - 1) / maxImages);
  DescriptorMatrix images(map.vocabulary.size());
  images.reserve((frames + stride - 1) / stride);
  for (std::size_t frame = 0; frame < frames; frame += stride)
    images.append(store.descriptor(map.frames[frame].number));
  return {std::move(map), bank, std::move(images), stride};
}

LocalizerMap readLocalizerMap(const MapStore& store, std::size_t maxImages) {
  return readLocalizerMap(store, restoreMapper(store).impl().bankAtRest(), maxImages);
}

LocalizerMap readLocalizerMap(const std::filesystem::path& path, std::size_t maxImages) {
  MapStore store = MapStore::open(path, MapStore::Access::read);
  store.beginReading();  // map and mapper must be of one moment: a run that goes on may write in between
  return readLocalizerMap(store, maxImages);
}

/// Invariant: `views` has a row a frame of the map and never changes; `state` is the belief after the newest
/// frame; `waiting` holds the frames without a final answer, at most `lookahead`, oldest first. add() updates
/// `state` by motion and image and settles answers older than the lookahead; finish() settles the rest.
struct Localizer::Impl {
  Impl(std::shared_ptr<const LocalizerMap> source, const LocalizerOptions& chosen);

  struct Waiting {
    Localization answer;
    std::vector<float> filtered, likelihood;
    /// Since the last step; absent where the frame was too near to that to make one.
    std::optional<PlanarMotion> step;
  };
  std::vector<Localization> add(DescriptorView descriptor, const std::optional<Pose>& odometry);
  std::vector<float> comparedImages() const;
  void learnViews(std::vector<float>& images);
  double distanceTo(std::size_t view, std::span<const float> compared) const;
  std::optional<PlanarMotion> stepTo(const std::optional<Pose>& odometry);
  std::vector<Localization> settle(std::size_t count);
  void setBelief(Localization& answer, std::span<const float> state, std::span<const float> likelihood) const;
  const TopologicalMap& map() const { return source->map; }

  std::shared_ptr<const LocalizerMap> source;
  LocalizerOptions options;
  Distance distance;
  /// Weights for comparing images; none with distances other than cosines.
  std::optional<ViewMetric> metric;
  /// Mean vector around each frame of the map; its distance is the mean of its neighbors' distances.
  std::vector<float> views;
  std::unique_ptr<const LocalizationFilter> filter;
  /// The filter's state after all frames so far.
  std::vector<float> state;
  /// Where the last frame was taken, and how the robot moved since the last step.
  std::optional<Pose> last;
  PlanarMotion moved;
  bool started = false;
  std::deque<Waiting> waiting;
  /// Zone of each frame; empty if not set.
  std::vector<int> zoneOf;
};

Localizer::Impl::Impl(std::shared_ptr<const LocalizerMap> shared, const LocalizerOptions& chosen)
    : source(std::move(shared)),
      options(validated(chosen)),
      distance(getDistance(map().distance, map().vocabulary.layout().parts)) {
  if (map().nodes.empty() || source->images.size() == 0)
    throw Error(ErrorCode::insufficientData, "the map has no places yet; map some images first");
  std::vector<float> images = comparedImages();
  views = images;
  if (distance.comparison == Comparison::cosine) learnViews(images);
  const std::size_t labels = source->images.labels();
  const auto between = [&](std::size_t a, std::size_t b) {
    return static_cast<float>(distanceTo(b, std::span(images).subspan(a * labels, labels)));
  };
  filter = makeFilter(*source, between, options.filter);
  state = filter->start();
}

/// The frames of the map, N×L.
std::vector<float> Localizer::Impl::comparedImages() const {
  std::vector<float> embedded(source->images.labels()), images;
  images.reserve(source->images.values().size());
  for (std::size_t i = 0; i < source->images.size(); ++i) {
    embed(distance.embedding, source->images.row(i), embedded, distance.parts);
    const std::vector<float> compared = source->bank.compared(embedded);
    images.insert(images.end(), compared.begin(), compared.end());
  }
  return images;
}

/// Sets metric and views, and applies the metric to the images.
void Localizer::Impl::learnViews(std::vector<float>& images) {
  constexpr double reach = 1.0 / 3;  // standard deviation, as a share of the nearby distance
  std::vector<std::optional<Pose>> poses;
  for (std::size_t i = 0; i < source->images.size(); ++i)
    poses.push_back(map().frames.at(i * source->stride).pose);
  const Neighborhoods around(images, poses,
                             {reach * options.filter.nearDistance, reach * options.filter.nearAngle});
  metric.emplace(images, around);
  metric->apply(images);
  const std::size_t labels = source->images.labels();
  for (std::size_t i = 0; i < around.size(); ++i)
    std::ranges::copy(around.mean(images, i), views.begin() + static_cast<std::ptrdiff_t>(i * labels));
}

double Localizer::Impl::distanceTo(std::size_t view, std::span<const float> compared) const {
  const std::span<const float> other(views.data() + view * compared.size(), compared.size());
  // Means of unit vectors are shorter than these.
  return metric ? std::clamp(1.0 - dot(other, compared), 0.0, 2.0)
                : compare(distance.comparison, other, compared);
}

std::optional<PlanarMotion> Localizer::Impl::stepTo(const std::optional<Pose>& odometry) {
  moved = moved.then(last && odometry ? motionBetween(*last, *odometry) : filter->unknownMotion());
  last = odometry;
  if (std::exchange(started, true) && !filter->isStep(moved)) return std::nullopt;
  return std::exchange(moved, {});
}

std::vector<Localization> Localizer::Impl::add(DescriptorView descriptor,
                                               const std::optional<Pose>& odometry) {
  const std::size_t labels = map().vocabulary.size();
  requireProbabilities(descriptor, labels, "the labeler");
  std::vector<float> embedded(labels);
  embed(distance.embedding, descriptor, embedded, distance.parts);
  std::vector<float> compared = source->bank.compared(embedded);
  const auto nearestNode = source->bank.nearest(compared, source->bank.size());
  if (metric) metric->apply(compared);
  std::vector<float> distances(source->images.size());
  for (std::size_t i = 0; i < distances.size(); ++i)
    distances[i] = static_cast<float>(distanceTo(i, compared));
  const auto nearest =
      static_cast<std::size_t>(std::min_element(distances.begin(), distances.end()) - distances.begin());

  Waiting frame;
  frame.answer.node =
      nearestNode ? source->bank[nearestNode->slot].id : map().frames.at(nearest * source->stride).node;
  frame.answer.nearestImage = nearest * source->stride;
  frame.answer.distance = distances[nearest];
  frame.likelihood = filter->likelihood(distances);
  frame.step = stepTo(odometry);
  if (frame.step) {
    std::vector<float> predicted(state.size());
    filter->predict(state, *frame.step, predicted);
    state = std::move(predicted);
    filter->observe(frame.likelihood, state);
  }
  if (options.lookahead == 0) {
    setBelief(frame.answer, state, frame.likelihood);
    return {frame.answer};
  }
  frame.filtered = state;
  waiting.push_back(std::move(frame));
  // Settling a block at a time costs two passes a frame instead of `lookahead`.
  return waiting.size() < 2 * options.lookahead ? std::vector<Localization>{} : settle(options.lookahead);
}

/// Backward pass from the newest waiting frame; the first `count` frames are answered by filtered × backward.
std::vector<Localization> Localizer::Impl::settle(std::size_t count) {
  std::vector<Localization> answers(count);
  std::vector<float> ahead(state.size(), 1.0F), before(state.size());
  for (std::size_t t = waiting.size(); t-- > 0;) {
    Waiting& frame = waiting[t];
    if (t < count) {
      std::vector<float> both(state.size());
      for (std::size_t s = 0; s < both.size(); ++s) both[s] = frame.filtered[s] * ahead[s];
      setBelief(frame.answer, both, frame.likelihood);
      answers[t] = frame.answer;
    }
    if (!frame.step) continue;
    filter->observe(frame.likelihood, ahead);
    filter->backward(ahead, *frame.step, before);
    std::swap(ahead, before);
    const float scale = 1 / *std::max_element(ahead.begin(), ahead.end());
    for (float& value : ahead) value *= scale;
  }
  waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(count));
  return answers;
}

void Localizer::Impl::setBelief(Localization& answer, std::span<const float> belief,
                                std::span<const float> likelihood) const {
  const Belief found = filter->belief(belief, likelihood);
  const auto frameOf = [this](std::size_t image) { return image * source->stride; };
  std::tie(answer.beliefNode, answer.confidence) =
      mostProbable(found.nearest, [&](std::size_t image) { return map().frames[frameOf(image)].node; });
  if (!zoneOf.empty())
    std::tie(answer.beliefZone, answer.zoneConfidence) =
        mostProbable(found.nearest, [&](std::size_t image) { return zoneOf[frameOf(image)]; });
  const double all = std::accumulate(found.nearest.begin(), found.nearest.end(), 0.0);
  if (found.unmapped) answer.unmapped = *found.unmapped / all;
  if (found.unvisited) answer.unvisited = *found.unvisited / all;
  answer.beliefImage = largest(found.images) * source->stride;
}

Localizer::Localizer(std::shared_ptr<const LocalizerMap> map, const LocalizerOptions& options)
    : impl_(std::make_unique<Impl>(std::move(map), options)) {}
Localizer::Localizer(const std::filesystem::path& map, const LocalizerOptions& options)
    : Localizer(std::make_shared<const LocalizerMap>(readLocalizerMap(map, validated(options).maxImages)),
                options) {}
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;
Localizer::~Localizer() = default;

const TopologicalMap& Localizer::map() const {
  return impl_->map();
}

void Localizer::setZones(std::vector<int> zoneOf) {
  if (zoneOf.size() != map().frames.size())
    fail(ErrorCode::mismatch, "{} zones do not belong to {} frames; give one a frame", zoneOf.size(),
         map().frames.size());
  impl_->zoneOf = std::move(zoneOf);
}

std::vector<Localization> Localizer::add(DescriptorView descriptor, const std::optional<Pose>& odometry) {
  return impl_->add(descriptor, odometry);
}

std::string Localizer::state() const {
  ByteWriter out;
  out.number<std::uint8_t>(impl_->started ? 1 : 0);
  out.numbers(impl_->state);
  const PlanarMotion& moved = impl_->moved;
  for (const double value : {moved.forward, moved.left, moved.turn, moved.looseDistance, moved.looseTurn})
    out.number(value);
  if (impl_->last) write(out, *impl_->last);
  return out.bytes();
}

void Localizer::restore(const std::string& state) {
  ByteReader in(state, "the saved belief is damaged", "map the sequence again");
  impl_->started = in.number<std::uint8_t>() != 0;
  std::vector<float> belief = in.numbers<float>();
  PlanarMotion& moved = impl_->moved;
  for (double* value : {&moved.forward, &moved.left, &moved.turn, &moved.looseDistance, &moved.looseTurn})
    if (*value = in.number<double>(); !std::isfinite(*value))
      in.fail("a number is not finite", ErrorCode::corruptFile);
  if (in.remaining() > 0) impl_->last = readPose(in, ErrorCode::corruptFile);
  const auto isShare = [](float p) { return p >= 0 && p <= 1; };
  if (in.remaining() > 0 || belief.size() != impl_->state.size() || !std::ranges::all_of(belief, isShare))
    in.fail("it is of another map", ErrorCode::corruptFile);
  impl_->state = std::move(belief);
}

std::vector<Localization> Localizer::finish() {
  return impl_->settle(impl_->waiting.size());
}

}  // namespace estancia
