// Growing Neural Gas: a graph of neurons fitted to the surface of a noisy point cloud.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

/// Defaults are the thesis'.
struct GngOptions {
  /// Stop at this number.
  std::size_t neurons = 20000;
  /// λ of Fritzke, δ of the thesis.
  std::size_t signalsPerInsertion = 2000;
  /// ε_b of Fritzke, ε_w of the thesis: the share of the way to the signal.
  float winnerRate = 0.1F;
  /// ε_n.
  float neighborRate = 0.001F;
  /// α: the share of their error that q and f keep.
  double insertionDecay = 0.5;
  /// The share of its error that every neuron keeps at an insertion: d of Fritzke, γ of the thesis.
  double errorDecay = 0.995;
  /// a_max: older edges are removed.
  std::uint32_t maxAge = 250;
  /// 0: neurons follow positions only. Else signals have six dimensions, the position and CIELAB times a
  /// length: the spacing of the points by the noise of their colors, times this weight.
  double colorWeight = 0;
  /// Seed of the random signals.
  std::uint64_t seed = 1;
  /// Stop below it [unit of the cloud]; 0: never.
  double quantizationError = 0;
  /// Stop after this time; 0: never. Such a result is not reproducible.
  double seconds = 0;
};
OptionGroup declare(GngOptions& options);

/// Why growth ended.
enum class GngStop {
  /// The number of neurons was reached.
  neurons,
  /// The quantization error is small enough.
  quantizationError,
  /// The deadline.
  seconds,
  /// The cloud has no more distinct points than neurons were requested: the points are the neurons.
  points,
  /// For a long time as many neurons were removed as inserted: there are fewer than requested.
  stalled,
};

/// The graph. `cloud` holds the neurons, unorganized, with the mean colors of the points nearest to each, if
/// these have colors; edge (a, b), a < b, joins neurons a and b.
struct NeuralGas {
  PointCloud cloud;
  /// Sorted.
  std::vector<std::array<std::uint32_t, 2>> edges;
  /// One an edge.
  std::vector<std::uint32_t> ages;
  /// Number of signals shown.
  std::uint64_t signals = 0;
  /// Root mean square distance of the finite points to their nearest neurons; with a color weight in six
  /// dimensions.
  double quantizationError = 0;
  GngStop stop = GngStop::neurons;
};

/// Algorithm 2.1 of the thesis with Fritzke's rules (B. Fritzke: A growing neural gas network learns
/// topologies. NIPS 7, 1995): signals are drawn from the finite points of `cloud`; f is the neighbor of q
/// with the largest error. The graph depends on options and cloud only, on any machine, unless `seconds`
/// ended it. A cloud that has no more distinct points than `neurons` is its own best network: its points are
/// returned, each joined with its nearest. docs/measured/gng.md describes the implementation and its cost.
/// Throws Error (invalidInput, tooLarge, invalidOption) when no point is finite, there are 2³² points or
/// more, colors have a weight but the cloud none, or an option is out of range; Interrupted.
NeuralGas growNeuralGas(const PointCloud& cloud, const GngOptions& options,
                        Progress& progress = Progress::none());

}  // namespace estancia
