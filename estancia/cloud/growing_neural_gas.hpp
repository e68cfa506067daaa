// Growing Neural Gas: a graph of so many neurons that follows the surface behind a noisy cloud.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

/// Defaults are the thesis'.
struct GngOptions {
  std::size_t neurons = 20000;             ///< stop at so many; at least 2
  std::size_t signalsPerInsertion = 2000;  ///< δ
  float winnerRate = 0.1F;                 ///< ε_w, of the way to the signal
  float neighborRate = 0.001F;             ///< ε_n
  double insertionDecay = 0.5;             ///< α: the part of their error that q and f keep
  double errorDecay = 0.995;       ///< γ: the part of its error that every neuron keeps at an insertion
  std::uint32_t maximalAge = 250;  ///< a_max: an edge that is older goes
  std::uint64_t seed = 1;          ///< of the signals
  double quantizationError = 0;    ///< stop below it [unit of the cloud]; 0: do not
  double seconds = 0;              ///< stop after so many; 0: do not. Such a result is not reproducible
};

enum class GngStop {
  neurons,            ///< as many as were asked for
  quantizationError,  ///< small enough
  seconds,            ///< the deadline
  points,   ///< the cloud has no more distinct points than neurons were asked for: they are the neurons
  stalled,  ///< for long as many neurons have gone as came: fewer than were asked for
};

/// The graph. `cloud` holds the neurons, unorganized; edge (a, b), a < b, joins neurons a and b.
struct NeuralGas {
  PointCloud cloud;
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< sorted
  std::vector<std::uint32_t> ages;                  ///< one an edge
  std::uint64_t signals = 0;                        ///< that it has seen
  double quantizationError = 0;  ///< root mean square distance of the finite points to their nearest neurons
  GngStop stop = GngStop::neurons;
};

/// Algorithm 2.1 of the thesis with Fritzke's rules (B. Fritzke: A growing neural gas network learns
/// topologies. NIPS 7, 1995): signals are drawn from the finite points of `cloud`; f is the neighbor of q
/// with the largest error. The same options and cloud give the same graph on any machine, unless `seconds`
/// cut it short. A cloud that has no more distinct points than `neurons` is its own best network: they come
/// back, each joined with its nearest. docs/measured/gng.md says how it is done and what it costs.
/// Throws Error when no point is finite or an option makes no sense; Interrupted.
NeuralGas growNeuralGas(const PointCloud& cloud, const GngOptions& options, Progress& progress);

}  // namespace estancia
