// Zone stream: zones that are kept up to date while a robot drives, in bounded memory and time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

struct ZoneStreamOptions {
  std::size_t groups = 512;
  /// The groups are linked and cut again after this many images, which are less than a second of driving. In
  /// between, an image is in the zone of its group.
  std::size_t relinkEvery = 20;
};
/// Declares the options and their ranges.
OptionGroup declare(ZoneStreamOptions& options);

/// A zone as a stream knows it.
struct StreamedZone {
  /// Kept as long as most of the zone's images stay together; never given to another zone.
  int id = 0;
  /// Its most distinctive labels.
  std::string name;
  std::uint64_t images = 0;
  /// Mean and standard deviation of each label's probability.
  std::vector<float> mean, sigma;
};

/// Every image begins as a group of its own; while there are more groups than allowed, the two nearest are
/// merged, as the linkage measures it. Zones are the linkage of the groups' means, weighted by their images,
/// and cut as findZones() cuts: until the groups are used up, exactly what findZones() gives. Groups of
/// similar items under the tree are an idea of BIRCH (Zhang et al. 1996); here no threshold is needed.
/// O(groups · L) an image, O(groups²) every `relinkEvery` images; O(groups · L) memory and two numbers an
/// image.
class ZoneStream {
 public:
  /// Throws Error (invalidOption, unknownName) as findZones() does.
  explicit ZoneStream(Vocabulary vocabulary, const ZoneOptions& options = {},
                      const ZoneStreamOptions& stream = {});
  ZoneStream(ZoneStream&&) noexcept;
  ZoneStream& operator=(ZoneStream&&) noexcept;
  ~ZoneStream();

  /// Returns the image's zone as of now. Throws Error unless the descriptor holds one probability a label.
  int add(DescriptorView descriptor);

  /// Links and cuts again by all images so far.
  void update();

  /// The zones of all images so far, numbered by size as findZones() does; `sequence` holds these images.
  /// Throws Error as describeZones() does, and invalidOption for more zones than images.
  Zones finish(const DescriptorSequence& sequence);

  std::size_t images() const;
  std::size_t groups() const;
  /// τ_d of the last linking.
  double cut() const;
  const std::string& cutReason() const;
  std::size_t zoneCount() const;
  /// Zone of every image so far.
  std::vector<int> zoneOf() const;
  /// By falling size.
  std::vector<StreamedZone> zones() const;
  /// The most distinctive labels of a zone. Throws Error (unknownName) when there is none of that number.
  std::string nameOf(int zone) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace estancia
