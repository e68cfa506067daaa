// Do the thesis' printed means follow from its own cells?
#pragma once

#include "estancia/core/findings.hpp"

namespace estancia {

/// How far each table of means, and each row of Table 2.17, is from the means of the cells it is of.
ResultTable thesisMeansChecked();

}  // namespace estancia
