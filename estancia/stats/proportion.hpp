// How sure a share of counted things is.
#pragma once

#include <cstddef>
#include <utility>

namespace estancia {

/// The 95 % interval of a probability of which `hits` in `trials` were seen (Wilson 1927, score interval): in
/// [0, 1], also for none or all. It takes the trials for independent. Throws Error when there are none, or
/// more hits than trials.
std::pair<double, double> wilsonInterval(std::size_t hits, std::size_t trials);

/// The same of a `share` that was seen in what is worth `trials` independent ones, whole or not. The interval
/// holds the share. Throws Error unless the share is in [0, 1] and the trials are more than 0.
std::pair<double, double> wilsonInterval(double share, double trials);

}  // namespace estancia
