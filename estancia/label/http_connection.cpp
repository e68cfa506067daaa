#include "estancia/label/http_connection.hpp"

#include <fmt/format.h>
#include <httplib.h>
#include <openssl/x509.h>

#include <algorithm>
#include <cstdint>

#include "estancia/core/error.hpp"
#include "estancia/core/no_sigpipe.hpp"
#include "estancia/label/watchdog.hpp"

namespace estancia {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kAround = std::size_t{1} << 20U;  // bytes of headers and TLS around an answer

std::string secondsOf(milliseconds time) {
  return fmt::format("{} s", std::chrono::duration<double>(time).count());
}

}  // namespace

class HttpConnection::Implementation {
 public:
  explicit Implementation(HttpEndpoint endpoint) : endpoint_(std::move(endpoint)), client_(endpoint_.server) {
    if (!client_.is_valid()) throw Error("`url` in model.toml names no server that can be asked; correct it");
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
    watchdog_.start(endpoint_.timeout, endpoint_.longestAnswer + kAround);
    const httplib::Result result = client_.send(request);
    const auto verdict = watchdog_.stop(client_.is_socket_open() != 0);
    if (result) {
      reply.status = result->status;
      reply.retryAfter = result->get_header_value("Retry-After");
      reply.location = result->get_header_value("Location");
      return reply;
    }
    client_.stop();
    reply.body.clear();
    if (tooLong || verdict == Watchdog::Verdict::tooMuch) {
      reply.problem = fmt::format("its answer is longer than {} bytes", endpoint_.longestAnswer);
      reply.hopeless = true;
    } else if (verdict == Watchdog::Verdict::late) {
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
        const long reason = client_.get_openssl_verify_result();
        reply.problem = fmt::format(
            "its certificate is refused: {}; for a service of your own, name the certificate that it is "
            "signed with as `ca` in model.toml",
            reason == X509_V_OK ? "it is made out for another host" : X509_verify_cert_error_string(reason));
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
