// Error isolation: an exception of any type from one frame costs that frame, not the run.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "estancia/core/error.hpp"

namespace estancia {

/// Call this in `catch (...)` around the work on one frame (or view, or cloud). Returns the exception in
/// flight as an Error: an Error as it is, any other std::exception with the frame's name before its message.
/// A strict run throws the result; any other run reports it and goes on without the frame. Throws again what
/// no frame is to blame for: Interrupted, Error (missingDependency), exceptions that are no std::exception,
/// and std::bad_alloc (also where OpenCV reports it). Readers check sizes before they allocate, so memory
/// that runs out is the machine's failure: a run without such frames would differ on another machine.
Error frameFailure(const std::string& frame);

}  // namespace estancia
