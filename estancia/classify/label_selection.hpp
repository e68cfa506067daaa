// Label selection: the labels that distinguish rooms best (thesis 3.5.3, Fig. 3.11).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/describe/features.hpp"

namespace estancia {

/// mean, mutual-information, chi2.
Choices selectionCriteria();

/// The score of each column by a criterion; larger is better. From the frames whose room is known:
///  * mean: the column's mean, as in the thesis; needs no rooms, and takes all frames;
///  * mutual-information: of the room and the value, cut into `valueBins` bins of equally many frames [nats];
///  * chi2: Σ (o − e)² / e over rooms, o the sum of the values in a room, e its share of the frames times the
///    sum of all; values must not be negative.
/// Throws Error on an unknown criterion (unknownName), values that are not finite or negative (invalidInput),
/// or without a known room (insufficientData).
std::vector<double> columnScores(const Features& training, const std::string& criterion);

inline constexpr std::size_t valueBins = 8;

/// The `count` best columns, best first, equal ones in order. Throws Error (invalidInput), as columnScores().
std::vector<std::size_t> selectColumns(const Features& training, const std::string& criterion,
                                       std::size_t count);

/// Keeps only these columns of each frame, in the order of each part; empty parts are dropped. Room
/// classifiers that were trained on them find the columns in whole descriptors.
Features withColumns(const Features& features, std::vector<std::size_t> columns);

}  // namespace estancia
