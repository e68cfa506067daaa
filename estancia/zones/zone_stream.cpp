// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/zone_stream.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "estancia/core/fail.hpp"
#include "estancia/stats/label_scale.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/words/label_concepts.hpp"
#include "estancia/zones/image_tree.hpp"
#include "estancia/zones/naming.hpp"

namespace estancia {
namespace {

constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

}  // namespace

OptionGroup declare(ZoneStreamOptions& options) {
  OptionGroup group("zone-stream", "How zones are kept up to date while images come.");
  group.add("groups", &options.groups, "At most this many groups of similar images stand for the run.")
      .range(2, 20'000)  // a matrix of 3 GiB
      .why("More are nearer to the exact zones, and slower by their square.");
  return group;
}

/// State of zones that are found while frames come. Invariant: each frame belongs to one group, and the
/// moments of a group are those of its frames. Life cycle: add() in the order of the frames; zones are
/// derived from the groups on request.
struct ZoneStream::Impl {
  Impl(Vocabulary words, const ZoneOptions& zoneOptions, const ZoneStreamOptions& stream);

  struct Group {
    std::vector<std::size_t> images;
    /// Moments of the embedded descriptors, and of the descriptors themselves.
    Moments embedded, probabilities;
    /// The mean as it is compared.
    std::vector<float> compared;
    int zone = -1;
  };

  double& distance(std::size_t i, std::size_t j) { return distances_[i * (options_.groups + 1) + j]; }
  double distance(std::size_t i, std::size_t j) const { return distances_[i * (options_.groups + 1) + j]; }
  double mergeCost(std::size_t i, std::size_t j) const;
  void measure(std::size_t i);      // distances of a group whose vector is new
  void findNearest(std::size_t i);  // among the others
  void rescale();                   // vectors and distances by the run as it is now
  bool scaleIsOlderThan(double growth) const;
  void relink();
  void mergeNearest();
  void remove(std::size_t i);
  void number(const std::vector<int>& clusters);  // zones of the groups, by their numbers of before
  std::vector<std::string> names(const std::vector<std::vector<float>>& means) const;

  int add(DescriptorView descriptor);
  std::size_t images() const { return groupOf_.size(); }

  Vocabulary vocabulary_;
  ZoneOptions zoneOptions_;
  ZoneStreamOptions options_;
  Distance distance_;
  Linkage linkage_;
  Comparison comparison_;
  Moments embedded_;       ///< moments of all images, by which a standardized distance scales
  Moments probabilities_;  ///< moments of all images
  Standardization standardization_;
  std::size_t imagesOfScale_ = 0;  ///< images that the standardization is made of
  std::size_t sinceLinked_ = 0;    ///< images
  std::vector<Group> groups_;
  std::vector<double> distances_;     ///< distances of all pairs of groups
  std::vector<std::size_t> nearest_;  ///< the other group that each is cheapest to merge with
  std::vector<std::size_t> groupOf_;  ///< group of each image
  double cut_ = 0;
  std::string cutReason_;
  int nextZone_ = 0;
};

ZoneStream::Impl::Impl(Vocabulary words, const ZoneOptions& zoneOptions, const ZoneStreamOptions& stream)
    : vocabulary_(std::move(words)),
      zoneOptions_(zoneOptions),
      options_(stream),
      distance_(getDistance(zoneOptions.distance, vocabulary_.layout().parts)),
      linkage_(getLinkage(zoneOptions.linkage)),
      comparison_(comparisonFor(distance_, linkage_)),
      embedded_(vocabulary_.size(), true),
      probabilities_(vocabulary_.size(), false) {
  validate(zoneOptions);
  validate(stream);
  if (stream.relinkEvery == 0)
    fail(ErrorCode::invalidOption, "zone-stream.relink-every is 0; give at least 1");
  if (zoneOptions.reach.value_or(0) > 0)
    throw Error(
        ErrorCode::invalidOption,
        "a stream compares each image by itself; leave out zones.reach, or find zones of the whole run");
  if (zoneOptions.count && *zoneOptions.count > stream.groups)
    fail(ErrorCode::invalidOption, "zones.count is {}, but the stream has {} groups; give 1 to {}",
         *zoneOptions.count, stream.groups, stream.groups);
  distances_.resize((stream.groups + 1) * (stream.groups + 1));
}

int ZoneStream::Impl::add(DescriptorView descriptor) {
  const std::size_t labels = vocabulary_.size();
  requireProbabilities(descriptor, labels, "an image of the stream");
  std::vector<float> embedded(labels);
  embed(distance_.embedding, descriptor, embedded, distance_.parts);
  embedded_.add(embedded);
  probabilities_.add(descriptor);
  Group& group =
      groups_.emplace_back(Group{{images()}, Moments(labels, false), Moments(labels, true), {}, -1});
  group.embedded.add(embedded);
  group.probabilities.add(descriptor);
  groupOf_.push_back(groups_.size() - 1);
  nearest_.push_back(none);
  const std::size_t added = groups_.size() - 1;
  if (scaleIsOlderThan(1.25)) {
    rescale();
  } else {
    group.compared = comparedVector(distance_, standardization_, group.embedded.mean());
    measure(added);
  }
  if (nearest_[added] != none) groups_[added].zone = groups_[nearest_[added]].zone;
  while (groups_.size() > options_.groups) mergeNearest();
  if (++sinceLinked_ >= options_.relinkEvery || images() <= options_.relinkEvery) relink();
  return groups_[groupOf_.back()].zone;
}

/// Whether the run has more than `growth` times the images that its labels were standardized by.
bool ZoneStream::Impl::scaleIsOlderThan(double growth) const {
  return distance_.standardized &&
         static_cast<double>(images()) > growth * static_cast<double>(imagesOfScale_);
}

/// Merge cost by the linkage: Ward's merges cost more the more images they move.
double ZoneStream::Impl::mergeCost(std::size_t i, std::size_t j) const {
  if (linkage_ != Linkage::ward) return distance(i, j);
  const auto a = static_cast<double>(groups_[i].images.size()),
             b = static_cast<double>(groups_[j].images.size());
  return std::sqrt(2 * a * b / (a + b)) * distance(i, j);
}

void ZoneStream::Impl::measure(std::size_t i) {
  for (std::size_t j = 0; j < groups_.size(); ++j)
    if (j != i)
      distance(i, j) = distance(j, i) = compare(comparison_, groups_[i].compared, groups_[j].compared);
  findNearest(i);
  for (std::size_t j = 0; j < groups_.size(); ++j) {
    if (j == i) continue;
    if (nearest_[j] == i)
      findNearest(j);
    else if (nearest_[j] == none || mergeCost(j, i) < mergeCost(j, nearest_[j]))
      nearest_[j] = i;
  }
}

void ZoneStream::Impl::findNearest(std::size_t i) {
  nearest_[i] = none;
  for (std::size_t j = 0; j < groups_.size(); ++j)
    if (j != i && (nearest_[i] == none || mergeCost(i, j) < mergeCost(i, nearest_[i]))) nearest_[i] = j;
}

void ZoneStream::Impl::rescale() {
  standardization_ = standardizationBy(embedded_);
  imagesOfScale_ = images();
  DescriptorMatrix vectors(vocabulary_.size());
  for (Group& group : groups_) {
    group.compared = comparedVector(distance_, standardization_, group.embedded.mean());
    vectors.append(group.compared);
  }
  const CondensedDistances all = pairwiseDistances(vectors, comparison_, zoneOptions_.threads);
  for (std::size_t i = 0; i < groups_.size(); ++i)
    for (std::size_t j = i + 1; j < groups_.size(); ++j) distance(i, j) = distance(j, i) = all(i, j);
  for (std::size_t i = 0; i < groups_.size(); ++i) findNearest(i);
}

void ZoneStream::Impl::mergeNearest() {
  std::size_t best = 0;
  for (std::size_t i = 1; i < groups_.size(); ++i)
    if (mergeCost(i, nearest_[i]) < mergeCost(best, nearest_[best])) best = i;
  const std::size_t kept = std::min(best, nearest_[best]), absorbed = std::max(best, nearest_[best]);
  Group &into = groups_[kept], &from = groups_[absorbed];
  if (into.images.size() < from.images.size()) into.zone = from.zone;
  into.embedded.merge(from.embedded);
  into.probabilities.merge(from.probabilities);
  into.compared = comparedVector(distance_, standardization_, into.embedded.mean());
  for (const std::size_t image : from.images) groupOf_[image] = kept;
  into.images.insert(into.images.end(), from.images.begin(), from.images.end());
  remove(absorbed);
  measure(kept);
}

/// The last group takes the place of group i. The nearest of those that were nearest to i is found anew.
void ZoneStream::Impl::remove(std::size_t i) {
  const std::size_t last = groups_.size() - 1;
  if (i != last) {
    groups_[i] = std::move(groups_[last]);
    for (const std::size_t image : groups_[i].images) groupOf_[image] = i;
    for (std::size_t j = 0; j < last; ++j) distance(i, j) = distance(j, i) = distance(last, j);
    nearest_[i] = nearest_[last];
  }
  groups_.pop_back();
  nearest_.pop_back();
  for (std::size_t j = 0; j < groups_.size(); ++j) {
    if (nearest_[j] == i)
      findNearest(j);
    else if (nearest_[j] == last)
      nearest_[j] = i;
  }
}

void ZoneStream::Impl::relink() {
  CondensedDistances all(groups_.size());
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    std::copy_n(&distance(i, 0) + i + 1, groups_.size() - i - 1, all.after(i));
    sizes.push_back(groups_[i].images.size());
  }
  NearestItems neighbors = findNeighbors(all, neighborsForCut(images()));
  weighBySize(neighbors, sizes);
  const Dendrogram tree = link(std::move(all), linkage_, sizes);
  ZoneOptions options = zoneOptions_;
  if (options.count) options.count = std::min(*options.count, groups_.size());  // at the start of a run
  ZoneCut cut = cutTree(tree, neighbors, options);
  number(cut.groups);
  cut_ = cut.distance;
  cutReason_ = std::move(cut.reason);
  sinceLinked_ = 0;
}

void ZoneStream::Impl::number(const std::vector<int>& clusters) {
  std::map<std::pair<int, int>, std::size_t> shared;  // images of cluster and former zone
  for (std::size_t i = 0; i < groups_.size(); ++i)
    shared[{clusters[i], groups_[i].zone}] += groups_[i].images.size();
  std::vector<std::tuple<std::size_t, int, int>> byImages;
  for (const auto& [pair, images] : shared)
    if (pair.second >= 0) byImages.emplace_back(images, pair.first, pair.second);
  std::stable_sort(byImages.begin(), byImages.end(),
                   [](const auto& a, const auto& b) { return std::get<0>(a) > std::get<0>(b); });
  std::map<int, int> zoneOf, clusterOf;
  for (const auto& [images, cluster, zone] : byImages)
    if (!zoneOf.contains(cluster) && !clusterOf.contains(zone)) {
      zoneOf[cluster] = zone;
      clusterOf[zone] = cluster;
    }
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const auto [entry, isNew] = zoneOf.emplace(clusters[i], nextZone_);
    if (isNew) ++nextZone_;
    groups_[i].zone = entry->second;
  }
}

std::vector<std::string> ZoneStream::Impl::names(const std::vector<std::vector<float>>& means) const {
  return nameZones(vocabulary_, means, probabilities_.mean(),
                   *installedConcepts(vocabulary_, zoneOptions_.naming));
}

ZoneStream::ZoneStream(Vocabulary vocabulary, const ZoneOptions& options, const ZoneStreamOptions& stream)
    : impl_(std::make_unique<Impl>(std::move(vocabulary), options, stream)) {}
ZoneStream::ZoneStream(ZoneStream&&) noexcept = default;
ZoneStream& ZoneStream::operator=(ZoneStream&&) noexcept = default;
ZoneStream::~ZoneStream() = default;

int ZoneStream::add(DescriptorView descriptor) {
  return impl_->add(descriptor);
}

void ZoneStream::update() {
  if (impl_->groups_.empty()) return;
  if (impl_->scaleIsOlderThan(1)) impl_->rescale();
  impl_->relink();
}

Zones ZoneStream::finish(const DescriptorSequence& sequence) {
  const ZoneOptions& options = impl_->zoneOptions_;
  if (options.count && *options.count > images())
    fail(ErrorCode::invalidOption, "zones.count is {}; give 1 to {}, the number of images", *options.count,
         images());
  update();
  Zones zones = describeZones(sequence, zoneOf(), options.naming);
  zones.distance = options.distance;
  zones.linkage = options.linkage;
  zones.cut = cut();
  zones.cutReason = cutReason();
  return zones;
}

std::size_t ZoneStream::images() const {
  return impl_->images();
}

std::size_t ZoneStream::groups() const {
  return impl_->groups_.size();
}

double ZoneStream::cut() const {
  return impl_->cut_;
}

const std::string& ZoneStream::cutReason() const {
  return impl_->cutReason_;
}

std::size_t ZoneStream::zoneCount() const {
  std::set<int> zones;
  for (const Impl::Group& group : impl_->groups_) zones.insert(group.zone);
  return zones.size();
}

std::vector<int> ZoneStream::zoneOf() const {
  std::vector<int> zones;
  for (const std::size_t group : impl_->groupOf_) zones.push_back(impl_->groups_[group].zone);
  return zones;
}

std::vector<StreamedZone> ZoneStream::zones() const {
  std::map<int, Moments> moments;
  for (const Impl::Group& group : impl_->groups_) {
    const auto [entry, isNew] = moments.emplace(group.zone, group.probabilities);
    if (!isNew) entry->second.merge(group.probabilities);
  }
  std::vector<StreamedZone> zones;
  for (const auto& [id, of] : moments) {
    StreamedZone zone{id, "", static_cast<std::uint64_t>(std::llround(of.weight())), {}, {}};
    zone.mean.assign(of.mean().begin(), of.mean().end());
    for (const float variance : of.variance()) zone.sigma.push_back(std::sqrt(variance));
    zones.push_back(std::move(zone));
  }
  std::stable_sort(zones.begin(), zones.end(),
                   [](const StreamedZone& a, const StreamedZone& b) { return a.images > b.images; });
  std::vector<std::vector<float>> means;
  for (const StreamedZone& zone : zones) means.push_back(zone.mean);
  const std::vector<std::string> names = impl_->names(means);
  for (std::size_t i = 0; i < zones.size(); ++i) zones[i].name = names[i];
  return zones;
}

std::string ZoneStream::nameOf(int zone) const {
  Moments mean(impl_->vocabulary_.size(), false);
  for (const Impl::Group& group : impl_->groups_)
    if (group.zone == zone) mean.add(group.probabilities.mean(), group.probabilities.weight());
  if (mean.weight() == 0) fail(ErrorCode::unknownName, "the stream has no zone {} now", zone);
  return impl_->names({{mean.mean().begin(), mean.mean().end()}}).front();
}

}  // namespace estancia
