// Parallel for: the same work for many items, on several threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "estancia/core/progress.hpp"

namespace estancia {

/// Calls work(i) for all i below `count`, on `threads` threads. Stops early after an exception and throws
/// that of the lowest i.
void inParallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work);

/// Runs on `threads` threads (0: one a usable core), advancing `progress`. Throws Interrupted (`stopped`).
void inParallel(std::size_t count, int threads, Progress& progress, const std::string& stopped,
                const std::function<void(std::size_t)>& work);

}  // namespace estancia
