// Independent tasks on several threads.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "estancia/core/progress.hpp"

namespace estancia {

/// Runs task(0) … task(count − 1), each once, on `threads` threads (0: one a usable core); the caller's own
/// thread tells `progress` of tasks done. The first exception of a task stops the others and is thrown again.
/// Throws Interrupted with the sentence `stopped` when the user asks to stop.
void inParallel(std::size_t count, int threads, Progress& progress, const std::string& stopped,
                const std::function<void(std::size_t)>& task);

/// The same in silence, to the end; of several exceptions that of the lowest number is thrown again.
void inParallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work);

}  // namespace estancia
