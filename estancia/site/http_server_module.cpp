// The module with cpp-httplib; http_server.cpp opens it.
// SPDX-License-Identifier: Apache-2.0
#include <httplib.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <string_view>
#include <thread>

#include "estancia/core/ascii.hpp"
#include "estancia/site/http_server.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;

/// A connection, with bounds on bytes and time that httplib does not have: of a request's head and body
/// together, of the time until it has come, and of the time that an answer is waited for. Life cycle:
/// waitForRequest(), beginRequest(), reads and writes of one request, again for the next one; drain() at the
/// end. Invariant: a request reads at most `left_` more bytes and nothing after `until_`.
class BoundedStream final : public httplib::Stream {
 public:
  BoundedStream(int socket, const HttpLimits& limits, const std::atomic<bool>& stopping)
      : socket_(socket), limits_(limits), stopping_(stopping) {}

  /// Whether something comes in time.
  bool waitForRequest() { return at_ < size_ || wait(POLLIN, deadline()); }
  void beginRequest() {
    left_ = limits_.head + limits_.body;
    until_ = deadline();
  }
  /// Whether the other side has gone.
  bool isGone() const {
    pollfd state{socket_, POLLRDHUP, 0};
    return ::poll(&state, 1, 0) > 0 && (state.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
  }

  bool is_readable() const override { return at_ < size_ || wait(POLLIN, until_); }
  bool is_writable() const override { return wait(POLLOUT, deadline()); }
  ssize_t read(char* to, std::size_t size) override {
    if (at_ == size_ && !fill()) return -1;
    const std::size_t count = std::min({size, size_ - at_, left_});
    if (count == 0) return -1;  // more than a request may have
    std::copy_n(buffer_.data() + at_, count, to);
    at_ += count;
    left_ -= count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* from, std::size_t size) override {
    const auto until = deadline();
    for (std::size_t done = 0; done < size;) {
      if (!wait(POLLOUT, until)) return -1;
      const ssize_t sent = ::send(socket_, from + done, size - done, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0 && errno != EAGAIN && errno != EINTR) return -1;
      if (sent > 0) done += static_cast<std::size_t>(sent);
    }
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override { ip.clear(), port = 0; }
  void get_local_ip_and_port(std::string& ip, int& port) const override { ip.clear(), port = 0; }
  socket_t socket() const override { return socket_; }

  /// Reads what is still coming, for a while: closing a socket with unread data discards what was sent.
  void drain() {
    ::shutdown(socket_, SHUT_WR);
    const auto until = Clock::now() + std::chrono::seconds(1);
    for (std::size_t taken = 0; taken < limits_.body * 4 && wait(POLLIN, until);) {
      const ssize_t got = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
      if (got <= 0) return;
      taken += static_cast<std::size_t>(got);
    }
  }

 private:
  Clock::time_point deadline() const {
    return Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limits_.patience));
  }
  bool wait(short what, Clock::time_point until) const {
    constexpr std::int64_t slice = 200;  // [ms] until the end of the server is seen
    while (!stopping_) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
      if (left <= 0) return false;
      pollfd state{socket_, what, 0};
      const int count = ::poll(&state, 1, static_cast<int>(std::min(left, slice)));
      if (count > 0) return (state.revents & what) != 0;
      if (count < 0 && errno != EINTR) return false;
    }
    return false;
  }
  bool fill() {
    if (!wait(POLLIN, until_)) return false;
    const ssize_t got = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    at_ = 0;
    size_ = got > 0 ? static_cast<std::size_t>(got) : 0;
    return got > 0;
  }

  int socket_;
  const HttpLimits& limits_;
  const std::atomic<bool>& stopping_;
  std::array<char, 4096> buffer_{};
  std::size_t at_ = 0, size_ = 0, left_ = 0;
  Clock::time_point until_;
};

/// The request that this thread serves.
struct Serving {
  BoundedStream* stream = nullptr;
  /// Where the next request begins is known only after one that was read whole.
  bool mustClose = true;
  /// There are connections enough.
  bool isRefused = false;
};
thread_local Serving serving;

/// A thread for each connection, up to a number; more are answered at once that they are too many.
class ConnectionThreads final : public httplib::TaskQueue {
 public:
  explicit ConnectionThreads(std::size_t most) : most_(most) {}

  void enqueue(std::function<void()> work) override {
    {
      const std::lock_guard lock(mutex_);
      serving.isRefused = running_ >= most_;
      if (!serving.isRefused) ++running_;
    }
    if (serving.isRefused) return work();
    try {
      std::thread([this, work] {
        ::setpriority(PRIO_PROCESS, 0, 10);  // on Linux of this thread: the mapping goes first
        work();
        end();
      }).detach();
    } catch (const std::system_error&) {
      serving.isRefused = true;
      work();
      end();
    }
  }
  void shutdown() override {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return running_ == 0; });
  }

 private:
  void end() {
    const std::lock_guard lock(mutex_);
    --running_;
    ended_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable ended_;
  std::size_t running_ = 0, most_;
};

ServerRequest requestOf(const httplib::Request& from) {
  ServerRequest request{from.method == "HEAD" ? "GET" : from.method, from.path, from.params};
  for (const auto& [name, value] : from.headers) request.headers.emplace(lowerCase(name), value);
  request.body = from.body;
  return request;
}

void put(ServerResponse from, httplib::Response& to) {
  to.status = from.status;
  for (const auto& [name, value] : from.headers) to.set_header(name, value);
  if (!from.events) return to.set_content(from.body, from.type);
  to.set_chunked_content_provider(from.type,
                                  [next = std::move(from.events)](std::size_t, httplib::DataSink& sink) {
                                    if (serving.stream->isGone()) return false;
                                    const std::optional<std::string> part = next();
                                    if (!part) sink.done();
                                    return !part || part->empty() || sink.write(part->data(), part->size());
                                  });
}

/// Whether a single header gives the length of the body, and in digits only (RFC 9112, 6.3).
bool isFramedOnce(const httplib::Request& request) {
  const std::size_t lengths = request.get_header_value_count("Content-Length");
  const std::string length = request.get_header_value("Content-Length");
  return lengths == 0 || (lengths == 1 && !request.has_header("Transfer-Encoding") && !length.empty() &&
                          length.find_first_not_of("0123456789") == std::string::npos);
}

ServerResponse ambiguousLength() {
  return {
      400, "application/json",
      R"({"error":{"code":"invalid-input","message":"one Content-Length, in digits, must say the length"}})"};
}

class BoundedServer final : public httplib::Server {
 public:
  BoundedServer(HttpHandler& handler, const HttpLimits& limits) : handler_(handler), limits_(limits) {
    new_task_queue = [this] { return new ConnectionThreads(limits_.connections); };
    set_payload_max_length(limits_.body);
    // httplib would let another program listen at the same port.
    set_socket_options([](int socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    set_pre_routing_handler([this](const httplib::Request& from, httplib::Response& to) {
      const ServerRequest request = requestOf(from);
      auto refused = isFramedOnce(from) ? handler_.refusal(request) : ambiguousLength();
      const bool hasBody = from.has_header("Content-Length") || from.has_header("Transfer-Encoding");
      if (!refused && from.method == "POST") return HandlerResponse::Unhandled;
      serving.mustClose = hasBody;  // the body is not read
      if (serving.mustClose) to.set_header("Connection", "close");
      put(refused ? std::move(*refused) : handler_.answer(request), to);
      return HandlerResponse::Handled;
    });
    // Requests that httplib refuses by itself.
    set_error_handler([](const httplib::Request&, httplib::Response& to) {
      if (!to.body.empty() || to.status < 400) return;
      const char* body = R"({"error":{"code":"invalid-input","message":"no request of HTTP 1.1 that fits"}})";
      if (to.status == 413 || to.status == 414)
        body = R"({"error":{"code":"too-large","message":"the request is too large"}})";
      to.set_content(body, "application/json");
    });
    Post("[^]*", [this](const httplib::Request& from, httplib::Response& to) {
      serving.mustClose = false;
      put(handler_.answer(requestOf(from)), to);
    });
  }
  void endConnections() { stopping_ = true; }
  /// httplib lets five wait to be accepted: ten browsers that open a page would wait for seconds.
  void widenQueue() { ::listen(svr_sock_, 128); }

 private:
  bool process_and_close_socket(socket_t socket) override {
    if (serving.isRefused) {
      constexpr std::string_view busy =
          "HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";
      ::send(socket, busy.data(), busy.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      ::close(socket);
      return false;
    }
    const int yes = 1, buffer = 65536;  // [bytes] what is sent to a slow browser must not be old
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    BoundedStream stream(socket, limits_, stopping_);
    serving = {&stream, true, false};
    const auto simplify = [](httplib::Request& request) {
      request.ranges.clear();                    // each would copy the content
      request.headers.erase("Accept-Encoding");  // compressing costs more than it saves on these ways
    };
    while (stream.waitForRequest()) {
      stream.beginRequest();
      serving.mustClose = true;
      bool isClosed = false;
      if (!process_request(stream, false, isClosed, simplify) || isClosed || serving.mustClose) break;
    }
    stream.drain();
    ::close(socket);
    serving = {};
    return true;
  }

  HttpHandler& handler_;
  HttpLimits limits_;
  std::atomic<bool> stopping_ = false;
};

class HttplibServer final : public HttpServer {
 public:
  HttplibServer(HttpHandler& handler, const HttpLimits& limits) : server_(handler, limits) {}
  ~HttplibServer() override {
    server_.endConnections();
    if (!listening_.joinable()) return;
    while (!server_.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    server_.stop();
    listening_.join();
  }
  HttplibServer(const HttplibServer&) = delete;
  HttplibServer& operator=(const HttplibServer&) = delete;

  bool start(const std::string& address, int port) {
    port_ = port == 0 ? server_.bind_to_any_port(address) : server_.bind_to_port(address, port) ? port : -1;
    if (port_ < 0) return false;
    server_.widenQueue();
    listening_ = std::thread([this] { server_.listen_after_bind(); });
    return true;
  }
  int port() const override { return port_; }

 private:
  BoundedServer server_;
  int port_ = -1;
  std::thread listening_;
};

}  // namespace
}  // namespace estancia

/// Null where it cannot listen.
extern "C" __attribute__((visibility("default"))) estancia::HttpServer* estanciaMakeHttpServer(
    const std::string& address, int port, estancia::HttpHandler& handler,
    const estancia::HttpLimits& limits) {
  // httplib changes what a signal does to the whole program.
  struct sigaction before {};
  ::sigaction(SIGPIPE, nullptr, &before);
  auto server = std::make_unique<estancia::HttplibServer>(handler, limits);
  ::sigaction(SIGPIPE, &before, nullptr);
  return server->start(address, port) ? server.release() : nullptr;
}
