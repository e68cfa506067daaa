// SPDX-License-Identifier: Apache-2.0
#include "estancia/processes/processes.hpp"

#include <cstdio>

namespace estancia {

Processes joinProcesses() {
  Processes processes;
  if (auto ranks = joinMpiProcesses()) processes.queue = std::make_unique<WorkQueue>(std::move(ranks));
  if (!processes.speaks())
    for (std::FILE* stream : {stdout, stderr})
      if (std::freopen("/dev/null", "w", stream) == nullptr) std::fclose(stream);
  processes.progress = processes.speaks() ? makeStderrProgress() : std::make_unique<Progress>();
  return processes;
}

}  // namespace estancia
