// Interrupts that are taken: for work that ends whole when it is asked to stop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace estancia {

/// As interrupted(), and forgets it. The next signal kills all the same.
bool takeInterrupt();

}  // namespace estancia
