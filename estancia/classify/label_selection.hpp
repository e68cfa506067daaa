// A few labels instead of all: which tell rooms apart (thesis 3.5.3, Fig. 3.11)?
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "estancia/describe/features.hpp"

namespace estancia {

/// mean, mutual-information, chi2, each with one line of explanation.
std::vector<std::pair<std::string, std::string>> selectionCriteria();

/// What a criterion gives each column; larger is better. Learned from the frames whose room is known:
///  * mean: the column's mean, as in the thesis; needs no rooms, and takes all frames;
///  * mutual-information: of the room and the value, cut into `valueBins` bins of equally many frames [nats];
///  * chi2: Σ (o − e)² / e over rooms, o the sum of the values in a room, e its share of the frames times the
///    sum of all; values must not be negative.
/// Throws Error on an unknown criterion (listing the known ones), values that are not finite, no known room.
std::vector<double> columnScores(const Features& training, const std::string& criterion);

inline constexpr std::size_t valueBins = 8;

/// The `count` best columns, best first; equal ones in their order. Throws Error, saying how many there are,
/// when `count` is 0 or more than that, or as columnScores() does.
std::vector<std::size_t> selectColumns(const Features& training, const std::string& criterion,
                                       std::size_t count);

/// The same frames with only these columns, each part's in its own order; parts without any are gone. Room
/// classifiers that learned from them find the columns again in whole descriptors.
Features withColumns(const Features& features, std::vector<std::size_t> columns);

}  // namespace estancia
