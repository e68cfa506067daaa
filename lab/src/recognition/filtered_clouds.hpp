// Filtered clouds: a cache on disk, as filtering takes longer than reading.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "estancia/cloud/filter.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"

namespace estancia::experiments {

/// A folder of clouds, each a file that is there whole or not at all; several threads and processes may share
/// it. The oldest are removed when it grows too large. A damaged file counts as absent.
class FilteredClouds {
 public:
  struct Filtered {
    PointCloud cloud;
    /// Duration of filtering when the cloud was made.
    double seconds = 0;
  };

  /// The folder is made when it is needed. `maxBytes` = 0 keeps nothing.
  FilteredClouds(std::filesystem::path folder, std::uint64_t maxBytes);

  /// The cloud that `source` gives, filtered. `origin` identifies all that the source depends on. Throws what
  /// filterCloud(), `source` and writing throw.
  Filtered get(const std::string& origin, const FilterOptions& filter,
               const std::function<PointCloud()>& source) const;

  /// All that a filter's result depends on.
  static std::string describe(const FilterOptions& filter);

 private:
  void makeRoom() const;

  std::filesystem::path folder_;
  std::uint64_t maxBytes_;
};

}  // namespace estancia::experiments
