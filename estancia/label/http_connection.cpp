#include "estancia/label/http_connection.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <httplib.h>
#include <openssl/x509.h>
#include <unistd.h>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "estancia/core/error.hpp"
#include "estancia/core/no_sigpipe.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Shuts a socket down when a request takes too long. The library's own timeouts begin anew with every byte,
/// so a server that dribbles would hold us for ever.
class Watchdog {
 public:
  Watchdog() : thread_([this] { run(); }) {}
  ~Watchdog() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    changed_.notify_all();
    thread_.join();
    forget();
  }
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// A duplicate of our own: the library may close its descriptor, whose number may then be another file.
  void watch(int socket) {
    const std::lock_guard lock(mutex_);
    forget();
    socket_ = fcntl(socket, F_DUPFD_CLOEXEC, 0);
  }
  void forget() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }

  void start(milliseconds timeout) {
    const std::lock_guard lock(mutex_);
    deadline_ = Clock::now() + timeout;
    changed_.notify_all();
  }
  /// Whether the time was over.
  bool stop(bool keep) {
    const std::lock_guard lock(mutex_);
    const bool over = Clock::now() >= *deadline_;
    deadline_.reset();
    if (!keep) forget();
    return over;
  }

 private:
  void run() {
    constexpr milliseconds again{10};  // a name is looked up, another address tried …
    std::unique_lock lock(mutex_);
    while (!ending_) {
      if (!deadline_) {
        changed_.wait(lock);
      } else if (Clock::now() < *deadline_) {
        changed_.wait_until(lock, *deadline_);
      } else {
        if (socket_ >= 0) ::shutdown(socket_, SHUT_RDWR);
        changed_.wait_for(lock, again);
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Clock::time_point> deadline_;
  int socket_ = -1;
  bool ending_ = false;
  std::thread thread_;  // last: it uses all of the above
};

std::string secondsOf(milliseconds time) {
  return fmt::format("{} s", std::chrono::duration<double>(time).count());
}

}  // namespace

class HttpConnection::Implementation {
 public:
  explicit Implementation(HttpEndpoint endpoint) : endpoint_(std::move(endpoint)), client_(endpoint_.server) {
    if (!client_.is_valid())
      throw Error(fmt::format("cannot make a client for {}; check `url` and `ca`", endpoint_.server));
    client_.set_keep_alive(true);
    client_.set_follow_location(false);
    client_.set_url_encode(false);
    client_.set_decompress(false);  // a small packed answer could be a large one
    client_.set_tcp_nodelay(true);
    client_.set_connection_timeout(std::min(endpoint_.connectTimeout, endpoint_.timeout));
    client_.set_read_timeout(endpoint_.readTimeout);
    client_.set_write_timeout(endpoint_.readTimeout);
    client_.set_socket_options([this](socket_t socket) { watchdog_.watch(socket); });
    if (!endpoint_.certificates.empty()) client_.set_ca_cert_path(endpoint_.certificates.string());
  }

  HttpReply post(const std::string& body) {
    HttpReply reply;
    httplib::Request request;
    request.method = "POST";
    request.path = endpoint_.path;
    for (const auto& [name, value] : endpoint_.headers) request.headers.emplace(name, value);
    request.headers.emplace("Accept", "application/json");
    request.headers.emplace("Accept-Encoding", "identity");
    request.headers.emplace("Content-Type", endpoint_.contentType);
    request.body = body;
    bool tooLong = false;
    request.content_receiver = [&](const char* data, std::size_t count, std::uint64_t, std::uint64_t) {
      tooLong = reply.body.size() + count > endpoint_.longestAnswer;
      if (!tooLong) reply.body.append(data, count);
      return !tooLong;
    };
    const NoSigpipe quiet;
    watchdog_.start(endpoint_.timeout);
    const httplib::Result result = client_.send(request);
    const bool over = watchdog_.stop(client_.is_socket_open() != 0);
    if (result) {
      reply.status = result->status;
      reply.retryAfter = result->get_header_value("Retry-After");
      reply.location = result->get_header_value("Location");
      return reply;
    }
    client_.stop();
    reply.body.clear();
    if (tooLong) {
      reply.problem = fmt::format("its answer is longer than {} bytes", endpoint_.longestAnswer);
      reply.hopeless = true;
    } else if (over) {
      reply.problem = fmt::format("no whole answer within {}", secondsOf(endpoint_.timeout));
    } else {
      explain(result.error(), reply);
    }
    return reply;
  }

 private:
  void explain(httplib::Error error, HttpReply& reply) const {
    using Kind = httplib::Error;
    switch (error) {
      case Kind::Connection:
        reply.problem = "no connection";
        return;
      case Kind::ConnectionTimeout:
        reply.problem = fmt::format("no connection within {}",
                                    secondsOf(std::min(endpoint_.connectTimeout, endpoint_.timeout)));
        return;
      case Kind::SSLConnection:
        reply.problem = "no TLS connection; does it speak https?";
        return;
      case Kind::SSLLoadingCerts:
        reply.problem = "the file `ca` holds no certificates that can be read";
        reply.hopeless = true;
        return;
      case Kind::SSLServerVerification: {
        const long verdict = client_.get_openssl_verify_result();
        reply.problem = fmt::format(
            "its certificate is refused: {}; for a service of your own, name the certificate that it is "
            "signed with as `ca` in model.toml",
            verdict == X509_V_OK ? "it is made out for another host"
                                 : X509_verify_cert_error_string(verdict));
        reply.hopeless = true;
        return;
      }
      default:
        reply.problem =
            fmt::format("the connection broke, or was silent for {}", secondsOf(endpoint_.readTimeout));
    }
  }

  const HttpEndpoint endpoint_;
  Watchdog watchdog_;
  httplib::Client client_;  // after the watchdog, which its last connection still tells
};

HttpConnection::HttpConnection(HttpEndpoint endpoint)
    : implementation_(std::make_unique<Implementation>(std::move(endpoint))) {}
HttpConnection::~HttpConnection() = default;

HttpReply HttpConnection::post(const std::string& body) {
  return implementation_->post(body);
}

}  // namespace estancia
