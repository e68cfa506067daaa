// Interrupts that are taken: for work that ends whole when it is asked to stop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace estancia {

/// Like interrupted(), and resets it. The next signal kills all the same.
bool takeInterrupt();

/// Requests an interrupt as a signal does; safe in signal handlers of other programs.
void requestInterrupt();

}  // namespace estancia
