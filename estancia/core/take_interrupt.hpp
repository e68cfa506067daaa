// Interrupts that are taken: for work that ends whole when it is asked to stop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace estancia {

/// As interrupted(), and forgets it. The next signal kills all the same.
bool takeInterrupt();

/// As if a signal had asked to stop: for programs with handlers of their own, which may call it.
void requestInterrupt();

}  // namespace estancia
