// SIGPIPE guard: a write to a closed pipe or socket fails with EPIPE and does not end the program.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>
#include <ctime>

namespace estancia {

/// While it lives, a write of this thread to a closed pipe or socket fails with EPIPE and raises no SIGPIPE,
/// which would end the program. A library may not change the signal's action for everybody.
class NoSigpipe {
 public:
  NoSigpipe() {
    sigset_t pending;
    sigpending(&pending);
    wasPending_ = sigismember(&pending, SIGPIPE) == 1;
    sigset_t pipe = onlySigpipe();
    pthread_sigmask(SIG_BLOCK, &pipe, &before_);
  }
  ~NoSigpipe() {
    const sigset_t pipe = onlySigpipe();
    const timespec now{0, 0};
    if (!wasPending_)
      while (sigtimedwait(&pipe, nullptr, &now) == SIGPIPE) {
      }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoSigpipe(const NoSigpipe&) = delete;
  NoSigpipe& operator=(const NoSigpipe&) = delete;

 private:
  static sigset_t onlySigpipe() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGPIPE);
    return set;
  }

  sigset_t before_{};
  bool wasPending_ = false;
};

}  // namespace estancia
