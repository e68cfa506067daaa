// What the thesis measured of recognition in noise (Tables 2.2 to 2.17): percent of its 49 pairs that the
// verification says yes to. Its data is ours, but for one scene.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace estancia::experiments {

/// The order of the tables' rows …
const std::vector<std::string>& thesisModelFilters();
const std::vector<double>& thesisNoises();  ///< standard deviation [m]

/// … and columns: filter of the scene, and points that it leaves; 0 for all.
const std::vector<std::pair<std::string, std::size_t>>& thesisSceneFilters();

/// Measured: Tables 2.2–2.4, 2.7–2.9, 2.12–2.14.
struct ThesisCells {
  std::string descriptor, keypoint, table;
  std::array<int, 162> percent;  ///< [(model filter · 6 + noise) · 9 + scene filter]
};
const std::vector<ThesisCells>& thesisCells();

/// Printed means over the keypoint detectors, and over the noise levels besides: Tables 2.5, 2.6; 2.10, 2.11;
/// 2.15, 2.16.
struct ThesisMeans {
  std::string descriptor;
  std::string table;
  std::array<int, 162> percent;  ///< as ThesisCells
  std::string tableOfSizes;
  std::array<int, 27> percentOfSizes;  ///< [model filter · 9 + scene filter]
};
const std::vector<ThesisMeans>& thesisMeans();

/// Printed in Table 2.17.
struct ThesisOverall {
  std::string descriptor, keypoint;
  std::array<double, 3> percent;  ///< of scenes that are not filtered, by GNG, by a voxel grid
};
const std::vector<ThesisOverall>& thesisOverall();

}  // namespace estancia::experiments
