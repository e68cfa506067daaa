// Distances between distributions over words, chosen by name.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// Where descriptors live while they are compared.
enum class Embedding {
  identity,         ///< the probabilities themselves
  squareRoot,       ///< √p: Euclidean distance there is Hellinger's
  centered,         ///< p − mean(p): a cosine there is Pearson's correlation
  cumulative,       ///< p summed up from the first label on: the distribution function
  centeredLogRatio  ///< ln p − mean(ln p): Aitchison's geometry of compositions
};

enum class Comparison {
  meanSquare,      ///< Σ w d² / Σ w (thesis Eq. 4.5)
  rootMeanSquare,  ///< its root, as the thesis' program computed it
  l1,              ///< Σ |d|
  euclidean,       ///< √Σ d²
  chebyshev,       ///< max |d| (thesis Eq. 5.1); with weights max w|d| / mean w
  chiSquared,      ///< ½ Σ d² / (a + b)
  bhattacharyya,   ///< −ln of the coefficient Σ a b of unit vectors √p
  kullbackLeibler,  ///< Σ (a − b) ln((a + ε) / (b + ε)), both directions added up (Jeffreys), ε = clrFloor
  jensenShannon,  ///< the root of ½ Σ a ln(a / m) + b ln(b / m), m = (a + b) / 2: a metric, natural logarithm
  cosine          ///< 1 − cos, in [0, 2]
};

/// A named way to compare a place (or an image) with an image.
struct Distance {
  std::string name;
  Embedding embedding;
  Comparison comparison;
  bool standardized = false;   ///< labels are centered and scaled by the run's own mean and σ first
  bool sigmaWeighted = false;  ///< labels that vary inside the node weigh less
  /// The parts that descriptors are made of (several models): each is embedded by itself, and with the cosine
  /// compared by itself, so that the distance is Σ w d_part / Σ w. One or none: the whole.
  std::vector<LabelPart> parts;
  double tauJoin = 0;  ///< τ_join while a run is too short to find its own, of the order that runs find
  std::string explanation;
};

/// All base distances. Each but the two "weighted" ones also has a σ-weighted form `NAME-sigma`.
const std::vector<Distance>& baseDistances();

/// By name, with or without `-sigma`, for descriptors of these parts. Throws Error listing the known names.
Distance getDistance(std::string_view name, const std::vector<LabelPart>& parts = {});

/// Added to probabilities before their logarithm. A float32 softmax still tells such values apart.
inline constexpr float clrFloor = 1e-7F;

/// Writes the embedded descriptor; `out` has p.size() values and may be p itself. What is centered or summed
/// up is so in each of the parts: how sure one model is says nothing about the labels of another.
void embed(Embedding embedding, std::span<const float> p, std::span<float> out,
           std::span<const LabelPart> parts = {});

/// Compares two embedded vectors of equal length. `weights` is empty (all 1) or one value ≥ 0 a label;
/// weights are relative: scaling them all changes nothing. O(L).
double compare(Comparison comparison, std::span<const float> a, std::span<const float> b,
               std::span<const float> weights = {});

/// Σ a b, the hot loop under the others.
float dot(std::span<const float> a, std::span<const float> b);

}  // namespace estancia
