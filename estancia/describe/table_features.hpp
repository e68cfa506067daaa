// Feature table: numbers that other programs computed, as features to learn from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/describe/features.hpp"
#include "estancia/sequences/feature_table.hpp"

namespace estancia {

/// A part of the table is a histogram when it has several columns, no value is below 0, and all rows have the
/// same sum (up to 0.1 %, but for rows of zeros) but are not all equal (constant numbers may be anything);
/// else it is energies. Tables of the same column names have the same identity: classifiers of one fit both.
Features featuresOf(const FeatureTable& table);

/// Whether the part comes from a table.
bool isOfTable(const DescriptorPart& part);

/// The names of the columns of a table that hold only 0 and 1: often annotations rather than descriptors.
std::vector<std::string> binaryParts(const Features& features);

}  // namespace estancia
