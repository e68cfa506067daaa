// Background thread: one whose work may wait, beside the frames'. Where its priority cannot be changed, it is
// a thread like others. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <ctime>

namespace estancia {

/// This thread has a tenth of a processor where others want all.
inline void takeATenth() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 10);
}

/// This thread has what others leave, a third of a hundredth at least. A forward pass wakes its threads
/// hundreds of times; each time one of them would wait some ms for a thread that is merely nice, and the pass
/// would take twice as long.
inline void takeWhatIsLeft() {
  const sched_param none{};
  sched_setscheduler(0, SCHED_IDLE, &none);
}

/// Processor time of this thread. On a busy machine a thread of low priority takes many times as long by the
/// clock, which is no reason to do its work less often.
inline std::chrono::nanoseconds processorTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace estancia
