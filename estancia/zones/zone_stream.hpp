// Zones that keep up with a robot while it drives, in bounded memory and time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/compared_vectors.hpp"
#include "estancia/stats/distance.hpp"
#include "estancia/stats/label_scale.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

struct ZoneStreamOptions {
  /// At most so many groups of like images stand for the run, ≥ 2. More are nearer to the exact result, and
  /// slower by their square.
  std::size_t groups = 512;
  /// The groups are linked and cut anew after so many images, ≥ 1; in between an image is in the zone of its
  /// group. 20 are less than a second of driving.
  std::size_t relinkEvery = 20;
};

/// A zone as a stream knows it.
struct StreamedZone {
  int id = 0;        ///< kept as long as most of the zone's images stay together; never given to another
  std::string name;  ///< its most telling words
  std::uint64_t images = 0;
  std::vector<float> mean, sigma;  ///< of each label's probability
};

/// Every image begins as a group of its own; while there are more groups than allowed, the two nearest become
/// one, as the linkage measures it. Zones are the linkage of the groups' means, weighted by their images, and
/// cut as findZones() cuts: until the groups are used up, exactly what findZones() gives. Groups of like
/// items under the tree are an idea of BIRCH (Zhang et al. 1996); here no threshold is needed. O(groups · L)
/// an image, O(groups²) every `relinkEvery` images; O(groups · L) memory and two numbers an image.
class ZoneStream {
 public:
  /// Throws Error for unknown names and options that do not go together, as findZones() does.
  explicit ZoneStream(Vocabulary vocabulary, const ZoneOptions& options = {},
                      const ZoneStreamOptions& stream = {});

  /// Returns the image's zone as things stand. Throws Error unless the descriptor holds one probability a
  /// label.
  int add(DescriptorView descriptor);

  /// Takes what came since into account: linked and cut anew by all images so far.
  void update();

  std::size_t images() const { return groupOf_.size(); }
  std::size_t groups() const { return groups_.size(); }
  double cut() const { return cut_; }  ///< τ_d of the last linking
  const std::string& cutReason() const { return cutReason_; }
  std::size_t zoneCount() const;
  std::vector<int> zoneOf() const;          ///< of every image so far
  std::vector<StreamedZone> zones() const;  ///< by falling size
  /// The most telling words of a zone. Throws Error when there is none of that number.
  std::string nameOf(int zone) const;

 private:
  struct Group {
    std::vector<std::size_t> images;
    Moments embedded;           ///< of their embedded descriptors
    Moments probabilities;      ///< and of the descriptors themselves
    std::vector<float> vector;  ///< the mean as it is compared
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
  void merge(std::size_t kept, std::size_t absorbed);
  void remove(std::size_t i);
  CondensedDistances condensed() const;
  void number(const std::vector<int>& clusters);  // zones of the groups, by their numbers of before

  Vocabulary vocabulary_;
  ZoneOptions zoneOptions_;
  ZoneStreamOptions options_;
  Distance distance_;
  Linkage linkage_;
  Comparison comparison_;
  Moments embedded_;       ///< of all images, by which a standardized distance scales
  Moments probabilities_;  ///< of all images
  Standardization standardization_;
  std::size_t imagesOfScale_ = 0;  ///< that the standardization is made of
  std::size_t sinceLinked_ = 0;    ///< images
  std::vector<Group> groups_;
  std::vector<double> distances_;     ///< of all pairs of groups
  std::vector<std::size_t> nearest_;  ///< the other group that each is cheapest to merge with
  std::vector<std::size_t> groupOf_;  ///< of each image
  double cut_ = 0;
  std::string cutReason_;
  int nextZone_ = 0;
};

/// How far a stream's zones are from those that findZones() makes of the same images.
struct StreamAgreement {
  std::size_t images = 0;  ///< that were compared
  std::size_t zones = 0;   ///< that findZones() makes of them
  Agreement agreement;     ///< of the two, as if findZones() told the truth
};

/// Compares `zoneOf`, the stream's zones of the recording's frames, on all images or, where there are more
/// than `most`, on so many spread evenly over the run. Throws as findZones() does.
StreamAgreement compareWithExact(const DescriptorSequence& recording, std::span<const int> zoneOf,
                                 const ZoneOptions& options, Progress& progress, std::size_t most = 5000);

}  // namespace estancia
