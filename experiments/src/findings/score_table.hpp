// Tables of what methods reached in tests.
#pragma once

#include <filesystem>
#include <string>

#include "estancia/stats/method_comparison.hpp"

namespace estancia::experiments {

/// Reads a CSV of either layout, told apart by its head:
///  * wide: a row a test, its name first, then a column a method, which the head names;
///  * long, as experiments on scenes write: a row a score, with columns descriptor, classifier, train, test
///  and
///    `score` (others are ignored), in any order. Methods are called "descriptor/classifier", tests
///    "train→test".
/// Methods and tests stand in the order of their first row. Throws Error naming line and column of what is no
/// number, has the wrong number of cells, or comes twice; and when scores are missing (an empty cell, "–",
/// "nan" or "n/a" is one, too), saying which method lacks which test.
MethodScores readScores(const std::filesystem::path& file, const std::string& score = "accuracy");

}  // namespace estancia::experiments
