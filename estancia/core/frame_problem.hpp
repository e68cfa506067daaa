// Per-frame failure: whose fault an exception is, the frame's or the run's, and the sentence that tells of
// it.
#pragma once

#include <string>

namespace estancia {

/// Call this in `catch (...)` around the work on one frame (or view, or cloud): an exception of any type is
/// that frame's failure, and the run goes on without the frame. Returns the reason in one line: the message
/// of an Error; else `frame`, the frame's name, and what the exception says. Throws again what no frame is to
/// blame for: Interrupted, exceptions that are no std::exception, and running out of memory (std::bad_alloc,
/// also where OpenCV says it). The readers check sizes before they allocate, so memory that runs out is the
/// machine's: the next frames would fail as well, and which ones depends on the machine, so a run that
/// skipped them would quietly give other results.
std::string frameProblem(const std::string& frame);

}  // namespace estancia
