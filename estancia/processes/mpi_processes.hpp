// MPI processes: those of one command that mpirun started side by side.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace estancia {

/// A process among its like, numbered from 0. They only exchange short texts; any thread may.
class MpiProcesses {
 public:
  /// Maximum size of a text.
  static constexpr std::size_t maxBytes = 4000;

  struct Message {
    int from;
    std::string text;
  };

  virtual ~MpiProcesses() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  virtual void send(int to, const std::string& text) = 0;
  /// The next text, in the order that each sender sent them; nothing when none comes in time.
  virtual std::optional<Message> receive(std::chrono::milliseconds patience) = 0;
  /// Waits until all leave; then nothing can be sent any more.
  virtual void leave() = 0;
};

}  // namespace estancia
