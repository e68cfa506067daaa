// Distances between distributions over words, chosen by name.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace estancia {

/// Where descriptors live while they are compared.
enum class Embedding {
  identity,        ///< the probabilities themselves
  squareRoot,      ///< √p: Euclidean distance there is Hellinger's
  centredLogRatio  ///< ln p − mean(ln p): Aitchison's geometry of compositions
};

enum class Comparison {
  meanSquare,      ///< Σ w d² / Σ w (thesis Eq. 4.5)
  rootMeanSquare,  ///< its root, as the thesis' program computed it
  l1,              ///< Σ |d|
  euclidean,       ///< √Σ d²
  chiSquared,      ///< ½ Σ d² / (a + b)
  bhattacharyya,   ///< −ln of the coefficient Σ a b of unit vectors √p
  cosine           ///< 1 − cos, in [0, 2]
};

/// A named way to compare a place (or an image) with an image.
struct Distance {
  std::string name;
  Embedding embedding;
  Comparison comparison;
  bool standardized = false;   ///< labels are centred and scaled by the run's own mean and σ first
  bool sigmaWeighted = false;  ///< labels that vary inside the node weigh less
  double tauJoin = 0;  ///< τ_join while a run is too short to find its own, of the order that runs find
  std::string explanation;
};

/// All base distances. Each but the two "weighted" ones also has a σ-weighted form `NAME-sigma`.
const std::vector<Distance>& baseDistances();

/// By name, with or without `-sigma`. Throws Error listing the known names.
Distance getDistance(std::string_view name);

/// Probabilities below this count as this: the least that a float32 softmax of a thousand labels still means.
inline constexpr float clrFloor = 1e-5F;

/// Writes the embedded descriptor; `out` has p.size() values and may be p itself.
void embed(Embedding embedding, std::span<const float> p, std::span<float> out);

/// Compares two embedded vectors of equal length. `weights` is empty (all 1) or one value ≥ 0 a label;
/// weights are relative: scaling them all changes nothing. O(L).
double compare(Comparison comparison, std::span<const float> a, std::span<const float> b,
               std::span<const float> weights = {});

/// Σ a b, the hot loop under the others.
float dot(std::span<const float> a, std::span<const float> b);

}  // namespace estancia
