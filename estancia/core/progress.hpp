// Progress: how far long work is, and the user's wish to interrupt it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace estancia {

/// Receives how far a long piece of work is. The default does nothing, so a library call stays silent.
class Progress {
 public:
  virtual ~Progress() = default;
  /// `total` = 0 when the amount is not known.
  virtual void begin(const std::string& /*what*/, std::size_t /*total*/, std::size_t /*done*/ = 0) {}
  virtual void advance(std::size_t /*count*/ = 1) {}
  virtual void end() {}
  /// The silent default of every function that takes a Progress. Safe to share.
  static Progress& none();
};

/// A bar with rate and time left when stderr is a terminal; otherwise a plain line every few seconds.
std::unique_ptr<Progress> makeStderrProgress();

/// Clears the line that a bar has left on the terminal, before something else is printed there: the bar is
/// drawn again as the work goes on.
void clearProgressLine();

/// Makes Ctrl-C (SIGINT) and SIGTERM set a flag instead of killing the process. The second one kills, and so
/// does the first where no loop asks for five seconds: files are as whole then as at any moment.
void catchInterrupts();

/// True once the user asked to stop. Long loops ask between frames.
bool interrupted();

}  // namespace estancia
