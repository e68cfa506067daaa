// A table of numbers that others computed, as features to learn from.
#pragma once

#include "estancia/describe/features.hpp"
#include "estancia/io/feature_table.hpp"

namespace estancia {

/// A part of the table is a histogram when it has several columns, no value is below 0, and all rows have the
/// same sum (up to 0.1 %; rows of zeros count nothing and do not matter) but are not all the same: constant
/// numbers may be anything, and below 0 elsewhere; else it is taken for energies.
/// Tables with columns of the same names give parts of the same identity, so that what one teaches fits the
/// other.
Features featuresOf(const FeatureTable& table);

/// Whether the part comes from a table.
bool isOfTable(const DescriptorPart& part);

}  // namespace estancia
