#include "estancia/label/watchdog.hpp"

#include <fcntl.h>
#include <linux/tcp.h>  // glibc's tcp_info ends before the count of bytes
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;

/// Bytes that came in over this connection so far.
std::uint64_t bytesReceived(int socket) {
  tcp_info info{};
  socklen_t size = sizeof(info);
  return getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 ? info.tcpi_bytes_received : 0;
}

/// At once and for good: after a mere shutdown() Linux goes on to deliver what the other side sends.
void cut(int socket) {
  ::shutdown(socket, SHUT_RDWR);
  sockaddr nobody{};
  nobody.sa_family = AF_UNSPEC;
  ::connect(socket, &nobody, sizeof(nobody));
}

}  // namespace

Watchdog::Watchdog() : thread_([this] { run(); }) {}

Watchdog::~Watchdog() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
  forget();
}

void Watchdog::watch(int socket) {
  const std::lock_guard lock(mutex_);
  forget();
  socket_ = fcntl(socket, F_DUPFD_CLOEXEC, 0);
  bytesBefore_ = 0;
}

void Watchdog::forget() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

void Watchdog::start(std::chrono::milliseconds timeout, std::uint64_t mostBytes) {
  const std::lock_guard lock(mutex_);
  deadline_ = Clock::now() + timeout;
  mostBytes_ = mostBytes;
  bytesBefore_ = socket_ >= 0 ? bytesReceived(socket_) : 0;
  verdict_ = Verdict::fine;
  changed_.notify_all();
}

Watchdog::Verdict Watchdog::stop(bool keep) {
  const std::lock_guard lock(mutex_);
  deadline_.reset();
  if (!keep) forget();
  return verdict_;
}

void Watchdog::run() {
  constexpr std::chrono::milliseconds betweenLooks{20};
  std::unique_lock lock(mutex_);
  while (!ending_) {
    if (!deadline_) {
      changed_.wait(lock);
      continue;
    }
    if (verdict_ == Verdict::fine && Clock::now() >= *deadline_) verdict_ = Verdict::late;
    if (verdict_ == Verdict::fine && socket_ >= 0 && bytesReceived(socket_) > bytesBefore_ + mostBytes_)
      verdict_ = Verdict::tooMuch;
    // Again and again: it may be about to try another address.
    if (verdict_ != Verdict::fine && socket_ >= 0) cut(socket_);
    const auto next = Clock::now() + betweenLooks;
    changed_.wait_until(lock, verdict_ == Verdict::fine ? std::min(next, *deadline_) : next);
  }
}

}  // namespace estancia
