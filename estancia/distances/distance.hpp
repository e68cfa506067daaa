// Distances between lexical descriptors: embeddings and comparisons, chosen by name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// The space in which descriptors are compared.
enum class Embedding {
  /// The probabilities themselves.
  identity,
  /// √p: the Euclidean distance is Hellinger's.
  squareRoot,
  /// p − mean(p): the cosine is Pearson's correlation.
  centered,
  /// The cumulative sum of p in the order of the labels: the distribution function.
  cumulative,
  /// ln p − mean(ln p): Aitchison's geometry of compositions.
  centeredLogRatio
};

enum class Comparison {
  /// Σ w d² / Σ w (thesis Eq. 4.5).
  meanSquare,
  /// Its root, as the thesis' program computed it.
  rootMeanSquare,
  /// Σ |d|
  l1,
  /// √Σ d²
  euclidean,
  /// max |d| (thesis Eq. 5.1); with weights max w|d| / mean w.
  chebyshev,
  /// ½ Σ d² / (a + b)
  chiSquared,
  /// −ln of the coefficient Σ a b of unit vectors √p.
  bhattacharyya,
  /// Σ (a − b) ln((a + ε) / (b + ε)), both directions added up (Jeffreys), ε = clrFloor.
  kullbackLeibler,
  /// The root of ½ Σ a ln(a / m) + b ln(b / m), m = (a + b) / 2: a metric, natural logarithm.
  jensenShannon,
  /// 1 − cos, in [0, 2].
  cosine
};

/// A named distance between a place (or an image) and an image.
struct Distance {
  std::string name;
  Embedding embedding;
  Comparison comparison;
  /// Labels are first centered and scaled by the run's mean and σ.
  bool standardized = false;
  /// Labels that vary within the node have less weight.
  bool sigmaWeighted = false;
  /// The parts of descriptors of several models: each is embedded by itself, and with the cosine compared by
  /// itself, so that the distance is Σ w d_part / Σ w. One or none: the whole.
  std::vector<LabelPart> parts;
  /// τ_join while a run is too short to estimate its own; of the order of those estimates.
  double tauJoin = 0;
  std::string explanation;
};

/// All base distances. Each but the two "weighted" ones also has a σ-weighted form `NAME-sigma`.
const std::vector<Distance>& baseDistances();

/// The names of all distances, σ-weighted forms included.
Choices distances();

/// By name, with or without `-sigma`, for descriptors of these parts. Throws Error (unknownName).
Distance getDistance(std::string_view name, const std::vector<LabelPart>& parts = {});

/// Added to probabilities before their logarithm. A float32 softmax still resolves such values.
inline constexpr float clrFloor = 1e-7F;

/// The probability of the labels that are missing (0) from a descriptor or a part: a softmax has no zeros,
/// but a labeler that returns its best labels only leaves 0 for the others. Half of the least other one, as
/// for values below a detection limit (Hornung and Reed, Appl. Occup. Environ. Hyg. 5, 1990);
/// docs/measured/missing-labels.md compares. 0 when no label is missing, or all are.
float missingProbability(std::span<const float> p);

/// Writes the embedded descriptor; `out` has p.size() values and may be p itself. Each part is centered or
/// summed up by itself: the confidence of one model carries no information about the labels of another.
/// Log-ratios of missing labels are those of missingProbability().
void embed(Embedding embedding, std::span<const float> p, std::span<float> out,
           std::span<const LabelPart> parts = {});

/// Compares two embedded vectors of equal length. `weights` is empty (all 1) or one value ≥ 0 a label;
/// weights are relative: scaling them all changes nothing. O(L).
double compare(Comparison comparison, std::span<const float> a, std::span<const float> b,
               std::span<const float> weights = {});

/// Σ a b, the hot loop under the others.
float dot(std::span<const float> a, std::span<const float> b);

}  // namespace estancia
