// Process group: child processes that are killed when their owner ends, however it ends.
#pragma once

#include <sys/types.h>

namespace estancia {

/// The leader of the group is a guard: a shell that reads a pipe which only we hold open. The kernel closes
/// the pipe when our process ends, also after SIGKILL; then the guard kills the group.
/// PR_SET_PDEATHSIG would not do: it kills the child but not the child's children, and it fires when the
/// thread ends that has started the child.
class ProcessGroup {
 public:
  /// Starts the guard. Throws Error when that cannot be done.
  ProcessGroup();
  ~ProcessGroup() { kill(); }
  ProcessGroup(const ProcessGroup&) = delete;
  ProcessGroup& operator=(const ProcessGroup&) = delete;

  /// The group's number, for posix_spawnattr_setpgroup().
  pid_t id() const { return guard_; }
  /// The guard kills this child as well, even if it has left the group.
  void include(pid_t child);
  /// Sends SIGKILL to all processes of the group. Children must still be waited for.
  void kill();

 private:
  pid_t guard_ = -1;
  // Our end of the pipe.
  int lifeline_ = -1;
};

}  // namespace estancia
