// A clock and a scale for the answers of strangers.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>

namespace estancia {

/// Cuts a TCP connection when a request takes too long or brings too much. Libraries' own timeouts
/// begin anew with every byte, and they keep every header that comes, so a server that dribbles, or one that
/// never ends, would hold us for ever. All functions may be called from any thread.
class Watchdog {
 public:
  Watchdog();
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// The connection from now on, also a new one in the middle of a request. Keeps a duplicate of the
  /// descriptor: its owner may close it at any time, and the number may then mean another file.
  void watch(int socket);

  enum class Verdict { fine, late, tooMuch };

  /// A request begins that may take so long and bring so many bytes.
  void start(std::chrono::milliseconds timeout, std::uint64_t mostBytes);
  /// It is over. The connection is forgotten unless it is to be kept for the next.
  Verdict stop(bool keep);

 private:
  void run();
  void forget();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<std::chrono::steady_clock::time_point> deadline_;  // while there is a request
  std::uint64_t mostBytes_ = 0, bytesBefore_ = 0;                  // before bytesBefore_: earlier requests'
  Verdict verdict_ = Verdict::fine;
  int socket_ = -1;
  bool ending_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace estancia
