// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/linkage.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Two clusters, each by one of its leaves, that merge at a height.
struct Link {
  std::size_t a, b;
  double height;
};

/// Reports merges every now and then, and asks whether to go on.
class MergeProgress {
 public:
  MergeProgress(Progress& progress, std::size_t merges) : progress_(progress) {
    progress_.begin("linkage", merges);
  }
  void advance() {
    if (++waiting_ < 64) return;
    if (interrupted()) throw Interrupted("stopped while clusters were merged");
    report();
  }
  void end() {
    report();
    progress_.end();
  }

 private:
  void report() { progress_.advance(std::exchange(waiting_, 0)); }
  Progress& progress_;
  std::size_t waiting_ = 0;
};

/// Distance of a cluster of n items to a (of na) and b (nb) merged at dab (Lance and Williams 1967).
double afterMerge(Linkage linkage, double da, double db, double dab, double na, double nb, double n) {
  switch (linkage) {
    case Linkage::single:
      return std::min(da, db);
    case Linkage::complete:
      return std::max(da, db);
    case Linkage::average:
      return (na * da + nb * db) / (na + nb);
    case Linkage::weighted:
      return 0.5 * (da + db);
    case Linkage::ward: {
      const double share = 1 / (na + nb + n);
      return std::sqrt(
          std::max(0.0, (n + na) * share * da * da + (n + nb) * share * db * db - n * share * dab * dab));
    }
  }
  throw Error(ErrorCode::invalidOption, "the linkage is none of Linkage; give one of its values");
}

/// The distances of the remaining clusters. A cluster has the position of its last leaf. Positions of merged
/// clusters are dropped when they are many, so that the rest stays dense in memory.
class Clusters {
 public:
  Clusters(CondensedDistances& distances, Linkage linkage, const std::vector<std::size_t>& sizes)
      : values_(distances.values().data()),
        linkage_(linkage),
        places_(distances.items()),
        alive_(distances.items()),
        sizes_(distances.items(), 1.0),
        leaves_(distances.items()) {
    std::copy(sizes.begin(), sizes.end(), sizes_.begin());
    std::iota(leaves_.begin(), leaves_.end(), std::size_t{0});
  }

  std::size_t alive() const { return alive_; }
  std::size_t leaf(std::size_t place) const { return leaves_[place]; }
  bool isAlive(std::size_t place) const { return sizes_[place] > 0; }
  double distance(std::size_t i, std::size_t j) const { return i < j ? at(i, j) : at(j, i); }

  struct Neighbor {
    std::size_t place;
    double distance;
  };
  /// The first of the nearest clusters; `nearest` itself when none is nearer.
  Neighbor nearestTo(std::size_t place, Neighbor nearest) const {
    for (std::size_t i = 0; i < place; ++i) {
      if (i + ahead < place) __builtin_prefetch(&at(i + ahead, place));
      if (sizes_[i] > 0 && at(i, place) < nearest.distance) nearest = {i, at(i, place)};
    }
    const double* row = values_ + rowOf(place) - place - 1;
    for (std::size_t i = place + 1; i < places_; ++i)
      if (row[i] < nearest.distance && sizes_[i] > 0) nearest = {i, row[i]};
    return nearest;
  }

  /// a becomes part of b; a < b.
  void merge(std::size_t a, std::size_t b, double height) {
    const double na = sizes_[a], nb = sizes_[b];
    const auto update = [&](std::size_t i, double da, double& db) {
      if (sizes_[i] > 0) db = afterMerge(linkage_, da, db, height, na, nb, sizes_[i]);
    };
    for (std::size_t i = 0; i < a; ++i) update(i, at(i, a), at(i, b));
    for (std::size_t i = a + 1; i < b; ++i) update(i, at(a, i), at(i, b));
    for (std::size_t i = b + 1; i < places_; ++i) update(i, at(a, i), at(b, i));
    sizes_[a] = 0;
    sizes_[b] = na + nb;
    --alive_;
  }

  bool isSparse() const { return places_ > minPlaces && alive_ * 4 < places_ * 3; }

  /// Drops the positions of merged clusters in order. Returns the new position of each old one.
  std::vector<std::size_t> compact() {
    std::vector<std::size_t> kept, moved(places_);
    for (std::size_t i = 0; i < places_; ++i) {
      moved[i] = kept.size();
      if (isAlive(i)) kept.push_back(i);
    }
    double* to = values_;
    for (std::size_t i = 0; i < kept.size(); ++i)
      for (std::size_t j = i + 1; j < kept.size(); ++j) *to++ = at(kept[i], kept[j]);
    for (std::size_t i = 0; i < kept.size(); ++i) {
      sizes_[i] = sizes_[kept[i]];
      leaves_[i] = leaves_[kept[i]];
    }
    places_ = kept.size();
    return moved;
  }

 private:
  static constexpr std::size_t ahead = 16, minPlaces = 64;
  std::size_t rowOf(std::size_t i) const { return i * (2 * places_ - i - 1) / 2; }
  double& at(std::size_t i, std::size_t j) const { return values_[rowOf(i) + j - i - 1]; }

  double* values_;
  Linkage linkage_;
  std::size_t places_, alive_;
  std::vector<double> sizes_;  // 0: merged
  std::vector<std::size_t> leaves_;
};

/// Follows nearest neighbors from any cluster until two are each other's nearest. With these linkages (they
/// are reducible) the two stay so whatever else merges, so they merge now.
std::vector<Link> nearestNeighborChain(CondensedDistances& distances, Linkage linkage,
                                       const std::vector<std::size_t>& sizes, Progress& progress) {
  Clusters clusters(distances, linkage, sizes);
  MergeProgress merging(progress, distances.items() - 1);
  std::vector<Link> links;
  std::vector<std::size_t> chain;
  std::size_t first = 0;
  while (clusters.alive() > 1) {
    if (chain.empty()) {
      while (!clusters.isAlive(first)) ++first;
      chain.push_back(first);
    }
    Clusters::Neighbor nearest{0, infinity};
    for (;;) {
      const std::size_t end = chain.back();
      const bool begun = chain.size() == 1;
      const std::size_t before = begun ? end : chain[chain.size() - 2];
      nearest = clusters.nearestTo(end, {before, begun ? infinity : clusters.distance(before, end)});
      if (!begun && nearest.place == before) break;
      chain.push_back(nearest.place);
    }
    const auto [a, b] = std::minmax({chain.back(), nearest.place});
    chain.resize(chain.size() - 2);
    links.push_back({clusters.leaf(a), clusters.leaf(b), nearest.distance});
    clusters.merge(a, b, nearest.distance);
    if (clusters.isSparse()) {
      const std::vector<std::size_t> moved = clusters.compact();
      for (std::size_t& place : chain) place = moved[place];
      first = 0;
    }
    merging.advance();
  }
  merging.end();
  return links;
}

/// The tree grows by the item nearest to it (Prim 1957), linked with the one before: all between are nearer.
std::vector<Link> spanningTree(const CondensedDistances& distances, Progress& progress) {
  const std::size_t n = distances.items();
  MergeProgress merging(progress, n - 1);
  std::vector<double> toTree(n, infinity);
  std::vector<char> inTree(n, 0);
  std::vector<Link> links;
  std::size_t last = 0;
  while (links.size() + 1 < n) {
    inTree[last] = 1;
    std::size_t nearest = n;
    double smallest = infinity;
    for (std::size_t i = 0; i < n; ++i) {
      if (inTree[i] != 0) continue;
      toTree[i] = std::min(toTree[i], distances(last, i));
      if (toTree[i] < smallest) {
        nearest = i;
        smallest = toTree[i];
      }
    }
    links.push_back({last, nearest, smallest});
    last = nearest;
    merging.advance();
  }
  merging.end();
  return links;
}

/// Sorts links by height and numbers the clusters that they join.
Dendrogram dendrogramOf(std::size_t leaves, std::vector<Link> links, const std::vector<std::size_t>& sizes) {
  std::stable_sort(links.begin(), links.end(),
                   [](const Link& a, const Link& b) { return a.height < b.height; });
  std::vector<std::size_t> parent(leaves + links.size()), size(leaves, 1);
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  std::copy(sizes.begin(), sizes.end(), size.begin());
  const auto rootOf = [&](std::size_t cluster) {
    while (parent[cluster] != cluster) cluster = parent[cluster] = parent[parent[cluster]];
    return cluster;
  };
  std::vector<Dendrogram::Merge> merges;
  for (const Link& link : links) {
    const auto [left, right] = std::minmax({rootOf(link.a), rootOf(link.b)});
    size.push_back(size[left] + size[right]);
    parent[left] = parent[right] = leaves + merges.size();
    merges.push_back({left, right, link.height, size.back()});
  }
  return {leaves, std::move(merges)};
}

void requireValid(const CondensedDistances& distances, const std::vector<std::size_t>& sizes) {
  constexpr double maximum = 1e100;  // sums of its squares are finite
  const auto values = distances.values();
  const auto wrong = std::ranges::find_if(values, [](double d) { return !(d >= 0 && d <= maximum); });
  if (wrong != values.end()) {
    auto rest = static_cast<std::size_t>(wrong - values.begin());
    std::size_t item = 0;
    for (std::size_t row = distances.items() - 1; rest >= row; ++item) rest -= row--;
    fail(ErrorCode::invalidInput, "the distance of items {} and {} is {}; give distances from 0 to {}", item,
         item + 1 + rest, *wrong, maximum);
  }
  if (sizes.empty()) return;
  if (sizes.size() != distances.items() || std::count(sizes.begin(), sizes.end(), std::size_t{0}) > 0)
    fail(ErrorCode::invalidInput, "there are {} sizes for {} leaves; give one of at least 1 each",
         sizes.size(), distances.items());
}

}  // namespace

Dendrogram::Dendrogram(std::size_t leaves, std::vector<Merge> merges)
    : leaves_(leaves), merges_(std::move(merges)) {
  if (merges_.size() + 1 != std::max<std::size_t>(leaves_, 1))
    fail(ErrorCode::invalidInput, "a dendrogram of {} leaves has {} merges; give one less than leaves",
         leaves_, merges_.size());
  std::vector<char> merged(leaves_ + merges_.size(), 0);
  for (std::size_t k = 0; k < merges_.size(); ++k) {
    const Merge& merge = merges_[k];
    const bool inOrder = k == 0 ? merge.height >= 0 : merge.height >= merges_[k - 1].height;
    if (!inOrder || merge.left >= merge.right || merge.right >= leaves_ + k || merged[merge.left] != 0 ||
        merged[merge.right] != 0)
      fail(ErrorCode::invalidInput,
           "merge {} of a dendrogram joins clusters {} and {} at "
           "{}; give merges by height, of clusters that exist",
           k, merge.left, merge.right, merge.height);
    merged[merge.left] = merged[merge.right] = 1;
  }
}

std::vector<int> Dendrogram::cutAt(double distance) const {
  if (std::isnan(distance))
    throw Error(ErrorCode::invalidInput, "the distance of a cut is NaN; give a number");
  const auto above = std::partition_point(
      merges_.begin(), merges_.end(), [distance](const Merge& merge) { return merge.height <= distance; });
  return afterMerges(static_cast<std::size_t>(above - merges_.begin()));
}

std::vector<int> Dendrogram::cutInto(std::size_t clusters) const {
  if (clusters > leaves_ || (clusters == 0 && leaves_ > 0))
    fail(ErrorCode::invalidInput, "{} images cannot form {} clusters; choose 1 to {}", leaves_, clusters,
         leaves_);
  return afterMerges(leaves_ - clusters);
}

std::vector<int> Dendrogram::afterMerges(std::size_t count) const {
  std::vector<std::size_t> parent(leaves_ + count);  // its own: a root
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  for (std::size_t k = 0; k < count; ++k) parent[merges_[k].left] = parent[merges_[k].right] = leaves_ + k;
  for (std::size_t i = parent.size(); i-- > 0;) parent[i] = parent[parent[i]];  // parents come after children
  std::vector<int> number(parent.size(), -1), clusters(leaves_);
  int next = 0;
  for (std::size_t leaf = 0; leaf < leaves_; ++leaf) {
    int& own = number[parent[leaf]];
    if (own < 0) own = next++;
    clusters[leaf] = own;
  }
  return clusters;
}

Choices linkages() {
  return {{"average", "the mean over all pairs of images (thesis Algorithm 5.1)"},
          {"ward", "how much a merge increases the squared distances from the means"},
          {"complete", "the farthest images"},
          {"weighted", "the mean over the two clusters last merged"},
          {"single", "the nearest images"}};
}

Linkage getLinkage(std::string_view name) {
  requireChoice("linkage", name, linkages());
  if (name == "average") return Linkage::average;
  if (name == "ward") return Linkage::ward;
  if (name == "complete") return Linkage::complete;
  return name == "weighted" ? Linkage::weighted : Linkage::single;
}

Comparison comparisonFor(const Distance& distance, Linkage linkage) {
  if (distance.sigmaWeighted)
    fail(ErrorCode::invalidOption,
         "{} weights labels by their deviation within a place, and single images have none; choose a "
         "distance without -sigma, for the weighted ones l2",
         distance.name);
  if (linkage != Linkage::ward) return distance.comparison;
  const auto fits = [](Comparison c) { return c == Comparison::euclidean || c == Comparison::cosine; };
  if (fits(distance.comparison)) return Comparison::euclidean;
  std::vector<std::string> fitting;
  for (const Distance& other : baseDistances())
    if (fits(other.comparison)) fitting.push_back(other.name);
  fail(ErrorCode::invalidOption,
       "Ward's linkage needs a Euclidean distance, and {} is not; choose one of {}, or another linkage",
       distance.name, fmt::join(fitting, ", "));
}

Dendrogram link(CondensedDistances distances, Linkage linkage, const std::vector<std::size_t>& sizes,
                Progress& progress) {
  requireValid(distances, sizes);
  const std::size_t n = distances.items();
  if (n < 2) return {n, {}};
  if (linkage == Linkage::ward && !sizes.empty())
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) {
        const auto a = static_cast<double>(sizes[i]), b = static_cast<double>(sizes[j]);
        distances.after(i)[j - i - 1] *= std::sqrt(2 * a * b / (a + b));
      }
  return dendrogramOf(n,
                      linkage == Linkage::single ? spanningTree(distances, progress)
                                                 : nearestNeighborChain(distances, linkage, sizes, progress),
                      sizes);
}

std::uint64_t clusteringMemory(std::size_t items, std::size_t labels) {
  // Three copies of the descriptors, as compared and twice as packed; the chain and the dendrogram.
  const auto product = static_cast<double>(items) * (static_cast<double>(labels) * 3 * sizeof(float) + 128) +
                       static_cast<double>(CondensedDistances::bytes(items));
  return product < 0x1p63 ? static_cast<std::uint64_t>(product) : std::uint64_t{1} << 63;
}

void requireClusteringMemory(std::size_t items, std::size_t labels, std::uint64_t available) {
  const std::uint64_t needed = clusteringMemory(items, labels);
  if (needed <= available) return;
  fail(ErrorCode::tooLarge,
       "exact clustering of {} images needs {:.1f} GiB of memory, and {:.1f} GiB are available; "
       "use the streaming mode (estancia zones find --stream), or take fewer images",
       items, static_cast<double>(needed) / (1 << 30), static_cast<double>(available) / (1 << 30));
}

}  // namespace estancia
