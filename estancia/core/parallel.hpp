// The same work for many things, on several threads.
#pragma once

#include <cstddef>
#include <functional>

namespace estancia {

/// Calls work(i) for all i below `count`, on `threads` threads. Stops early after an exception and throws
/// that of the lowest i.
void inParallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work);

}  // namespace estancia
