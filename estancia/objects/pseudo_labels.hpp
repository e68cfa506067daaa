// From what a labeler says of samples to the names that shapes are learned by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/objects/target_classes.hpp"

namespace estancia {

/// top: the likeliest word of each sample (thesis 6.3). voted: one word an instance, of the pooled answers
/// for all its samples. confident: as top, without the samples whose name is likely wrong by the held-out
/// opinion of a classifier of shapes (Northcutt, Jiang, Chuang, JAIR 70, 2021).
enum class PseudoLabeling { top, voted, confident };

/// Their names, each with one line of explanation.
std::vector<std::pair<std::string, std::string>> pseudoLabelings();
/// Throws Error listing the known ones.
PseudoLabeling getPseudoLabeling(const std::string& name);

/// One word a sample, −1: none, not to be learned from (nothing was said of it, or it is not believed; voted:
/// nothing was said of its whole instance). `instances` tells which samples show one thing; `shapes` (the
/// same samples) and `options` are for Naming::confident alone, which is as top where there are no two words
/// to tell apart, and does not doubt samples of a word that cannot be held out. Throws Error when the numbers
/// of samples differ; Interrupted.
std::vector<int> assignPseudoLabels(PseudoLabeling naming, const ClassProbabilities& shares,
                                    std::span<const int> instances, const Features& shapes,
                                    const ClassifierOptions& options, Progress& progress);

/// Label noise to be injected: `rate` of the samples of which something is said (0 … 1), chosen by `seed`,
/// swap the share of their likeliest word with that of another. view: each by itself; pair: always the next
/// word instead of any; instance: all samples of a thing alike, by the word that they have together. Of one
/// seed, those that a lower rate chooses are among those of a higher one. Throws Error on another rate.
enum class NoiseKind { view, pair, instance };
ClassProbabilities withNoise(const ClassProbabilities& shares, NoiseKind kind, double rate,
                             std::span<const int> instances, std::uint64_t seed);

}  // namespace estancia
