// SPDX-License-Identifier: Apache-2.0
#include "estancia/processes/work_queue.hpp"

#include <cstdio>
#include <cstdlib>

#include "estancia/core/fail.hpp"
#include "estancia/core/home.hpp"
#include "estancia/core/module_function.hpp"

namespace estancia {
namespace {

/// The processes where mpirun has started several, by its environment; else null, and MPI is not touched.
std::unique_ptr<MpiProcesses> joinMpiProcesses() {
  if (std::atoi(environment("OMPI_COMM_WORLD_SIZE").c_str()) < 2) return nullptr;
#ifdef ESTANCIA_MPI_MODULE  // cmake/EstanciaModules.cmake
  // Its symbols are shown to all, as Open MPI's own plugins look for them.
  const ModuleFunction join =
      moduleFunction(ESTANCIA_MPI_MODULE, ESTANCIA_MPI_FROM_BIN, "estanciaJoinRanks", true);
  if (join.address == nullptr)
    fail(ErrorCode::missingDependency,
         "mpirun started this, but Open MPI cannot be opened: {}; install the package estancia-mpi (in the "
         "source: script/bootstrap, and build again), or run it without mpirun",
         join.problem);
  std::unique_ptr<MpiProcesses> ranks(reinterpret_cast<MpiProcesses* (*)()>(join.address)());
  if (ranks == nullptr)
    throw Error(ErrorCode::missingDependency, "Open MPI cannot be started; see what mpirun says");
  return ranks;
#else
  throw Error(ErrorCode::missingDependency,
              "mpirun started this, but this Estancia was built without Open MPI; install the package "
              "libopenmpi-dev (script/bootstrap does) and build again, or run it without mpirun");
#endif
}

}  // namespace

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
