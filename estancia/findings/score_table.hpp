// Score table: CSV of the scores of methods in tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "estancia/stats/method_comparison.hpp"

namespace estancia {

/// Reads a CSV of either layout, which the header decides:
///  * wide: one row per test, its name first, then one column per method;
///  * long, as experiments on scenes write it: one row per score, with the columns descriptor, classifier,
///    train, test and `score` in any order; others are ignored. Methods are named "descriptor/classifier",
///    tests "train→test".
/// Methods and tests keep the order of their first row. Throws Error `FILE:LINE: …` on cells that are no
/// numbers, wrong numbers of cells and repeated scores; and on missing scores (an empty cell, "–", "nan" and
/// "n/a" count as missing), naming method and test.
MethodScores readScores(const std::filesystem::path& file, const std::string& score = "accuracy");

}  // namespace estancia
