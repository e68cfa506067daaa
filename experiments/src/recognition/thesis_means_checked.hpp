// Do the thesis' printed means follow from its own cells?
#pragma once

#include "experiments/src/findings/findings.hpp"

namespace estancia::experiments {

/// How far each table of means, and each row of Table 2.17, is from the means of the cells it is of.
ResultTable thesisMeansChecked();

}  // namespace estancia::experiments
