// Area numbers: areas that are found anew keep those that they had.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/areas/area_plan.hpp"
#include "estancia/areas/plan_areas.hpp"

namespace estancia {

/// Renumbers the areas so that those that lie where areas of `before` lay have their numbers, as far as
/// numbers have no gaps: by the floor that they share, most first. Does nothing where the two plans have
/// other cells or another floor.
void keepNumbers(PlannedFrames& planned, const AreaPlan& before);

}  // namespace estancia
