// SPDX-License-Identifier: Apache-2.0
#include "estancia/processes/mpi_processes.hpp"

#include <fmt/format.h>

#include <cstdlib>

#include "estancia/core/error.hpp"
#include "estancia/core/home.hpp"
#include "estancia/core/module_function.hpp"

namespace estancia {
namespace {

/// Number of processes that Open MPI has started together, from its environment.
int startedTogether() {
  return std::atoi(environment("OMPI_COMM_WORLD_SIZE").c_str());
}

}  // namespace

#ifdef ESTANCIA_MPI_MODULE  // cmake/EstanciaModules.cmake

std::unique_ptr<MpiProcesses> joinMpiProcesses() {
  if (startedTogether() < 2) return nullptr;
  // Its symbols are shown to all, as Open MPI's own plugins look for them.
  const ModuleFunction join =
      moduleFunction(ESTANCIA_MPI_MODULE, ESTANCIA_MPI_FROM_BIN, "estanciaJoinRanks", true);
  if (join.address == nullptr)
    throw Error(
        ErrorCode::missingDependency,
        fmt::format(
            "mpirun started this, but Open MPI cannot be opened: {}; install the package "
            "estancia-mpi (in the source: script/bootstrap, and build again), or run it without mpirun",
            join.problem));
  std::unique_ptr<MpiProcesses> ranks(reinterpret_cast<MpiProcesses* (*)()>(join.address)());
  if (ranks == nullptr)
    throw Error(ErrorCode::missingDependency, "Open MPI cannot be started; see what mpirun says");
  return ranks;
}

#else

std::unique_ptr<MpiProcesses> joinMpiProcesses() {
  if (startedTogether() < 2) return nullptr;
  throw Error(ErrorCode::missingDependency,
              "mpirun started this, but this Estancia was built without Open MPI; install the package "
              "libopenmpi-dev (script/bootstrap does) and build again, or run it without mpirun");
}

#endif

}  // namespace estancia
