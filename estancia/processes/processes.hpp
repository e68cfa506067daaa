// Processes of one command, which mpirun started side by side: only the first one speaks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "estancia/core/progress.hpp"
#include "estancia/processes/work_queue.hpp"

namespace estancia {

struct Processes {
  /// Null where this one is alone.
  std::unique_ptr<WorkQueue> queue;
  std::unique_ptr<Progress> progress;

  bool speaks() const { return queue == nullptr || queue->isFirst(); }
};

/// To be asked once. Throws Error as joinMpiProcesses() does.
Processes joinProcesses();

}  // namespace estancia
